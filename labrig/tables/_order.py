"""Rows that are not in the order of their clock: what was shuffled is put in order, what begins again is left alone."""

from contextlib import suppress
from dataclasses import replace
from typing import Any

import numpy as np

from labrig._errors import LabrigError
from labrig.arrays import Floats, Ints
from labrig.tables import _names as names
from labrig.tables._clock import SHUFFLED
from labrig.tables._names import take_apart
from labrig.tables._table import Table
from labrig.tables._time import are_dates, called_times, may_be_clock, only_rises

_FEWEST = 8
"""Rows from which on an order can be told from chance."""
_SAME_START = 0.2
"""Of a clock's range: the first times of its pieces are no farther apart where it begins again with each."""
_SMOOTHER = 0.6
"""So much less do the numbers of some column change from row to row when their order is right."""


def in_order(table: Table) -> tuple[Table, str | None]:
    """The table with its rows by time where they were shuffled, and which column says the time; else as it is.

    They are sorted only where nothing speaks against it: no two rows have the same time, all clocks have the same
    order, captures and sessions stand together afterwards, and some column then goes on from row to row as it did not
    before. Raises `LabrigError` where rows look shuffled, and this is not so.
    """
    clocks = _clocks(table)
    if not clocks:
        return table, None
    called, time_s = next(iter(clocks.items()))
    if any(only_rises(values) for values in clocks.values()) or not _is_shuffled(time_s):
        return table, None
    order = np.argsort(time_s, kind="stable")
    alike = all((np.diff(values[order]) >= 0).all() for values in clocks.values())
    if alike and (np.diff(time_s[order]) > 0).all() and _is_right(table, order, set(clocks)):
        return in_rows(table, order), called
    raise LabrigError(
        f"{table.path}: the time {called!r} goes back and forth; sort the rows by time (if it is the time within a "
        "hold, write a mapping with 'hold:')"
    )


def in_rows(table: Table, order: Ints) -> Table:
    """The table with other rows or in another order; a complaint still names the rows as they are in the file."""
    lines = np.arange(len(table.frame)) + table.first_row if table.lines is None else table.lines
    return replace(table, frame=table.frame.iloc[order].reset_index(drop=True), lines=lines[order])


def by_time(time_s: Floats, session: Any = None) -> Ints:
    """The order of rows (n,) by their time; by session first where the times of several sessions overlap."""
    order = np.argsort(time_s, kind="stable")
    if session is None or _together(session[order]):
        return order
    return np.lexsort((time_s, _codes(session)))


def _clocks(table: Table) -> dict[str, Floats]:
    """The columns that are called a time, or hold dates, and have one in each row; (n,) each."""
    out: dict[str, Floats] = {}
    named = {str(c): (c, take_apart(c, table.units.get(str(c)))) for c in table.frame.columns}
    called = {n.column for n in called_times([n for _, n in named.values()]) if "hold" not in n.words}
    for key, (column, name) in named.items():
        with suppress(LabrigError):
            if (
                table.frame[column].dtype.kind not in "fiub"
                and may_be_clock(name)
                and are_dates(table, column)
            ):
                stamps = table.dates([column], "time")
                # a time of day that goes back is read as the next day: what was shuffled is not seen
                if not len(stamps.nights):
                    out[key] = stamps.seconds
            elif key in called:
                out[key] = table.numbers(column, "time")
    return {column: values for column, values in out.items() if len(values) and np.isfinite(values).all()}


def _is_shuffled(time_s: Floats) -> bool:
    """Whether a clock (n,) goes back and forth at random, and does not begin again with each session or hold."""
    if len(time_s) < _FEWEST or 2 * len(np.unique(time_s)) < len(time_s):
        return False
    back = np.diff(time_s) < 0
    if not SHUFFLED < back.mean() < 1 - SHUFFLED:
        return False
    return bool(np.ptp(time_s[1:][back]) > _SAME_START * np.ptp(time_s))


def _is_right(table: Table, order: Ints, clocks: set[str]) -> bool:
    """Whether the rows in this order are a record: what stands together does, and some column goes on."""
    smoother = False
    for column in table.frame.columns:
        name = take_apart(column)
        if name.column in clocks or "hold" in name.words:
            continue
        label = name.unit is None and name.has(names.SESSION | names.CAPTURE)
        if label and not _together(table.labels(column, "capture")[order]):
            return False
        values = table.frame[column]
        if values.dtype.kind not in "fiu":
            continue
        numbers = values.to_numpy(dtype=float)
        if np.isfinite(numbers).all() and np.ptp(numbers):
            change = [float(np.abs(np.diff(v)).sum()) for v in (numbers[order], numbers)]
            smoother |= change[0] < _SMOOTHER * change[1]
    return smoother


def _together(labels: Any) -> bool:
    """Whether rows (n,) with the same label stand together; those without one may stand anywhere."""
    code, named = _codes(labels), labels != ""
    begins = np.r_[True, np.diff(code) != 0] & named
    return int(begins.sum()) == len(np.unique(code[named]))


def _codes(labels: Any) -> Ints:
    """The number of each label (n,), in the order in which they first appear."""
    import pandas as pd

    return pd.factorize(labels)[0]
