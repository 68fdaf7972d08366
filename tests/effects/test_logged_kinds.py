"""What was logged beside the observables: a payload, a tilt or a temperature, by its name and its unit."""

from dataclasses import replace

import numpy as np
import pytest

from labrig._errors import LabrigError
from labrig.effects import Context, Covariate, join_rows, rows_of
from labrig.effects._logged import is_payload, is_temperature, is_tilt, payloads_kg, tilts_rad
from labrig.effects._registry import shipped
from tests.effects.test_absolute import context_of


def logged(unit: str, *values: float) -> Covariate:
    """A covariate with these values."""
    return Covariate(unit, np.array(values))


@pytest.mark.parametrize(
    ("name", "unit", "size"),
    [
        ("payload", "kg", 1.0),
        ("tip load", "g", 1e-3),
        ("tipLoad", "mN", 1e-3 / 9.80665),
        ("weight_n", "N", 1 / 9.80665),
        ("mass", "lb", 0.45359237),
        ("Zusatz", "kg", 1.0),
        ("Gewicht", "N", 1 / 9.80665),
        ("mass_flow", "g/s", None),
        ("mass flow", "kg", None),
        ("download", "1", None),
        ("unloading valve", "deg", None),
        ("payload", "1", None),
        ("grip force", "N", None),
    ],
)
def test_a_payload_is_one_by_name_and_unit(
    lab_context: Context, name: str, unit: str, size: float | None
) -> None:
    """Words count, not parts of them, and a mass that flows or a load that is no weight pulls nothing down."""
    values = np.linspace(1.0, 2.0, len(lab_context.base))
    context = with_logged(lab_context, name, Covariate(unit, values))
    assert is_payload(name, context.rows.covariates[name]) == (size is not None)
    found = dict(payloads_kg(context))
    if size is None:
        assert found == {}
    else:
        np.testing.assert_allclose(found[name], values * size)
    assert (name in shipped()["gravity"].follows(context)) == (size is not None)


@pytest.mark.parametrize(
    ("name", "unit", "rad"),
    [
        ("tilt", "deg", np.pi / 180),
        ("mount tilt", "mrad", 1e-3),
        ("pitch_x", "rad", 1.0),
        ("angle", "1", 1.0),
        ("valve angle", "deg", None),
        ("tilt", "mm", None),
        ("attitude", "deg", None),
    ],
)
def test_a_tilt_is_one_by_name_and_unit(
    lab_context: Context, name: str, unit: str, rad: float | None
) -> None:
    """An angle of the rig counts in radians whatever its unit, and a valve's is none."""
    values = np.linspace(0.1, 0.4, len(lab_context.base))
    context = with_logged(lab_context, name, Covariate(unit, values))
    found = dict(tilts_rad(context))
    if rad is None:
        assert found == {}
    else:
        np.testing.assert_allclose(found[name], values * rad)
    assert is_tilt(name, context.rows.covariates[name]) == (rad is not None)


def test_degrees_without_a_unit_are_no_tilt() -> None:
    """A number without a unit is an angle in radians as long as it may be one."""
    assert is_tilt("tilt", logged("1", 0.2, -0.3))
    assert not is_tilt("tilt", logged("1", 10.0, 30.0))


def test_a_temperature_is_one_by_name_or_unit() -> None:
    """By its unit whatever it is called, or by a word; an attempt has none."""
    assert is_temperature("room", logged("degC", 20.0))
    for name in ("temp", "T_room_temp", "roomtemp", "tempC", "Temperature 2"):
        assert is_temperature(name, logged("1", 20.0)), name
    for name in ("attempt", "template", "tempo", "contempt"):
        assert not is_temperature(name, logged("1", 20.0)), name


def test_a_flow_of_mass_pulls_nothing(lab_context: Context) -> None:
    """Gravity has the same functions whether a flow is called one of mass or of air."""
    values = np.linspace(0.0, 1.0, len(lab_context.base))
    names = [
        [[f.name for f in space.features] for space in shipped()["gravity"].family(context)]
        for context in (
            with_logged(lab_context, "mass_flow", Covariate("g/s", values)),
            with_logged(lab_context, "air_flow", Covariate("g/s", values)),
        )
    ]
    assert names[0] == names[1]


def test_runs_that_log_in_two_units_are_not_joined(lab_context: Context) -> None:
    """Degrees and radians are not put one after the other as if they were alike, and what is missing is said."""
    rows = lab_context.rows
    values = np.linspace(0.0, 1.0, len(rows.capture))
    deg, rad = (replace(rows, covariates={"tilt": Covariate(unit, values)}) for unit in ("deg", "rad"))
    with pytest.raises(LabrigError) as caught:
        join_rows([deg, rad])
    assert (
        str(caught.value) == "the runs have 'tilt' in deg and in rad: import them again with it in one unit"
    )
    assert join_rows([deg, deg]).covariates["tilt"].values == pytest.approx(np.tile(values, 2))
    joined = join_rows([deg, rows, rows])
    assert joined.covariates == {}
    assert joined.warnings[-1] == "tilt was logged in 1 of the 3 runs: nothing follows it"


def with_logged(context: Context, name: str, covariate: Covariate) -> Context:
    """The same with something more that was logged."""
    return replace(context, rows=replace(context.rows, covariates={name: covariate}), _memo={})


@pytest.fixture
def lab_context(make_lab) -> Context:
    """A small campaign as its effects see it."""
    lab = make_lab(captures=6, repeats=False)
    return context_of(lab, rows_of(lab.dataset(lab.predict(lab.u))))
