"""Absolute pressures: what of them is the air's, and what is said where it is not taken off."""

import numpy as np

from labrig.arrays import Floats
from labrig.tables._names import take_apart
from labrig.tables._table import Table
from labrig.tables._units import atmosphere, like


def said_of_absolute(table: Table, column: str | int, unit: str, values: Floats) -> str:
    """What is said of a column that is called absolute, where a mapping takes nothing off its values (n,) in `unit`; or
    empty, as where some are 0 or less: then they are none.
    """
    absolute = take_apart(column, unit).absolute or str(column) in table.absolute
    if not absolute or not like(unit, "kPa") or not np.nanmin(values, initial=np.inf) > 0:
        return ""
    return (
        f"column {column!r} is called an absolute pressure, and nothing is taken off, so that vented is not 0: "
        f"'offset: {-atmosphere(unit):g}' takes off one standard atmosphere"
    )
