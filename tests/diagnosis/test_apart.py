"""A few sensors of different kinds: what goes through the pressures of one need not go through another's."""

from dataclasses import replace

import numpy as np
import pytest

from labrig.diagnosis import diagnose, observe, prepared, rows_from
from labrig.diagnosis._directions import directions
from labrig.diagnosis._layout import Layout
from labrig.effects import Space, rows_of
from labrig.effects._skin import by_itself, per_sensor
from tests.laws import sliding
from tests.naming import verdict_of
from tests.sensors import model_of_both, two_sensors


def lab_of(make_lab, rows_s: tuple[float, ...], **settings):
    """Two chambers, a force, 60 set-points that lie anywhere."""
    return make_lab(force=True, chambers=2, captures=60, rows_s=rows_s, repeats=False, **settings)


@pytest.mark.parametrize(
    ("law", "effect", "rows_s"),
    [
        ("loop", "hysteresis", (3.0,)),
        ("slide", "friction", (1.0, 3.0, 8.0)),
    ],
)
def test_a_loop_in_the_force_alone_is_named(make_lab, law: str, effect: str, rows_s) -> None:
    """Chamber by chamber, in one of two sensors: one row a set-point is enough, and the other sensor has nothing."""
    lab = lab_of(make_lab, rows_s)
    u = lab.looped(4.0) if law == "loop" else sliding(lab)
    force, voltage = lab.predict(u) + lab.noise(), lab.predict(lab.u) + lab.noise()
    assert verdict_of(two_sensors(lab, force, voltage), model_of_both(lab)).effects == (effect,)


def test_its_formula_is_of_each_sensor_and_holds_on_a_shorter_run(make_lab) -> None:
    """What is saved says how much of the play each sensor has, by its name, and predicts a part of the run alike."""
    lab = lab_of(make_lab, (1.0, 3.0, 8.0), bent=0.0)
    force, voltage = lab.predict(lab.looped(4.0)) + lab.noise(), lab.predict(lab.u) + lab.noise()
    data, model = two_sensors(lab, force, voltage), model_of_both(lab)
    result = diagnose(data, model)
    assert result.improved is not None
    (entry,) = result.improved.file.effects
    assert (entry.name, entry.form) == ("hysteresis", "play per sensor")
    weight = entry.parameters["weight"]
    assert weight.per == ["force", "voltage"]
    of_force, of_voltage = np.asarray(weight.value)
    assert of_force > 20 * abs(of_voltage)
    assert result.summary["drop"] > 0.9
    whole = result.improved.context(rows_of(data)).base
    short = data.isel(capture=slice(0, 20), event=slice(0, 20))
    assert result.improved.context(rows_of(short)).base == pytest.approx(whole[: 20 * 3])


@pytest.mark.parametrize("name", ["creep", "delay", "hysteresis", "friction"])
def test_who_has_such_spaces(make_lab, name: str) -> None:
    """Two sensors have a space and forms of their own; of a single one, of one that was never seen, and of markers
    there are none."""
    lab = make_lab(force=True, long_s=(3.0, 8.0, 20.0))
    force = lab.predict(lab.u) + lab.noise()
    effect = lab.model().library()[name]

    def found(context) -> tuple[int, bool]:
        spaces = [s for s in effect.family(context) if s.apart is not None]
        assert all(s.key.endswith(", by sensor") for s in spaces)
        return len(spaces), any("per sensor" in v.form for v in effect.variants(context))

    assert found(model_of_both(lab).context(rows_of(two_sensors(lab, force, force)))) == (1, True)
    assert found(model_of_both(lab).context(rows_of(two_sensors(lab, force, np.nan)))) == (0, False)
    assert found(lab.model().context(rows_of(lab.dataset(force)))) == (0, False)
    lab = make_lab()
    markers = lab.model().context(rows_of(lab.dataset(lab.predict(lab.u) + lab.noise())))
    assert found(markers) == (0, False)


def test_a_formula_of_each_sensor_moves_that_one_alone(make_lab) -> None:
    """The coefficient of a sensor is what that sensor takes on of a change of the pressures, as the base says."""
    lab = make_lab(force=True, chambers=2)
    force = lab.predict(lab.u) + lab.noise()
    context = model_of_both(lab).context(rows_of(two_sensors(lab, force, force)))
    change = np.random.default_rng(3).normal(size=context.rows.actuation.shape)
    (term,) = per_sensor(context, "weight", change)
    assert term.labels == ("force", "voltage")
    moved = (context.jacobian * change[:, None]).sum(axis=2)
    for k in range(2):
        assert term.feature[:, k, k] == pytest.approx(moved[:, k])
        assert not term.feature[:, 1 - k, k].any()


def test_the_columns_of_a_space_by_sensor(make_lab) -> None:
    """Each sensor has the columns that the space would have were it alone; of both together they make one floor."""
    lab = lab_of(make_lab, (1.0, 3.0, 8.0))
    force = lab.predict(lab.u) + lab.noise()
    model = model_of_both(lab)
    ready = prepared(rows_from(two_sensors(lab, force, force + lab.noise())), model)
    observations = observe(ready.context, ready.residual, ready.floor)
    V, _ = directions(observations, ())
    layout = Layout(observations, V)
    (space,) = [s for s in model.library()["hysteresis"].family(ready.context) if s.apart is not None]
    assert space.apart is not None
    both = layout.apart(space, space.apart)
    assert both is not None
    S, r, _ = both.shape
    covariance = np.einsum("srq,tuq->srtu", both, both).reshape(S * r, S * r)
    wanted = np.zeros_like(covariance)
    for own in space.apart:
        one = layout.apart(space, own[None])
        assert one is not None
        assert np.abs(np.einsum("srq,kr->skq", one, V)[:, own == 0]).max() < 1e-12
        wanted += np.einsum("srq,tuq->srtu", one, one).reshape(S * r, S * r) / 2
    assert covariance == pytest.approx(wanted, abs=1e-2 * np.abs(wanted).max())
    none: Space = replace(space, features=tuple(replace(f, values=0 * f.values) for f in space.features))
    assert layout.apart(none, space.apart) is None


def test_markers_beside_a_sensor_are_one_group(make_lab) -> None:
    """A body's markers follow together, and the sensor beside them by itself."""
    lab = make_lab(chambers=2, markers=3)
    rows = rows_of(lab.dataset(lab.predict(lab.u) + lab.noise()))
    lone = np.array([*rows.marker[:-1], -1])
    context = lab.model().context(rows)
    context = replace(context, rows=replace(rows, marker=lone), _memo={})
    (space,) = by_itself(context, Space("any", "any", ()))
    assert space.apart is not None
    assert space.apart.sum(axis=1).tolist() == [1.0, len(lone) - 1.0]
