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
        where = f"effect {effect.name!r}: {name}"
        try:
            same = abs(factor(value.unit, taken_in, where) - 1.0) < 1e-9
        except LabrigError:
            same = False
        if not same:
            raise LabrigError(
                f"{where} is stated in {value.unit}, and this run takes it in {taken_in}: convert it, or fit it again"
            )
