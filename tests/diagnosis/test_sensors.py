"""A few sensors of different kinds: each may follow an effect in a measure of its own."""

import numpy as np
import pytest

from labrig.diagnosis import Opened, compare, diagnose, improve
from labrig.effects import rows_of
from labrig.effects._skin import by_sensor
from tests.sensors import model_of_both, two_sensors

RETARDED_S = 6.0


def retarded(lab):
    """What a strain that is behind the pressures by an exponent of a half has reached at the rows, (n, T, C), kPa.

    A Kohlrausch law (R. Kohlrausch, Pogg. Ann. Phys. 91 (1854) 179) between what it was at the hold's begin and now.
    """
    out, before = np.zeros_like(lab.u), np.zeros(lab.chambers)
    for i, row in enumerate(lab.u):
        left = np.exp(-np.sqrt(np.nan_to_num(lab.hold_s[i], nan=lab.long_s[-1]) / RETARDED_S))[:, None]
        out[i] = row + (before - row) * left
        before = out[i, -1]
    return out


def test_a_force_relaxes_while_an_angle_creeps(make_lab) -> None:
    """Nine per cent more of one sensor and five less of the other, both late in the same way, is creep and no other."""
    lab = make_lab(
        force=True,
        chambers=2,
        captures=60,
        rows_s=(1.0, 2.0, 4.0),
        long_s=(1.0, 3.0, 8.0, 20.0, 40.0),
        bent=0.0,
    )
    strain = (retarded(lab) @ lab.reach.T) / 60.0
    now = lab.predict(lab.u)
    first, second = now + 0.09 * strain + lab.noise(), now - 0.05 * strain + lab.noise()
    found = diagnose(two_sensors(lab, first, second), model_of_both(lab))
    assert found.summary["effects"] == ["creep"]


def test_what_is_in_no_figure_is_said(make_lab) -> None:
    """Errors are quoted in one unit; of the others it is said that they count, too."""
    lab = make_lab(force=True)
    force = lab.predict(lab.u) + lab.noise()
    said = compare(two_sensors(lab, force, force), model_of_both(lab)).summary["warnings"]
    line = "errors are those of what is in N; what is in V counts by its noise, for the verdict and in the sizes of"
    assert f"{line} effects" in said
    alone = compare(lab.dataset(force), lab.model()).summary["warnings"]
    assert not [line for line in alone if line.startswith("errors are those")]


def test_the_second_unit_is_the_one_that_is_said_where_errors_are_quoted_in_it(make_lab, few_effects) -> None:
    """What can't be seen is said in the unit of the errors, not in that of the first sensor."""
    few_effects("drift", "regulator", "creep")
    lab = make_lab(force=True)
    force = lab.predict(lab.u) + lab.noise()
    found = diagnose(two_sensors(lab, force, force + lab.noise() + 8.0), model_of_both(lab)).summary
    assert found["units"] == "V"
    (line,) = [w for w in found["warnings"] if "nothing that is smaller" in w]
    assert " V can be seen" in line


def test_what_helps_in_another_unit_helps(make_lab) -> None:
    """Creep that the voltage alone sees is added, though errors are quoted in newtons, which are off by far more."""
    lab = make_lab(force=True, chambers=2, captures=60, long_s=(3.0, 8.0, 20.0, 40.0))
    now = lab.predict(lab.u)
    crept = (retarded(lab) @ lab.reach.T) / 60.0
    bowed = 12 * np.sin(now / 8)
    run = two_sensors(lab, now + bowed + lab.noise(), now + 0.05 * crept + lab.noise())
    (fall,) = Opened(run, model := model_of_both(lab)).add(["creep"]).falls
    assert (fall.helps, fall.units) == (True, "V")
    assert improve(run, model, ["creep"]).summary["units"] == "N"


@pytest.mark.parametrize("name", ["creep", "leak", "delay", "hysteresis", "friction"])
def test_what_acts_in_the_skin_may_act_in_each_sensor(make_lab, name: str) -> None:
    """Of two sensors the family holds what they follow by opposite amounts; of one there is no such space."""
    lab = make_lab(force=True, long_s=(3.0, 8.0, 20.0))
    force = lab.predict(lab.u) + lab.noise()
    model = model_of_both(lab)
    effect = model.library()[name]
    both = {s.key: s for s in effect.family(model.context(rows_of(two_sensors(lab, force, force))))}
    (key,) = [key for key in both if key.endswith(", by place")]
    assert any(np.allclose(f.values[:, 0], -f.values[:, 1]) and f.values.any() for f in both[key].features)
    alone = effect.family(lab.model().context(rows_of(lab.dataset(force))))
    assert not [s.key for s in alone if s.key.endswith(", by place")]


def test_each_of_few_sensors_has_a_function(make_lab) -> None:
    """Two sensors have one each, which add up to nothing; of markers, and of a single sensor, there are none."""
    lab = make_lab(force=True)
    force = lab.predict(lab.u) + lab.noise()
    context = model_of_both(lab).context(rows_of(two_sensors(lab, force, force)))
    first, second = by_sensor(context, [("late", np.ones_like(context.base))])
    assert (first.values == -second.values).all()
    assert first.values.any()
    context = model_of_both(lab).context(
        rows_of(two_sensors(lab, force, np.nan))
    )  # of which one was never seen
    assert by_sensor(context, [("late", np.ones_like(context.base))]) == []
    context = lab.model().context(rows_of(lab.dataset(force)))
    assert by_sensor(context, [("late", np.ones_like(context.base))]) == []
    lab = make_lab()
    context = lab.model().context(rows_of(lab.dataset(lab.predict(lab.u) + lab.noise())))
    assert by_sensor(context, [("late", np.ones_like(context.base))]) == []


def test_errors_are_quoted_in_the_unit_that_is_off(make_lab) -> None:
    """Of two sensors the second, which drifts, is in the figures; what a rate is of is said as either unit."""
    lab = make_lab(force=True, chambers=2, captures=60, rows_s=(1.0, 3.0))
    force, later = lab.predict(lab.u), (np.arange(60) / 60)[:, None, None] ** 0.7
    off = 1.5 * later
    found = diagnose(two_sensors(lab, force + lab.noise(), force + off + lab.noise()), model_of_both(lab))
    assert found.summary["effects"] == ["drift"]
    assert found.summary["units"] == "V"
    assert found.summary["drop"] > 0.7
    assert found.improved is not None
    units = {p.unit for e in found.improved.file.effects for p in e.parameters.values()}
    assert any("(N or V)" in unit for unit in units)
