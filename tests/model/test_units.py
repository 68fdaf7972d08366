"""Values of a model are in the units that it states, or nothing is predicted with them."""

from types import SimpleNamespace
from typing import Any

import pytest

from labrig import LabrigError
from labrig.effects import get
from labrig.model import EffectEntry, FittedOn, Value
from labrig.model._units import check_ranges, check_units


def a_run(unit: str) -> Any:
    """What a run says of its units: two observables of a marker, and pressures in `unit`."""
    rows = SimpleNamespace(actuation_unit=unit, unit=("mm", "mm"), marker=(0, 0), covariates={})
    return SimpleNamespace(rows=rows, motion={})


@pytest.mark.parametrize(
    ("name", "parameter", "unit", "run", "said"),
    [
        ("leak", "tau_s", "s", "kPa", None),
        ("leak", "tau_s", "1", "kPa", None),
        ("leak", "tau_s", "min", "kPa", "'leak': tau_s is stated in min, and this run takes it in s"),
        ("leak", "tau_s", "sec", "kPa", None),
        ("leak", "loss", "furlong", "kPa", "'leak': loss is stated in furlong, and this run takes it in 1"),
        ("regulator", "offset", "kPa", "kPa", None),
        ("regulator", "offset", "kPa", "bar", "'regulator': offset is stated in kPa, and this run takes it in bar"),
        ("regulator", "offset", "kPa", "bar or psi", None),
        ("drift", "pressure_rate", "bar/h", "kPa", "'drift': pressure_rate is stated in bar/h, and this run"),
        ("frame", "shift_since", "mm, rad", "kPa", None),
    ],
)  # fmt: skip
def test_a_value_in_another_unit_is_refused(
    name: str, parameter: str, unit: str, run: str, said: str | None
) -> None:
    """In the unit that it is stated in, a number means something else here; nothing is converted behind a back."""
    entry = EffectEntry(name=name, parameters={parameter: Value(value=1.0, unit=unit)})
    if said is None:
        check_units(get(name), entry, a_run(run))
        return
    with pytest.raises(LabrigError) as caught:
        check_units(get(name), entry, a_run(run))
    assert str(caught.value).startswith(f"effect {said}")
    assert str(caught.value).endswith(": convert it, or fit it again")


@pytest.mark.parametrize(
    ("fitted", "run", "refused"),
    [("kPa", "kPa", False), ("", "bar", False), ("hPa", "mbar", False), ("kPa", "bar", True)],
)
def test_fractions_of_ranges_in_another_unit_are_refused(fitted: str, run: str, refused: bool) -> None:
    """A width of a tenth of 60 kPa is none of 0.6 bar: an effect says in which unit its ranges are."""
    on = FittedOn(chambers=["c1"], low=[0.0], high=[60.0], unit=fitted)
    entry = EffectEntry(name="hysteresis", fitted_on=on)
    if not refused:
        check_ranges(entry, run)
        return
    with pytest.raises(LabrigError) as caught:
        check_ranges(entry, run)
    assert str(caught.value) == (
        "effect 'hysteresis' was fitted to a run whose inputs are in kPa, and this run's are in bar: import it in that "
        "unit, or fit the effect again"
    )
