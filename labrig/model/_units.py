"""Whether a model's values are stated in the units that a run takes them in."""

import re

from labrig._errors import LabrigError
from labrig.effects import Context, Effect, unit_on
from labrig.model._file import EffectEntry
from labrig.tables import factor

_SEVERAL = re.compile(r",| or |\(")


def check_units(effect: Effect, entry: EffectEntry, context: Context) -> None:
    """Raise `LabrigError` for a value in another unit than this run takes it in; one without a unit is as needed.

    Values that belong to things of several units are not looked at.
    """
    known = {parameter.name: parameter.unit for parameter in effect.parameters}
    for name, value in entry.parameters.items():
        taken_in = unit_on(context, known.get(name, "1"))
        if value.unit in ("1", "", taken_in) or _SEVERAL.search(value.unit + taken_in):
            continue
        if not _same(value.unit, taken_in):
            raise LabrigError(
                f"effect {effect.name!r}: {name} is stated in {value.unit}, and this run takes it in {taken_in}: "
                "convert it, or fit it again"
            )


def check_ranges(entry: EffectEntry, unit: str) -> None:
    """Raise `LabrigError` where the ranges that an entry's fractions are of are in another unit than a run's."""
    fitted = entry.fitted_on.unit if entry.fitted_on else ""
    if fitted and not _same(fitted, unit):
        raise LabrigError(
            f"effect {entry.name!r} was fitted to a run whose inputs are in {fitted}, and this run's are in {unit}: "
            "import it in that unit, or fit the effect again"
        )


def _same(unit: str, other: str) -> bool:
    if unit == other:
        return True
    try:
        return abs(factor(unit, other, "unit") - 1.0) < 1e-9
    except LabrigError:
        return False
