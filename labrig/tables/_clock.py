"""The clock of a table, in seconds."""

import numpy as np

from labrig.arrays import Floats
from labrig.tables._mapping import TimeColumn, UnitColumn
from labrig.tables._table import DATE, Table
from labrig.tables._units import factor


def seconds(table: Table, time: TimeColumn | UnitColumn, what: str) -> Floats:
    """The time column of a table in s, (n,), as its clock counts; raises `LabrigError` for a gap or text."""
    if time.unit == DATE:
        return table.dates(time.column, what)
    rate = time.rate_hz if isinstance(time, TimeColumn) else None
    scale = 1 / rate if rate else factor(time.unit, "s", f"{table.path}: {what}")
    return np.array(table.numbers(time.column, what, required=True, thousands=time.thousands)) * scale
