"""Which columns of a foreign table are its clock, and in what unit."""

import re
from collections.abc import Mapping
from typing import Any

import numpy as np

from labrig._errors import LabrigError
from labrig.arrays import Floats
from labrig.tables import _names as names
from labrig.tables._dates import DAY_S, Stamps
from labrig.tables._names import Name
from labrig.tables._pairs import Clock, finer, seconds_and_parts, year_to_second
from labrig.tables._table import DATE, MINUTES, Table
from labrig.tables._units import like

_DATE = re.compile(
    r"\d{1,4}[-/.]\d{1,2}[-/.]\d{1,4}|\d{1,2}:\d{2}|\d[-/. ][A-Za-z]{3,9}[-/. ,]"
    r"|^\d{8}(\D|$)|^\d{4}(_\d{1,2}){5}|\d days?\b"
)
_AMOUNT = re.compile(r"\s*[+-]?\d+([.,]\d+)?\s*[A-Za-zµμ]+\.?\s*")
_NO_TIME = names.CAPTURE | names.PRESSURE | names.COMMANDED | names.INPUT
_ALSO_TIME = names.TIME | {"millis", "micros", "ticks", "datenum"}
_PART_OF_DAY = 1e-4
"""Numbers of days rise by less in a row; as seconds they would be rows at 10 kHz and more, which no rig logs."""
_DECIMALS = 3
"""Seconds are written with as many decimals or fewer; days so written would tell times 86 s apart, no finer."""
_MONTH = 30
"""No table of numbered days goes on for longer; in seconds it is half a minute of a clock that counts on."""
_WHOLE_S, _MOST = 0.05, 0.9
"""Numbered days that are rows some seconds apart are whole seconds, up to what six decimals tell, in most rows: of any
other numbers a tenth would be.
"""
_MORNING = 0.1
"""A time of day that a sheet wrote as a share of it (0.3333 is 8 o'clock) is later than this."""
_EVEN, _NEARLY_EVEN = 0.2, 0.5
"""Spread of the steps of a first column, as a share of them, up to which it is a time: with and without a name."""
_FRAMES = {"frame", "frames"}
NO_CLOCK = "no column is a time: rows are taken as 1 s apart; say so under 'time:' if not"


def may_be_clock(name: Name) -> bool:
    """Whether dates of a column with this name are its clock, not the name of a session."""
    return name.has(names.TIME) or not name.has(names.SESSION - names.DAY)


def counts_frames(name: Name, values: Floats) -> bool:
    """Whether a column (n,) counts the frames of a camera, from which row to row there may be more than one."""
    called = name.has(_FRAMES) and all(word in _FRAMES | names.COUNTER for word in name.words)
    whole = bool(np.all(values == np.round(values)))
    return name.unit is None and called and whole and only_rises(values)


def are_dates(table: Table, column: Any) -> bool:
    """Whether a column holds dates, times of day, or amounts of time with their unit (0.5 sec)."""
    values = table.frame[column]
    if values.dtype.kind in "Mm":
        return True
    sample: Any = values.dropna().head(20)
    sample = sample[sample.astype(str).str.strip().ne("")]
    if not len(sample):
        return False
    written = all(_DATE.search(str(v)) or hasattr(v, "total_seconds") for v in sample)
    if not written and not all(_AMOUNT.fullmatch(str(v)) for v in sample):
        return False
    part = Table(table.path, table.frame.loc[sample.index, [column]].reset_index(drop=True))
    try:
        stamps = part.dates([column], "time")
    except LabrigError as error:
        return "frames" in str(error)
    return written or (stamps.amounts and only_rises(stamps.seconds))


def find_clock(
    table: Table, dated: list[Any], parsed: list[Name], values: Mapping[str, Floats], remarks: list[str]
) -> Clock | None:
    """The clock of a table: of the columns `dated` that hold dates and times, and the numbers that are `parsed`.

    Other clocks are taken out of `parsed`, and `remarks` say what was assumed. Raises `LabrigError` for a clock that
    runs backward through the whole file.
    """
    written = _written(table, dated, parsed, values, remarks) if dated else None
    if written is not None and written[1]:
        return written[0]
    numbers = year_to_second(parsed) or seconds_and_parts(parsed, values)
    if numbers is not None or written is not None:
        own = [n for n in parsed if n.unit is not None and like(n.unit, "s")]
        if numbers is None and any(only_rises(values[n.column]) for n in own if n.has(names.TIME)):
            numbers = find_time(table, parsed, values, remarks)
        return numbers or (written[0] if written else None)
    return find_time(table, parsed, values, remarks)


def _written(
    table: Table, dated: list[Any], parsed: list[Name], values: Mapping[str, Floats], remarks: list[str]
) -> tuple[Clock, bool] | None:
    """The clock of columns of dates and times, and whether it moves."""
    read: dict[Any, Stamps] = {}
    for column in dated:
        try:
            read[column] = table.dates([column], "time")
        except LabrigError as error:
            if len(dated) == 1 and "frames" not in str(error):
                return Clock((str(column),), DATE), True  # a gap, which the import names
            remarks.append(f"column {column!r} can't be read as a time and is left out: {error}")
    if not read:
        return None
    chosen = _chosen(read)
    stamps = read[chosen[0]] if len(chosen) == 1 else table.dates(chosen, "time")
    _refuse_backward(table, ", ".join(str(c) for c in chosen), stamps.seconds)
    remarks += [f"column {str(c)!r} is a clock as well and is left out" for c in read if c not in chosen]
    columns = tuple(str(c) for c in chosen)
    unit = MINUTES if stamps.minutes else DATE
    _say(stamps, remarks)
    day_first = None
    if stamps.calendar is not None and stamps.calendar.order in {"dmy", "mdy"} and stamps.calendar.sure:
        day_first = stamps.calendar.order == "dmy"
    if part := finer(parsed, values, stamps.seconds):
        return Clock((*columns, part[0].column), [*(unit for _ in columns), part[1]], day_first), True
    return Clock(columns, unit, day_first), bool(np.ptp(stamps.seconds))


def _chosen(read: dict[Any, Stamps]) -> list[Any]:
    """A date and a time of day beside it, else the first that moves, else the first."""
    days = [c for c, own in read.items() if own.dated and not (own.seconds % DAY_S).any()]
    alone = [c for c, own in read.items() if not own.dated and not own.amounts and not own.minutes]
    if days and alone:
        return [days[0], alone[0]]
    return [next((c for c, own in read.items() if np.ptp(own.seconds)), next(iter(read)))]


def _say(stamps: Stamps, remarks: list[str]) -> None:
    remarks += stamps.unsure
    dates = stamps.calendar
    if dates is None or not dates.order:
        return
    order = {"mdy": "month first", "dmy": "day first", "ymd": "year first"}[dates.order]
    other = dates.order == "mdy" and not dates.sure
    remarks.append(
        f"dates such as {dates.example!r} are read {order}"
        + (": write 'day_first: true' if not" if other else "")
    )


def find_time(
    table: Table, parsed: list[Name], values: Mapping[str, Floats], remarks: list[str]
) -> Clock | None:
    """The clock and its unit, of columns with these `values`; other clocks are taken out of `parsed`, and `remarks` say
    what was assumed. Raises `LabrigError` if it runs backward through the whole file.
    """
    able = [n for n in parsed if n.unit is None or like(n.unit, "s")]
    called = called_times(parsed)
    rising = [n for n in called if only_rises(values[n.column])]
    first_may = able[:1] == parsed[:1] and not any(n.has(_NO_TIME) for n in parsed[:1])
    if not rising and parsed and first_may and only_rises(values[parsed[0].column]):
        first = values[parsed[0].column]
        even = _EVEN if not parsed[0].column.isdigit() else _NEARLY_EVEN
        if len(first) > 2 and np.std(np.diff(first)) < even * np.mean(np.diff(first)):
            rising = [_beside_a_counter(parsed, values, remarks)]
            remarks.append(f"column {rising[0].column!r} rises evenly: taken for the time")
    if not rising:
        if not any(n.has(names.CAPTURE) for n in parsed):
            _refuse_gaps(table, [n for n in called if just_time(n)], values)
        for n in called:
            _refuse_backward(table, n.column, values[n.column])
        for n in called:
            if "hold" not in n.words:  # the time within a hold
                remarks.append(
                    f"column {n.column!r} is called a time but {_no_clock(values[n.column])}: left out"
                )
                parsed.remove(n)
        remarks.append(NO_CLOCK)
        return None
    chosen = rising[0]
    for other in rising[1:]:
        remarks.append(f"column {other.column!r} is a clock as well and is left out")
        parsed.remove(other)
    unit = chosen.unit
    if unit is None or unit not in {"s", "ms", "us", "ns", "min", "hour", "h"}:
        unit = _time_unit(values[chosen.column], chosen)
        remarks.append(f"the unit of the time {chosen.column!r} is not said: taken as {unit}")
    return Clock((chosen.column,), unit)


def _no_clock(values: Floats) -> str:
    """Why numbers (n,) that are called a time are none."""
    if not np.isfinite(values).all():
        return f"is empty in {int((~np.isfinite(values)).sum())} of {len(values)} rows"
    return "stands still" if np.ptp(values) == 0 else "goes back"


def called_times(parsed: list[Name]) -> list[Name]:
    """The columns that are called a time, and have no unit of something else."""
    able = [n for n in parsed if n.unit is None or like(n.unit, "s")]
    called = [n for n in able if n.words[:1] and {n.words[0].strip("%#"), n.words[-1]} & _ALSO_TIME]
    return called + [n for n in able if not n.words and n.unit in {"s", "ms", "us", "ns", "min"}]


def just_time(n: Name) -> bool:
    """Whether a column is called a time and nothing else: no settling time, and no day."""
    return bool(n.words) and set(n.words) <= _ALSO_TIME - {"date", "datum", "fecha"}


def _beside_a_counter(parsed: list[Name], values: Mapping[str, Floats], remarks: list[str]) -> Name:
    """The first column, or the one beside it that rises evenly too and is no whole number, where the first has no name
    and counts rows.
    """
    first, second = parsed[0], parsed[1:2]
    if first.column.isdigit() and second and (np.diff(values[first.column]) == 1).all():
        step = np.diff(values[second[0].column])
        whole = bool((values[second[0].column] == np.round(values[second[0].column])).all())
        if not whole and (step > 0).all() and np.std(step) < _EVEN * np.mean(step):
            remarks.append(f"column {first.column!r} counts rows and is left out")
            parsed.remove(first)
            return second[0]
    return first


def _refuse_backward(table: Table, column: str, values: Floats) -> None:
    step = np.diff(values)
    if len(step) > 1 and (step <= 0).all() and (step < 0).mean() > 0.5:
        raise LabrigError(
            f"{table.path}: the time {column!r} runs backward through the whole file; sort its rows by time"
        )


def _refuse_gaps(table: Table, called: list[Name], values: Mapping[str, Floats]) -> None:
    """Raise `LabrigError`, as a mapping does, where a column that is called a time is empty in some rows, and rises in
    the others, more than half of all.
    """
    for n in called:
        own = values[n.column][np.isfinite(values[n.column])]
        if len(own) > 0.5 * len(values[n.column]) and only_rises(own):
            try:
                table.numbers(table.key(n.column), "time", required=True)
            except LabrigError as error:
                raise LabrigError(
                    f"{error}: fill it, or write a mapping (docs/how-to/your-data.md)"
                ) from None


def only_rises(values: Floats) -> bool:
    """Whether values only go up, but for places where they begin anew."""
    if not np.isfinite(values).all() or len(values) < 2:
        return False
    step = np.diff(values)
    return bool((step > 0).any() and (step < 0).sum() <= max(0, len(step) // 50) and (step >= 0).mean() > 0.9)


def _time_unit(values: Floats, name: Name) -> str:
    """By its size where it counts from 1970 or in days (of Excel 2009 to 2064), else by the distance of its rows."""
    step = float(np.median(np.diff(values))) if len(values) > 1 else 1.0
    if 6e17 < values[0] < 7e17:
        return "ticks"
    for size, unit in ((1e17, "ns"), (1e14, "us"), (1e11, "ms")):
        if values[0] > size:
            return unit
    whole = bool(np.all(values == np.round(values)))
    rounded = np.allclose(values, np.round(values, _DECIMALS), rtol=0, atol=1e-9)  # but for what floats round
    seconds = values * DAY_S
    even = bool((np.abs(seconds - np.round(seconds)) < _WHOLE_S).mean() > _MOST)
    fine = not rounded and even and float(np.ptp(values)) < _MONTH
    if not whole and (step < _PART_OF_DAY or fine or "date" in name.words or "datenum" in name.words):
        if 40000 < values[0] < 60000:
            return "excel days"
        if 7e5 < values[0] < 8e5:
            return "datenum"
        if step < _PART_OF_DAY and values[0] > _MORNING and values[-1] < 1:
            return "day"
    if whole and step >= 1e5:
        return "ns" if step >= 1e6 * 5 else "us"
    if "millis" in name.words or "micros" in name.words:
        return "ms" if "millis" in name.words else "us"
    return "ms" if whole and step >= 5 and float(np.ptp(values)) >= 2000 else "s"
