"""Cells that hold a number and its unit, `12.3 kPa`: columns of them are numbers in that unit."""

import re
from typing import TYPE_CHECKING

import numpy as np

from labrig.tables._names import unit_of
from labrig.tables._units import like

if TYPE_CHECKING:
    import pandas as pd

    from labrig.tables._table import Table

_AMOUNT = r"([+-]?(?:\d+\.?\d*|\.\d+)(?:[eE][+-]?\d+)?)\s*([^\d\s.,:+-][^:]*)"
_FEW = 20


def amounts(table: "Table") -> tuple["pd.DataFrame", dict[str, str]]:
    """The frame of a table with such columns as numbers (NaN where there is none), and the unit of each by its name.

    A column has one unit, in all cells that hold something. Times are left as they are: their reader knows them.
    """
    frame, units = table.frame, {}
    for column in frame.columns:
        if frame[column].dtype.kind in "fiubMm" or (unit := _unit(table.filled(column).head(_FEW))) is None:
            continue
        cells = table.filled(column)
        if _unit(cells) != unit:
            continue
        numbers = np.full(len(frame), np.nan)
        numbers[frame.index.get_indexer(cells.index)] = cells.str.extract(_AMOUNT)[0].astype(float)
        frame = frame if units else frame.copy()
        frame[column] = numbers
        units[str(column)] = unit
    return frame, units


def _unit(cells: "pd.Series") -> str | None:
    """The unit of cells which all hold a number and the same one; None of any others."""
    if not len(cells) or not re.fullmatch(_AMOUNT, cells.iloc[0]):
        return None
    parts = cells.str.extract(f"^{_AMOUNT}$")
    written = parts[1].str.strip()
    if parts.isna().to_numpy().any() or written.nunique() != 1:
        return None
    unit = unit_of(written.iloc[0])
    return None if unit is None or unit == "1" or like(unit, "s") else unit
