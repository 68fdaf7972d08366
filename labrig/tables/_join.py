"""Files with clocks of their own, read at the times of the first one."""

from collections.abc import Sequence
from dataclasses import replace
from datetime import UTC, datetime
from pathlib import Path

import numpy as np

from labrig._errors import LabrigError
from labrig._turns import turn_of
from labrig.arrays import Floats
from labrig.tables._clock import is_dated, seconds, why_back
from labrig.tables._held import is_steps
from labrig.tables._mapping import Join, Observable
from labrig.tables._opened import opened
from labrig.tables._order import by_time, in_rows
from labrig.tables._read import read_file
from labrig.tables._table import Table
from labrig.tables._unseen import unseen

_DATED_S = (6e8, 4e9)
"""Seconds since 1970 from 1989 to 2096: what lies between is a date."""
_LATE, _LATE_S = 0.1, 0.02
"""How late a logger stamps a row at most: a share of the finer step, and s (a timer of Windows goes in 16 ms)."""
_ROUNDED_S = 1e-6
"""To which seconds since 1970 are kept."""


def join_tables(
    table: Table,
    time_s: Floats,
    joins: list[Join],
    own: dict[str, str],
    folder: Path,
    observed: Sequence[Observable] = (),
    remarks: list[str] | None = None,
) -> Table:
    """The table with the columns of every joined file, ``NAME.column``, at its times `time_s` (n,) of its own clock.

    `own` are the files that stand for those that a join names itself; paths start at `folder`. Between two rows of what
    is `observed` an angle goes the short way round, a quaternion keeps its sign, and what was not seen in one of them
    is not seen; `remarks` say so. What the joined file has no row for is NaN; what is `said` are rows that are outside
    its time. Raises `LabrigError` if a file is missing, its clock goes back, or it has no row in this time.
    """
    import pandas as pd

    columns: dict[str, Floats] = {}
    units, absolute = dict(table.units), set(table.absolute)
    said: list[str] = []
    for join in joins:
        file = own.get(join.name, join.file)
        if file is None:
            raise LabrigError(
                f"{table.path}: join {join.name!r} names no file, and neither does this table's entry"
            )
        other = read_file(folder / file, join.format)
        clock = seconds(other, join.time, f"join {join.name}") * join.rate + join.offset_s
        if join.time.sort:
            order = by_time(clock)
            other, clock = in_rows(other, order), clock[order]
        back = np.flatnonzero(np.diff(clock) < 0)
        if len(back):
            why = why_back(clock, int(back[0]) + 1, dated=is_dated(join.time))
            raise LabrigError(
                f"{other.at(int(back[0]) + 1)}: time goes backward; a joined file has one clock{why}"
            )
        if clock[-1] < time_s.min() or clock[0] > time_s.max():
            raise LabrigError(
                f"{other.path}: its times {_span(clock[0], clock[-1])} (after 'rate' and 'offset_s') are not those of"
                f" {table.path.name}, {_span(time_s.min(), time_s.max())}; give 'offset_s'"
            )
        said += _outside(table, other, clock, time_s)
        reader = _reader(clock, time_s, join)
        units |= {f"{join.name}.{column}": unit for column, unit in other.units.items()}
        absolute |= {f"{join.name}.{column}" for column in other.absolute}
        numbers = {f"{join.name}.{c}": _numbers(other, c) for c in other.frame.columns}
        found = {name: values for name, values in numbers.items() if values is not None}
        own_seen = [o for o in observed if o.column in found] if join.how == "linear" else []
        clean, lines = _between(own_seen, found)
        columns |= {name: reader(clean.get(name, values)) for name, values in found.items()}
        columns |= {
            str(o.column): _turned_back(columns[str(o.column)], found[str(o.column)], o) for o in own_seen
        }
        if remarks is not None:
            remarks += [f"{other.path.name}: {line}" for line in lines]
    frame = pd.concat([table.frame, pd.DataFrame(columns)], axis=1)
    return replace(table, frame=frame, said=tuple(said), units=units, absolute=frozenset(absolute))


def _outside(table: Table, other: Table, clock: Floats, time_s: Floats) -> list[str]:
    """A line on rows whose times are not those of the joined file; where they are most of all, what may be wrong."""
    reach_s = float(np.median(np.diff(clock))) if len(clock) > 1 else 0.0
    outside = int(((time_s < clock[0] - reach_s) | (time_s > clock[-1] + reach_s)).sum())
    if not outside:
        return []
    line = (
        f"{outside} of {len(time_s)} rows are before or after {other.path.name}, {_span(clock[0], clock[-1])}"
    )
    return [line + ("; is its unit, 'rate_hz' or 'offset_s' right?" if 2 * outside > len(time_s) else "")]


def _span(first_s: float, last_s: float) -> str:
    """From when to when, in s; of seconds since 1970 the dates."""
    if not _DATED_S[0] < first_s <= last_s < _DATED_S[1]:
        return f"{first_s:.6g} to {last_s:.6g} s"
    return (
        " to ".join(f"{datetime.fromtimestamp(t, UTC):%Y-%m-%d %H:%M:%S}" for t in (first_s, last_s)) + " UTC"
    )


def _numbers(table: Table, column: str | int) -> Floats | None:
    """A column's numbers, or None where it is text: nobody may need it."""
    if str(column) in table.doubled:
        return None
    try:
        return table.numbers(column, "join")
    except LabrigError:
        return None


def _between(observed: Sequence[Observable], found: dict[str, Floats]) -> tuple[dict[str, Floats], list[str]]:
    """The columns of what is `observed` as values between their rows may be computed: NaN where nothing was seen, and
    without the jumps of angles and quaternions; and what is said of the former.
    """
    if not observed:
        return {}, []
    names = [str(o.column) for o in observed]
    markers = list(dict.fromkeys(o.marker for o in observed if o.marker))
    owner = np.array([markers.index(o.marker) if o.marker else -1 for o in observed])
    values, said = unseen(
        np.stack([found[name] for name in names], axis=1), [o.name for o in observed], owner
    )
    values, _ = opened(names, [_unit(o) for o in observed], values)
    return dict(zip(names, values.T, strict=True)), said


def _unit(observed: Observable) -> str:
    """The unit of a column as it is written: of what has a scale it is not known."""
    return observed.unit if observed.scale == 1 and observed.offset == 0 else "?"


def _turned_back(values: Floats, raw: Floats, observed: Observable) -> Floats:
    """Angles that left the scale that they were written on are there again, from 0 or from minus half a turn."""
    turn = turn_of(_unit(observed))
    if not turn or not (values > np.max(raw, initial=-np.inf, where=np.isfinite(raw))).any():
        return values
    low = -turn / 2 if (raw < 0).any() else 0.0
    return values - turn * np.floor((values - low) / turn)


def _reader(clock: Floats, at: Floats, join: Join):
    """What reads a column of the joined file at the times `at`."""
    if join.how == "previous":
        return _reader_of_previous(clock, at, join.within_s)
    after = np.clip(np.searchsorted(clock, at, side="right"), 1, max(len(clock) - 1, 1))
    if len(clock) == 1:
        after = np.zeros(len(at), dtype=np.int64)
    before = np.maximum(after - 1, 0)
    nearest = np.where(np.abs(clock[after] - at) < np.abs(at - clock[before]), after, before)
    far = np.abs(clock[nearest] - at)
    limit = join.within_s
    typical = float(np.median(np.diff(clock))) if len(clock) > 1 else 0.0
    reach = limit if limit is not None else typical
    unseen = far > reach + 1e-9
    if join.how == "linear":
        unseen |= (at < clock[0] - 1e-9) | (at > clock[-1] + 1e-9)
        # a camera that is triggered saw nothing of what happened between two holds
        unseen |= (clock[after] - clock[before] > 2 * max(reach, typical) + 1e-9) & (far > 1e-9)

    def read(values: Floats) -> Floats:
        if join.how != "linear" or len(clock) == 1:
            out = values[nearest].astype(float)
        else:
            width = clock[after] - clock[before]
            share = np.clip((at - clock[before]) / np.where(width > 0, width, 1.0), 0.0, 1.0)
            out = values[before] + share * (values[after] - values[before])
            out = np.where(share == 0.0, values[before], np.where(share == 1.0, values[after], out))
        out[unseen] = np.nan
        return out

    return read


def _reader_of_previous(clock: Floats, at: Floats, within_s: float | None):
    """What reads the value that holds at the times `at`.

    A logger stamps a row a little after the value in it was there. What a log repeats from row to row therefore counts
    from a little before its stamp: from a tenth of a step of the finer of both clocks, and no more than loggers are
    late by. A command that is written when it is set counts from then.
    """
    steps = [float(np.median(np.diff(c))) for c in (clock, at) if len(c) > 1]
    late_s = min(_LATE * min(steps, default=0.0), _LATE_S)

    def read(values: Floats) -> Floats:
        early_s = max(late_s, _ROUNDED_S) if is_steps(values) else _ROUNDED_S
        last = np.searchsorted(clock, at + early_s, side="right") - 1
        out = values[np.maximum(last, 0)].astype(float)
        out[(last < 0) | (at - clock[last] > (within_s if within_s is not None else np.inf))] = np.nan
        return out

    return read
