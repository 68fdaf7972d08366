"""The units that a model's values are stated in, and those that a run takes them in."""

import re
from collections.abc import Sequence

from labrig._errors import LabrigError
from labrig.effects import Effect, Rows
from labrig.model._file import EffectEntry
from labrig.tables import factor

_SEVERAL = re.compile(r",| or |\(")


def check_units(effect: Effect, entry: EffectEntry, rows: Rows) -> None:
    """Raise `LabrigError` for a value in another unit than this run takes it in; one without a unit is as needed.

    Values that belong to things of several units are not looked at.
    """
    known = {parameter.name: parameter.unit for parameter in effect.parameters}
    for name, value in entry.parameters.items():
        taken_in = _of_run(known.get(name, "1"), rows)
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


def _of_run(unit: str, rows: Rows) -> str:
    """A parameter's unit with those of the run in it; several are joined by `or`."""
    place = [u for u, marker in zip(rows.unit, rows.marker, strict=True) if marker >= 0]
    sensed = [u for u, marker in zip(rows.unit, rows.marker, strict=True) if marker < 0]
    own = {
        "actuation": rows.actuation_unit or "1",
        "observable": _joined(rows.unit),
        "place": _joined(place or rows.unit),
        "sensor": _joined(sensed or rows.unit),
        "motion": "1 or more",
    }
    return re.sub("|".join(own), lambda found: own[found[0]], unit)


def _joined(units: Sequence[str]) -> str:
    return " or ".join(dict.fromkeys(units)) or "1"
