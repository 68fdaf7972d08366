"""The clock of a table, in seconds."""

from datetime import UTC, datetime

import numpy as np

from labrig.arrays import Floats
from labrig.tables._mapping import TimeColumn
from labrig.tables._table import DATE, MINUTES, Table
from labrig.tables._units import factor

NUMBERED = {"excel days": (86400.0, 25569.0), "datenum": (86400.0, 719529.0), "ticks": (1e-7, 621355968e9)}
"""Units of numbers that are dates: how many s one is, and the number of 1970."""
_WRAPS_S = {2**32 / 1e3: "ms", 2**32 / 1e6: "us"}
_NEAR_WRAP = 0.1
"""Share of what a counter goes over, within which a step back is taken for its wrap: numerical."""
_HOUR_S = 3600.0
_SUMMER_TIME = (
    "; time goes back by about an hour, as clocks do at the end of summer time: write the times with their offset "
    "(2026-10-25T02:30:00+01:00), or in UTC"
)
_SPRING = (
    "time goes ahead over the hour that is left out where summer time begins: a local clock counts one too many here; "
    "write the times with their offset (2026-03-29T03:30:00+02:00), or in UTC"
)
_CHANGES = {(3, 2), (3, -1), (9, -1), (10, 1)}
"""Months, and which of their Sundays: summer time begins in North America, Europe, New Zealand and Australia."""
_LEFT_OUT = (1, 2, 3)
"""Hours of the day that are left out then, in one zone or another."""
_SAME_START = 0.2
"""Of a clock's range: the first times of recordings in one file are no farther apart."""
_ANEW = (
    "; its clock begins anew there, as where recordings stand one below the other: number them in a column and name it "
    "under 'session:' (column: ...), or give each a file"
)
SHUFFLED = 0.25
"""Share of steps that go back from which on rows were shuffled: half of all, in the mean."""


def seconds(table: Table, time: TimeColumn, what: str, remarks: list[str] | None = None) -> Floats:
    """The clock of the n rows of a table in s, (n,): its columns, added, or rows that are counted.

    What a person should know is added to `remarks`. Raises `LabrigError` for a gap or text.
    """
    if time.column is None:
        return np.arange(len(table.frame)) / (time.rate_hz or 1.0)
    parts = list(zip(time.columns(), time.units(), strict=True))
    out, local = np.zeros(len(table.frame)), False
    if dated := [column for column, unit in parts if unit in (DATE, MINUTES)]:
        minutes = any(unit == MINUTES for _, unit in parts)
        stamps = table.dates(dated, what, day_first=time.day_first, minutes=minutes)
        out, local = out + stamps.seconds, stamps.dated and not stamps.zoned
        if remarks is not None and len(stamps.nights):
            remarks.append(
                f"{_at(table, int(stamps.nights[0]))}: the time of day passes midnight: the next day is taken"
            )
    for column, unit in parts:
        if unit in (DATE, MINUTES):
            continue
        plain = None if unit in NUMBERED or time.rate_hz else unit
        numbers = table.numbers(column, what, required=True, thousands=time.thousands, unit=plain)
        if unit in NUMBERED:
            scale, zero = NUMBERED[unit]
            out = out + (numbers - zero) * scale
        else:
            scale = 1 / time.rate_hz if time.rate_hz else factor(unit, "s", f"{table.path}: {what}")
            out = out + numbers * scale
    if remarks is not None and dated:
        if row := _begins_summer_time(out) if local else 0:
            remarks.append(f"{_at(table, row)}: {_SPRING}")
        elif row := _hour_ahead(out):
            remarks.append(f"{_at(table, row)}: an hour is missing in the time: summer time, or a pause?")
    return out


def _at(table: Table, row: int) -> str:
    return f"{table.path.name}, {table.row_is} {row + table.first_row}"


def check_clock(time: TimeColumn, where: str) -> None:
    """Raise `LabrigError`, naming `where`, if a clock has a unit that is no time."""
    for unit in time.units():
        if unit not in (DATE, MINUTES, *NUMBERED):
            factor(unit, "s", where)


def is_dated(time: TimeColumn) -> bool:
    """Whether a clock holds dates and times of day, as text or as numbers of days."""
    return any(unit == DATE or unit in NUMBERED for unit in time.units())


def why_back(time_s: Floats, row: int, *, dated: bool) -> str:
    """What a clock (n,), s, that goes back before a row is likely to be: the end of a complaint. One that is `dated` is
    no counter.
    """
    sort = "; if the rows were shuffled, sort them by time: 'sort: true' under 'time:' does"
    step = time_s[row] - time_s[row - 1]
    if len(time_s) > 2 and (np.diff(time_s) <= 0).all():
        return "; it runs backward through the whole file: sort its rows by time"
    if (np.diff(time_s) < 0).mean() > SHUFFLED:
        return sort
    if dated:
        return _SUMMER_TIME if _ends_summer_time(time_s, float(step)) else sort
    for wrap, unit in _WRAPS_S.items():
        if -wrap <= step <= -wrap + min(max(1.0, 100 * _usual(time_s)), _NEAR_WRAP * wrap):
            return f"; its counter of 32 bits began anew at 4294967295 {unit}: add what it lost to the later rows"
    return _ANEW if _begins_anew(time_s) else sort


def _begins_anew(time_s: Floats) -> bool:
    """Whether a clock (n,) goes back to where it began, each time that it goes back."""
    begins = np.r_[time_s[0], time_s[1:][np.diff(time_s) < 0]]
    return bool(np.ptp(begins) <= _SAME_START * np.ptp(time_s))


def _ends_summer_time(time_s: Floats, step: float) -> bool:
    """Whether a step back (s) of dates (n,) is one of the record's own steps ahead, less the hour that clocks are set
    back by.
    """
    ahead = np.diff(time_s)
    longest = min(float(ahead.max(initial=0.0)), _HOUR_S / 2)
    return -1e-6 <= step + _HOUR_S <= max(1.0, 3 * _usual(time_s), longest)


def _usual(time_s: Floats) -> float:
    ahead = np.diff(time_s)
    ahead = ahead[ahead > 0]
    return float(np.median(ahead)) if len(ahead) else 0.0


def _begins_summer_time(time_s: Floats) -> int:
    """The row before which a local clock (n,), s since 1970, jumps over the hour of a day on which clocks go ahead; 0
    where none does.
    """
    for row in (np.flatnonzero(np.diff(time_s) >= _HOUR_S) + 1).tolist():
        before, after = (datetime.fromtimestamp(float(t), UTC) for t in time_s[row - 1 : row + 1])
        ends = before.hour + (before.minute + before.second > 0)
        over = any(ends <= hour < after.hour for hour in _LEFT_OUT)
        if over and before.date() == after.date() and after.weekday() == 6 and _sundays(after) & _CHANGES:
            return row
    return 0


def _sundays(day: datetime) -> set[tuple[int, int]]:
    """The month of a Sunday and which of its Sundays it is, from its beginning and, where it is the last, its end."""
    last = {(day.month, -1)} if day.day > (30 if day.month == 9 else 31) - 7 else set()
    return {(day.month, (day.day - 1) // 7 + 1)} | last


def _hour_ahead(time_s: Floats) -> int:
    """The row before which a steady clock (n,) jumps ahead by exactly one hour; 0 where none does."""
    step, usual = np.diff(time_s), _usual(time_s)
    if not 0 < usual < 600:
        return 0
    far = np.flatnonzero(step > 10 * usual)
    if len(far) != 1 or not 0 <= step[far[0]] - _HOUR_S <= max(1.0, 2 * usual):
        return 0
    return int(far[0]) + 1
