"""The units that a text table says above its names: one for each column, or one for all lengths."""

import re
from dataclasses import replace
from itertools import islice, pairwise

from labrig.tables._header import split
from labrig.tables._mapping import Format
from labrig.tables._names import Name
from labrig.tables._packed import open_text
from labrig.tables._read import kind_of
from labrig.tables._roles import Roles
from labrig.tables._spelling import is_absolute, unit_of
from labrig.tables._table import Table
from labrig.tables._text import find_encoding
from labrig.tables._units import is_length

_OF_COLUMNS = re.compile(r"\W*(?:[xy][ _])?(?:units?|einheit(?:en)?|unit[ _]?labels?)\W*", re.I)
"""What stands before the units of the columns: Y_Unit_Label of LabVIEW."""
_OF_LENGTHS = re.compile(r"\W*(?:length|distance|position|coordinate|marker)s?[ _]units?\W*", re.I)
"""What stands before the unit of all lengths: Length Units of Motive."""


def with_units_above(table: Table, how: Format) -> Table:
    """The table with the units that a line above its names has over its columns, where no other says one."""
    names = [str(column) for column in table.frame.columns]
    for cells in _above(table, how):
        units = [unit_of(cell) if cell.strip() else None for cell in cells[1:]]
        some = any(units) and all(
            unit or not cell.strip() for unit, cell in zip(units, cells[1:], strict=True)
        )
        if _OF_COLUMNS.fullmatch(cells[0]) and some:
            said = {name: unit for name, unit in zip(names[1:], units, strict=False) if unit}
            absolute = {name for name, cell in zip(names[1:], cells[1:], strict=False) if is_absolute(cell)}
            return replace(table, units={**said, **table.units}, absolute=table.absolute | absolute)
    return table


def say_lengths(roles: Roles, table: Table, how: Format) -> None:
    """Give the coordinates of markers the unit of lengths that a line above the names says, where no other says one."""
    found = (
        unit
        for cells in _above(table, how)
        for name, cell in pairwise(cells)
        if _OF_LENGTHS.fullmatch(name) and (unit := unit_of(cell)) and is_length(unit)
    )
    if any(n.unit for axes in roles.markers.values() for n in axes.values()) or not (
        unit := next(found, None)
    ):
        return

    def said(n: Name) -> Name:
        return replace(n, unit=unit)

    roles.markers = {owner: {a: said(n) for a, n in axes.items()} for owner, axes in roles.markers.items()}


def _above(table: Table, how: Format) -> list[list[str]]:
    """The cells of the lines above the names."""
    if not how.skip_rows or kind_of(table.path) != "text":
        return []
    with open_text(table.path, how.encoding or find_encoding(table.path), "replace") as file:
        lines = [line.rstrip("\r\n") for line in islice(file, how.skip_rows)]
    return [cells for line in lines if len(cells := split(line, how.separator)) > 1]
