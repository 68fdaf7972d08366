"""How the clocks of two files stand to each other: by dates in their rows, or by those above their names."""

from dataclasses import dataclass, replace
from datetime import UTC, datetime

from labrig.arrays import Floats
from labrig.tables._begin import begun
from labrig.tables._mapping import Format
from labrig.tables._read import kind_of
from labrig.tables._roles import Roles
from labrig.tables._table import DATE, Table

_ERA_S = 1e8
"""Dates are later than this, s since 1970; a clock that counts from its own beginning is not."""
_HOUR_S, _DAY_S = 3600.0, 86400.0
_FIRST_S = 60.0
"""A time of day is later than this; a time since a beginning, 00:00:05, is not."""
_ZONES = 14
"""Hours that two clocks on the wall may be apart."""
_SHARED = 0.5
"""Share of the shorter record that two have in common, from which on their clocks are taken to be in two zones."""


@dataclass(frozen=True)
class _Record:
    """A file and its clock, s; `dates` is when it began, in each way in which that can be read; 0 where its rows hold
    dates, none where nothing says it. `line` is the one that does. `of_day`: its rows hold times of day.
    """

    called: str
    clock_s: Floats
    dates: tuple[float, ...]
    line: int = 0
    of_day: bool = False

    def when(self, date: float) -> str:
        """What is said of its beginning."""
        if not self.line:
            return f"{self.called} has {'times of day' if self.of_day else 'dates'} in its rows"
        began = f"{datetime.fromtimestamp(date, UTC):%Y-%m-%d %H:%M:%S}"
        return f"line {self.line} of {self.called} says that it began at {began}"


def record_of(called: str, how: Format, table: Table, roles: Roles, clock_s: Floats) -> _Record:
    """A file as others are aligned with it."""
    if clock_s.min() > _ERA_S:
        return _Record(called, clock_s, (0.0,))
    found = begun(table.path, how) if how.skip_rows and kind_of(table.path) == "text" else None
    dates, line = found or ((), 0)
    if roles.time is not None and DATE in roles.time.unit and clock_s.min() > _FIRST_S:
        return _Record(called, clock_s, tuple(date // _DAY_S * _DAY_S for date in dates), of_day=True)
    clock = roles.time
    if clock is not None and clock.rate_hz and abs(clock_s[0] * clock.rate_hz - 1) < 1e-6:
        dates = tuple(date - 1 / clock.rate_hz for date in dates)  # frames that are counted from 1
    return _Record(called, clock_s, dates, line)


def offset_of(main: _Record, other: _Record, remarks: list[str]) -> float:
    """What is added to the other's clock to be on the main one's, s; how it was found is said in `remarks`."""
    main, other = _on_the_day_of(other, main), _on_the_day_of(main, other)
    own_s, other_s = main.clock_s, other.clock_s
    apart = other_s[-1] < own_s.min() or other_s[0] > own_s.max()
    if not (main.dates and other.dates) or main.dates == other.dates == (0.0,):
        for one, none in ((main, other), (other, main)):
            if one.line and not none.dates:
                remarks.append(
                    f"{one.when(one.dates[0])}, and nothing says when {none.called} did: "
                    + ("see 'offset_s'" if apart else "both clocks are taken for one; give 'offset_s' if not")
                )
        return _together(main, other, remarks) if apart else 0.0
    for hours in sorted(range(-_ZONES, _ZONES + 1), key=abs):
        for a in main.dates:
            for b in other.dates:
                offset = b - a + hours * _HOUR_S
                if _shared(own_s, other_s + offset) <= (_SHARED if hours else 0.0):
                    continue
                said = " and ".join(one.when(date) for one, date in ((main, a), (other, b)))
                zone = f", in zones that are {abs(hours)} h apart" if hours else ""
                remarks.append(
                    f"{said}{zone}: their clocks are joined by that; correct 'offset_s' if these computers' clocks "
                    "differ"
                )
                return float(round(offset, 6))
    remarks.append(f"{main.when(main.dates[0])}, {other.when(other.dates[0])}: these have no time in common")
    return _together(main, other, remarks) if apart else 0.0


def _on_the_day_of(other: _Record, one: _Record) -> _Record:
    """A record whose rows hold times of day, on the day on which the other began, or the next, or the one before."""
    if not one.of_day or one.dates or not other.dates:
        return one
    day = (other.clock_s[0] + other.dates[0]) // _DAY_S * _DAY_S
    return replace(one, dates=(day, day + _DAY_S, day - _DAY_S))


def _together(main: _Record, other: _Record, remarks: list[str]) -> float:
    remarks.append(
        f"the clock of {other.called} has no time in common with the other: both are taken to begin together; correct "
        "'offset_s' if not"
    )
    return float(main.clock_s[0] - other.clock_s[0])


def _shared(one: Floats, other: Floats) -> float:
    """Which share of the shorter of two records lies in the other."""
    both = min(one.max(), other[-1]) - max(one.min(), other[0])
    shorter = min(one.max() - one.min(), other[-1] - other[0])
    return both / shorter if shorter > 0 else 0.0
