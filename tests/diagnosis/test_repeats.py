"""Set-points that are measured again at the end of a run: what drifted meanwhile is no noise."""

import numpy as np
import pytest

from labrig.diagnosis import diagnose, prepared, rows_from
from labrig.diagnosis._floor import capture_means
from labrig.diagnosis._repeats import beside_drift, pairs_of
from tests.naming import verdict_of


def again(make_lab, captures: int, repeated: int, seed: int = 3):
    """A force of two chambers, and the first set-points once more at the end."""
    lab = make_lab(
        force=True, chambers=2, captures=captures, rows_s=(1.0, 4.0, 11.0), repeats=False, seed=seed
    )
    lab.commanded[-repeated:] = lab.commanded[:repeated]
    return lab


def drifted(lab, kind: str) -> np.ndarray:
    """A force whose zero goes on with the root of time, or whose gain fades, by some five noises."""
    late = np.sqrt(lab.time_s / lab.time_s.max())[:, :, None]
    clean = lab.predict(lab.u)
    return clean + (1.5 * late if kind == "zero" else -0.06 * late**2 * clean) + lab.noise(capture=0.05)


@pytest.mark.parametrize(("captures", "repeated", "kind"), [(20, 6, "zero"), (30, 8, "gain")])
def test_a_drift_is_found_though_repeats_differ_by_it(
    make_lab, captures: int, repeated: int, kind: str
) -> None:
    """All repeats say the same of it, one by one, and are noisy beside it."""
    lab = again(make_lab, captures, repeated)
    found = verdict_of(lab.dataset(drifted(lab, kind)), lab.model())
    calls = {c.effect: c.call for c in found.considered}
    assert found.verdict in {"identified", "confounded"}
    assert calls["drift"] in {"sure", "possible"}


def test_nothing_is_missing_where_repeats_differ_by_noise(make_lab) -> None:
    """The same without a drift."""
    lab = again(make_lab, 30, 8)
    values = lab.predict(lab.u) + lab.noise(capture=0.05)
    assert verdict_of(lab.dataset(values), lab.model()).verdict == "nothing_missing"


@pytest.mark.parametrize("drift", [True, False])
def test_what_a_learner_knows_of_the_noise_is_said(make_lab, few_effects, drift: bool) -> None:
    """Two repeats cannot tell a drift from noise; that captures are predicted better than they repeat is said."""
    few_effects("drift", "creep", "regulator", "hysteresis")
    lab = again(make_lab, 22, 2)
    values = drifted(lab, "zero") if drift else lab.predict(lab.u) + lab.noise(capture=0.05)
    said = diagnose(lab.dataset(values), lab.model()).summary
    notes = [w for w in said["warnings"] if w.startswith("a flexible learner predicts captures")]
    assert bool(notes) == (drift and said["verdict"] == "nothing_missing")
    assert said["verdict"] == "nothing_missing" or not drift
    if notes:
        assert notes[0].endswith("so repeat some set-points at once, too")


def test_what_was_hardly_seen_twice_keeps_its_differences(make_lab) -> None:
    """Of a marker that few repeats saw a shift and a gain would take all that they differ by, and leave no noise."""
    lab = make_lab(chambers=2, markers=4, captures=40, repeats=False, seed=3)
    lab.commanded[-6:] = lab.commanded[:6]
    values = lab.predict(lab.u) + lab.noise()
    values[-4:, :, 3:6] = np.nan
    context = prepared(rows_from(lab.dataset(values)), lab.model()).context
    captures = np.unique(context.rows.capture)
    means = capture_means(context.residual, context.rows.capture)[0]
    pairs = list(pairs_of(context, captures))
    left, _ = beside_drift(context, means, captures, pairs, np.ones(12, dtype=bool))
    differ = np.array([means[b] - means[a] for kind, a, b in pairs if kind == "same history"])
    seen = np.isfinite(differ[:, 3])
    assert seen.sum() == 1
    assert left[seen, 3] == pytest.approx(differ[seen, 3])
    assert np.abs(left[:, 0]).min() > 0


def test_noise_is_as_large_beside_a_drift(make_lab) -> None:
    """What a shift and a gain take of the noise of a few repeats is given back."""
    lab = make_lab(chambers=2, markers=40, captures=30, repeats=False, seed=3)
    lab.commanded[-6:] = lab.commanded[:6]
    context = prepared(rows_from(lab.dataset(lab.predict(lab.u) + lab.noise())), lab.model()).context
    captures = np.unique(context.rows.capture)
    means = capture_means(context.residual, context.rows.capture)[0]
    pairs = list(pairs_of(context, captures))
    left, told = beside_drift(context, means, captures, pairs, np.ones(120, dtype=bool))
    assert told == len(left) - 2
    differ = np.array([means[b] - means[a] for kind, a, b in pairs if kind == "same history"])
    assert np.sqrt((left**2).mean()) == pytest.approx(np.sqrt((differ**2).mean()), rel=0.1)


@pytest.mark.parametrize("logged", ["room", "slow room", "oven", "stairs", "tilt", "shelf", "plug"])
def test_the_temperature_of_a_room_makes_no_other_set_point(make_lab, logged: str) -> None:
    """It wanders, as the time does: what comes again in a warmer room is a repeat, however few digits are logged. In an
    oven that is set anew, at another tilt or another height of a stand it is none, nor on another shelf, which somebody
    moves now and then, nor with another plug, which he changes each time.
    """
    lab = again(make_lab, 30, 8)
    late = np.arange(30)
    room = 20.5 + 3 * late / 30 + 0.01 * np.sin(7.0 * late)
    name, unit, values = {
        "room": ("room", "degC", room),
        "oven": ("oven", "degC", 20.0 + 20 * (late // 10)),
        "stairs": ("stand", "mm", 1.0 * (late // 2)),
        "slow room": ("room", "degC", 20.5 + 0.02 * (late // 2)),
        "tilt": ("tilt", "deg", 1.0 * late),
        "shelf": ("shelf", "mm", 5.0 * (late // 5)),
        "plug": ("plug", "mm", 1.0 * (7 * late % 4)),
    }[logged]
    data = lab.dataset(lab.predict(lab.u) + lab.noise(capture=0.05), {name: (unit, values)})
    context = prepared(rows_from(data), lab.model()).context
    captures = np.unique(context.rows.capture)
    assert len(list(pairs_of(context, captures))) == (8 if "room" in logged else 0)
