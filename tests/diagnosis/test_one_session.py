"""One session of several, a specimen or a day, in which something is that is in no other: it is no noise, it keeps its
name, and the session is said."""

from typing import Any

import numpy as np
import pytest

from labrig.diagnosis import prepared, rows_from
from labrig.diagnosis._alone import _session, with_single
from labrig.diagnosis._diagnose import laid_out
from labrig.diagnosis._repeats import odd_sessions, pairs_of
from labrig.effects import Space, capture_means, pressure, rows_of
from tests.laws import orifice
from tests.naming import verdict_of

SESSIONS, CAPTURES = 5, 60
ALONE = "most of what is missing is in session s2 alone: make a run of it alone"


def specimens(make_lab, seed: int = 0, sessions: int = SESSIONS) -> Any:
    """A force of one chamber, the same set-points in each of the sessions."""
    lab = make_lab(
        force=True,
        chambers=1,
        captures=CAPTURES,
        sessions=sessions,
        rows_s=(1.0, 3.0, 8.0),
        repeats=False,
        bent=0.0,
        seed=seed,
    )
    lab.commanded[:] = np.tile(lab.commanded[: CAPTURES // sessions], (sessions, 1))
    return lab


def measured(lab: Any, pressures: np.ndarray | None, only: int | None = 2) -> np.ndarray:
    """What is measured where the pressures are others than those commanded, in one session alone or in all."""
    values = lab.predict(lab.u)
    if pressures is not None:
        own = np.ones(CAPTURES, dtype=bool) if only is None else lab.session == only
        values[own] = lab.predict(pressures)[own]
    return values + lab.noise(row=0.1, capture=0.03)


def test_a_specimen_that_sticks_is_no_noise(make_lab) -> None:
    """Its loop has the name that it has where all stick, or that of a friction, and the specimen is said."""
    lab = specimens(make_lab)
    found = verdict_of(lab.dataset(measured(lab, lab.looped(1.2))), lab.model())
    calls = {c.effect: c.call for c in found.considered}
    assert found.verdict != "nothing_missing"
    assert {calls["hysteresis"], calls["friction"]} & {"sure", "possible"}
    assert any(line.startswith(ALONE) for line in found.warnings)


def test_a_leak_of_one_day_is_a_leak(make_lab) -> None:
    """On the other days nothing leaks."""
    lab = specimens(make_lab)
    found = verdict_of(lab.dataset(measured(lab, orifice(lab))), lab.model())
    assert found.effects == ("leak",)
    assert any(line.startswith(ALONE) for line in found.warnings)


@pytest.mark.parametrize("leaks", [True, False])
def test_what_all_sessions_have_is_in_no_single_one(make_lab, leaks: bool) -> None:
    """Nor is anything, where nothing is missing."""
    lab = specimens(make_lab)
    values = measured(lab, orifice(lab) if leaks else None, None)
    found = verdict_of(lab.dataset(values), lab.model())
    assert found.effects == (("leak",) if leaks else ())
    assert not [line for line in found.warnings if "alone" in line]


def means_of(lab: Any, values: np.ndarray) -> tuple[Any, np.ndarray, np.ndarray]:
    """A context, the means of its captures beside the model, and the captures."""
    context = lab.model().context(rows_of(lab.dataset(values)))
    return context, *capture_means(context.residual, context.rows.capture)


@pytest.mark.parametrize("seed", range(4))
def test_the_session_that_differs_from_all_others_stands_apart(make_lab, seed: int) -> None:
    """Of five one is found, of equal ones none, and repeats within it still count."""
    lab = specimens(make_lab, seed)
    context, means, captures = means_of(lab, measured(lab, lab.looped(1.2), seed))
    assert odd_sessions(context, means, captures) == [seed]
    assert odd_sessions(*means_of(lab, measured(lab, None))) == []
    own = context.rows.session[np.searchsorted(context.rows.capture, captures)] == seed
    assert all(own[a] == own[b] for _, a, b in pairs_of(context, captures, [seed]))


def test_what_repeats_within_a_session_that_stands_apart_still_counts(make_lab) -> None:
    """Its own set-points that come again say the noise, as those of the others do."""
    lab = specimens(make_lab)
    lab.commanded[[30, 35]] = lab.commanded[24]
    context, _, captures = means_of(lab, measured(lab, None))
    pairs = {(a, b) for _, a, b in pairs_of(context, captures, [2])}
    assert {(24, 30), (30, 35)} <= pairs


def test_what_one_specimen_differs_by_is_in_no_floor(make_lab) -> None:
    """Of rows and of captures' means; what all of them together would say is more than twice as much."""
    lab = specimens(make_lab)
    floor = prepared(rows_from(lab.dataset(measured(lab, lab.looped(1.2)))), lab.model()).floor
    assert floor.mean == pytest.approx([np.hypot(0.1 / np.sqrt(3), 0.03)], rel=0.35)


def test_two_of_six_that_differ_stand_apart_both(make_lab) -> None:
    """One after the other, while three are left that agree."""
    lab = specimens(make_lab, sessions=6)
    values = measured(lab, lab.looped(1.5), 1)
    values[lab.session == 4] += 0.5
    assert sorted(odd_sessions(*means_of(lab, values))) == [1, 4]


def test_of_three_sessions_none_stands_apart(make_lab) -> None:
    """Which two are right no one can tell."""
    lab = specimens(make_lab, sessions=3)
    assert odd_sessions(*means_of(lab, measured(lab, lab.looped(1.2), 1))) == []


def test_the_session_that_most_of_it_is_in(make_lab) -> None:
    """Half of what is missing, or more; none where all have it, and none of two sessions."""
    lab, two = specimens(make_lab), specimens(make_lab, sessions=2)

    def session(lab: Any, only: int | None) -> str | None:
        data = lab.dataset(measured(lab, orifice(lab), only))
        one = _session(laid_out(prepared(rows_from(data), lab.model()), {})[1])
        return one and one.name

    assert session(lab, 3) == "s3"
    assert session(lab, None) is None
    assert session(two, 1) is None


def test_all_one_chamber_or_one_session_are_even_odds(make_lab) -> None:
    """Where both one chamber and one session may have it alone, each of the three is a third, whichever it is."""
    lab = make_lab(chambers=4, markers=8, captures=60, sessions=4, rows_s=(1.0, 3.0, 8.0))
    leaks = np.where((np.arange(4) == 1) & (lab.session == 2)[:, None, None], orifice(lab), lab.u)
    values = lab.predict(leaks) + lab.noise()
    observations = laid_out(prepared(rows_from(lab.dataset(values)), lab.model()), {})[1]
    x = observations.context.rows.fraction
    made = list(with_single(observations)("leak", Space("lost", "lost", (pressure("x", x),))))
    held = {space.alone_in: (space.rarer, space.features[0].values) for space in made}
    assert {name: rarer for name, (rarer, _) in held.items()} == {"": 3, "c2": 12, "session s2": 12}
    own = observations.context.rows.session == 2
    assert np.array_equal(held["session s2"][1], x * own[:, None])
    assert np.array_equal(held["c2"][1], x * [0, 1, 0, 0])
