"""Pressures for bases that know theirs in kPa."""

from pathlib import Path

from labrig._errors import LabrigError
from labrig.effects import Rows


def in_kpa(rows: Rows, path: Path) -> float:
    """What the pressures of a run are multiplied by for the base of a file.

    Raises `LabrigError` where the run's actuation is in no unit of pressure.
    """
    unit = rows.actuation_unit
    if unit == "kPa":
        return 1.0
    from labrig.tables import factor

    try:
        return factor(unit or "1", "kPa", "actuation")
    except LabrigError:
        raise LabrigError(f"{path}: needs pressures; the run's actuation is in {unit or 'no unit'}") from None
