"""Absolute pressures: what of them is the air's, and what is said where it is not taken off."""

from labrig.tables._names import take_apart
from labrig.tables._table import Table
from labrig.tables._units import atmosphere, like


def said_of_absolute(table: Table, column: str | int, unit: str) -> str:
    """What is said of a column that is called absolute, where a mapping takes nothing off, in `unit`; or empty."""
    absolute = take_apart(column).absolute or str(column) in table.absolute
    if not absolute or not like(unit, "kPa"):
        return ""
    return (
        f"column {column!r} is called an absolute pressure, and nothing is taken off, so that vented is not 0: "
        f"'offset: {-atmosphere(unit):g}' takes off one standard atmosphere"
    )
