"""What each column of a foreign table is likely to be: a time, a label, an input, a marker, an output."""

from dataclasses import dataclass, field, replace
from typing import Any

import numpy as np

from labrig._errors import LabrigError
from labrig.arrays import Floats
from labrig.tables import _names as names
from labrig.tables._beside import is_ambient, is_moved, is_quality, is_side
from labrig.tables._clock import seconds
from labrig.tables._counters import number_captures, number_set_points
from labrig.tables._inputs import (
    answers_to,
    find_commands,
    find_held,
    find_more_sensors,
    find_sensors,
    is_pressure,
    may_be_compared,
    unit_by_sensors,
    with_siblings,
    without_twice,
)
from labrig.tables._labels import find_counters, find_labels, numbers_rows, refuse_long, refuse_turns
from labrig.tables._mapping import TimeColumn
from labrig.tables._names import Name, take_apart
from labrig.tables._pairs import Clock
from labrig.tables._places import may_be_place, points_called_p, with_images, with_triples
from labrig.tables._records import one_record
from labrig.tables._stages import find_stages
from labrig.tables._table import Table
from labrig.tables._time import NO_CLOCK, are_dates, counts_frames, find_clock, just_time, may_be_clock
from labrig.tables._units import atmosphere, is_length, like
from labrig.tables._worded import no_numbers, refuse_worded, words_among

NO_INPUT = "no column is called a pressure, a set-point or an input"
_GENERIC = {("data",), ("value",), ("values",)}
_NO_INPUT = names.OUTPUT | names.MEASURED | names.CONVERTER | names.NO_POSITION


@dataclass
class Roles:
    """The columns of a table by what they are taken for; `time` with its units; `numbers` are left out by their names;
    `remarks` say what was assumed.

    `surmised`: nothing is called an input, and something is taken for it all the same. `worded` are left out: columns
    of numbers with words in some cells.
    """

    time: Clock | None = None
    capture: Name | None = None
    session: Name | None = None
    repeat: Name | None = None
    numbers: list[Name] = field(default_factory=list)
    hold: Name | None = None
    actuation: list[Name] = field(default_factory=list)
    measured: list[tuple[Name, Name]] = field(default_factory=list)
    markers: dict[str, dict[str, Name]] = field(default_factory=dict)
    observables: list[Name] = field(default_factory=list)
    covariates: list[Name] = field(default_factory=list)
    values: dict[str, Floats] = field(default_factory=dict, repr=False)
    remarks: list[str] = field(default_factory=list)
    surmised: bool = False
    worded: list[Name] = field(default_factory=list)

    def measured_varies(self) -> bool:
        """Whether anything that was measured is not the same in all rows."""
        seen = [*self.observables, *(n for axes in self.markers.values() for n in axes.values())]
        return any(np.nanmax(v) > np.nanmin(v) for n in seen for v in [self.values[n.column]])


def roles_of(table: Table, part: str = "", rate: tuple[float, int] | None = None) -> Roles:
    """Take every column of a table for something.

    `rate` is what a line above the header says of the rows a second (Hz), and its number; it counts where no column is
    a clock. A column that is called `data` has the name of its `part`, the topic or group. Raises `LabrigError` for a
    table with several rows at one time.
    """
    out = Roles()
    parsed: list[Name] = []
    dated: list[Any] = []
    for column in table.frame.columns:
        name = take_apart(column, table.units.get(str(column)))
        absolute = name.absolute or str(column) in table.absolute
        absolute = absolute and name.unit is not None and like(name.unit, "kPa") and not name.has(names.ERROR)
        name = replace(name, absolute=absolute)
        if part.strip("/") and name.words in _GENERIC:
            name = replace(take_apart(part.strip("/").rpartition("/")[2]), column=str(column))
        numbers = _numbers(table, column)
        if numbers is not None and numbers_rows(name, numbers):
            out.remarks.append(f"column {name.column!r} counts rows and is left out")
        elif numbers is not None and np.isfinite(numbers).any():
            out.values[name.column] = numbers
            parsed.append(name)
        elif numbers is None and may_be_clock(name) and are_dates(table, column):
            dated.append(column)
        elif numbers is None and name.has(names.SESSION - names.LABEL) and out.session is None:
            out.session = name
        elif numbers is None and (name.has(names.CAPTURE) or name.has(names.REPEAT)):
            if out.capture is None and name.has(names.CAPTURE):
                out.capture = name
            elif out.repeat is None:
                out.repeat = name
        else:
            what = "is empty" if numbers is not None else words_among(table, column)
            out.worded += [name] if numbers is None and what else []
            what = what or no_numbers(table, column)
            out.remarks.append(f"column {name.column!r} {what} and is left out")
    out.remarks += table.parted([table.key(n.column) for n in parsed])
    parsed = one_record(parsed, out.values, out.remarks)
    computed = [n for n in parsed if n.has(names.COMPUTED)]
    quality = [n for n in parsed if n not in computed and is_quality(n)]
    out.remarks += [f"column {n.column!r} says how good the measurement was and is left out" for n in quality]
    parsed = [n for n in parsed if n not in computed and n not in quality]
    frames = next((n for n in parsed if counts_frames(n, out.values[n.column])), None)
    parsed = [n for n in parsed if n is not frames]
    out.time = find_clock(table, dated, parsed, out.values, out.remarks)
    if out.time is None:
        out.time = _by_frames(frames, rate, out.remarks)
    elif frames is not None:
        out.remarks.append(f"column {frames.column!r} counts frames and is left out")
    if out.time is None:
        numbered = any(n.has(names.CAPTURE) for n in parsed)
        refuse_worded(table, out.worded, lambda n: not numbered and just_time(n), "a time")
    elif out.time.rate_hz is None:
        refuse_long(table, out.time.columns[0])
    refuse_turns(table, parsed, out.values)
    rest = [n for n in parsed if out.time is None or n.column not in out.time.columns]
    time_s = clock_s(table, out.time)
    rest = _find_markers(out, find_labels(out, _told_apart(rest), time_s))
    _find_inputs(out, rest, time_s)
    able = names.COMMANDED | (names.PRESSURE | names.INPUT if out.surmised else set())
    sure = out.surmised or not out.actuation
    refuse_worded(
        table,
        out.worded,
        lambda n: (
            n.has(able - names.LABEL) and n.axis is None and (sure or n.unit is not None or is_pressure(n))
        ),
        "an input",
    )
    if not out.observables and not out.markers:  # a simulation's table
        out.observables, computed = computed, []
    out.remarks += [f"column {n.column!r} was computed, not measured, and is left out" for n in computed]
    _say_unknown_units(out)
    return out


def _by_frames(frames: Name | None, rate: tuple[float, int] | None, remarks: list[str]) -> Clock | None:
    """The clock of a table that has none but its `frames`, or its rows, and perhaps a `rate` (Hz, number of its line)
    above them. What was assumed is said.
    """
    if rate is not None:
        counted = f"{frames.column!r} counts" if frames else "no column is a time:"
        remarks.remove(NO_CLOCK)
        remarks.append(f"{counted} {rate[0]:g} rows a second, as line {rate[1]} says")
        return Clock((frames.column,) if frames else (), "s", rate_hz=rate[0])
    if frames is not None:
        remarks.append(
            f"column {frames.column!r} counts frames, and nothing says how many a second: "
            f"'time: {{column: {frames.column}, rate_hz: 100}}' does"
        )
    return None


def clock_s(table: Table, clock: Clock | None) -> Floats | None:
    """The times of the rows (n,), s; None where there is no clock, or it has gaps."""
    if clock is None:
        return None
    try:
        own = clock.entry([table.key(c) for c in clock.columns])
        return seconds(table, TimeColumn.model_validate(own), "time")
    except LabrigError:
        return None


def _told_apart(parsed: list[Name]) -> list[Name]:
    """Names of which several are called the same without their units are called as their columns are."""
    called = [n.called for n in parsed]
    return [n if called.count(n.called) == 1 else replace(n, called=n.column) for n in parsed]


def _say_unknown_units(out: Roles) -> None:
    """Give unit 1 to what has something else written where a unit stands, and say so."""

    def said(n: Name) -> Name:
        if n.unit is not None or not n.written:
            return n
        out.remarks.append(
            f"the unit of {n.column!r} is written as 1: labrig does not know {n.written!r}; correct it under 'unit:'"
        )
        return replace(n, unit="1")

    out.actuation = [said(n) for n in out.actuation]
    own = {n.column: n for n in out.actuation}
    out.measured = [(said(n), own[u.column]) for n, u in out.measured]
    out.observables = [said(n) for n in out.observables]
    out.covariates = [said(n) for n in out.covariates]


def _numbers(table: Table, column: Any) -> Floats | None:
    """A column as floats (n,), NaN where it has none; None where more than 2 % are something else."""
    import pandas as pd

    values = table.frame[column]
    if values.dtype.kind in "fiub":
        return np.asarray(values, dtype=float)
    if values.dtype.kind in "Mm":
        return None
    text = table.filled(column)
    known: Any = pd.to_numeric(text, errors="coerce")
    if len(text) and known.head(1000).isna().mean() > 0.02:
        return None
    return known.reindex(table.frame.index).to_numpy(dtype=float)


def _find_markers(out: Roles, rest: list[Name]) -> list[Name]:
    """Take out x, y, z (or two of them) of one owner, where they are places."""
    rest = with_images(with_triples(rest), out.remarks)
    points = points_called_p(rest, out.values, out.remarks)
    turned = {n.owner for n in rest if n.axis is not None} & {
        n.called[:-1].rstrip("_. /") for n in rest if _is_w(n)
    }
    found: dict[str, dict[str, Name]] = {}
    for n in rest:
        if n.axis is not None and n.owner not in turned and (n.column in points or may_be_place(n)):
            found.setdefault(n.owner, {}).setdefault(n.axis, n)
    out.markers = {owner: axes for owner, axes in found.items() if len(axes) >= 2}
    taken = {n.column for axes in out.markers.values() for n in axes.values()}
    return [n for n in rest if n.column not in taken]


def _is_w(n: Name) -> bool:
    """Whether a column is the fourth number of a rotation."""
    return n.words[-1:] == ("w",)


def _find_inputs(out: Roles, rest: list[Name], time_s: Floats | None) -> None:
    """Tell commands, their sensors and what is beside the measurement from what was measured."""
    rest = without_twice(rest, out.values, out.remarks)
    beside = [n for n in rest if is_ambient(n, out.values[n.column])]
    side = [n for n in rest if n not in beside and is_side(n, out.values[n.column])]
    gauge: list[Name] = []
    for n in rest:
        if n.absolute and n.unit is not None and n not in beside and n not in side:
            if np.nanmin(out.values[n.column]) <= 0:
                out.remarks.append(
                    f"column {n.column!r} is called an absolute pressure, and is 0 or less in some rows: taken as it is"
                )
                gauge.append(n)
            else:
                out.values[n.column] = out.values[n.column] - atmosphere(n.unit)
    rest = [replace(n, absolute=False) if any(n is one for one in gauge) else n for n in rest]
    numbers = number_set_points(out, [n for n in rest if n not in beside and n not in side])
    rest = [n for n in rest if n not in numbers]
    own = [n for n in rest if n not in beside and n not in side]
    inputs, remarks = find_commands(own, out.values)
    if not inputs and side:
        inputs, remarks = find_commands([n for n in rest if n not in beside], out.values)
    out.surmised = not inputs
    inputs = inputs or _any_input(out, own, remarks)
    out.remarks += remarks
    own = [n for n in own if n not in inputs]
    counters = number_captures(out, own, inputs, time_s)
    counters += find_counters(out, [n for n in own if n not in counters], inputs)
    rest = [n for n in rest if n not in counters]
    inputs = [*inputs, *_stages(out, [n for n in own if n not in counters], inputs)]
    out.actuation = inputs
    for n in [n for n in beside if is_moved(n, inputs, out.values)]:
        beside.remove(n)
        out.remarks.append(f"column {n.column!r} follows the inputs: taken for what was measured")
    left = [n for n in rest if n not in inputs and n not in beside]
    pairs = find_sensors([n for n in left if n not in side], inputs, out.values)
    for n, u in [pair for pair in pairs if answers_to(*pair)]:
        pairs.remove((n, u))
        out.remarks.append(
            f"column {n.column!r} is what {u.column!r} makes in a closed volume: taken for what was measured; put it "
            "under 'covariates:' where the model does not predict it"
        )
    out.measured = [(n, u) for n, u in pairs if may_be_compared(n, u, out.values)]
    for n, u in pairs:
        if (n, u) not in out.measured:
            beside.append(n)
            units = f" ({n.unit} and {u.unit})" if n.unit and u.unit else ""
            out.remarks.append(
                f"column {n.column!r} is a sensor of {u.column!r} in another unit{units}: taken for a covariate; give "
                f"it a scale to {u.unit or 'that unit'} and put it under 'measured:' to compare them"
            )
    more = find_more_sensors([n for n in left if n not in side], pairs, out.values)
    out.remarks += [f"column {n.column!r} is another sensor of {u.column!r} and is left out" for n, u in more]
    taken = [n for n, _ in (*pairs, *more)]
    out.observables = [n for n in left if n not in taken and n not in side]
    out.covariates = [n for n in rest if n in beside or (n in side and n not in inputs)]
    if not out.observables and not out.markers:
        out.observables, out.covariates = out.covariates, []
    if not out.observables and not out.markers:  # what follows the only input may be what it moves
        out.observables = [n for n, _ in out.measured if not (n.has(names.MEASURED) or is_pressure(n))]
        out.measured = [(n, u) for n, u in out.measured if n not in out.observables]
    _take_units_of_sensors(out)
    _leave_out_still(out)


def _take_units_of_sensors(out: Roles) -> None:
    """Give commands without a unit that of their sensors; that it is taken is said."""
    for i, n in enumerate(out.actuation):
        if (found := unit_by_sensors(n, out.measured, out.values)) is None:
            continue
        unit, sensor = found
        out.actuation[i] = own = replace(n, unit=unit)
        out.measured = [(s, own if u.column == n.column else u) for s, u in out.measured]
        out.remarks.append(
            f"the unit of {n.column!r} is not said: taken as {unit}, in which its sensor {sensor.column!r} has its size"
        )


def _leave_out_still(out: Roles) -> None:
    """Leave out what is one whole number without a unit in all rows, where something else was measured: what labels
    the whole table (a session, a specimen, a version), and no column that is called a force or a reading.
    """
    still = [
        n
        for n in out.observables
        if n.unit is None
        and not n.written
        and not n.has(names.FORCE | names.MEASURED | names.OUTPUT)
        and _is_one_whole_number(out.values[n.column])
    ]
    if len(still) == len(out.observables) and not out.markers:
        return
    out.observables = [n for n in out.observables if n not in still]
    out.remarks += [
        f"column {n.column!r} is {out.values[n.column][0]:g} in all rows: taken for a label, and is left out"
        for n in still
    ]


def _is_one_whole_number(values: Floats) -> bool:
    return len(values) > 1 and bool((values == values[0]).all()) and float(values[0]).is_integer()


def _stages(out: Roles, rest: list[Name], inputs: list[Name]) -> list[Name]:
    """What was set beside the inputs; that it was is said. Of a marker's coordinates all, or none."""
    placed = {owner: [*axes.values()] for owner, axes in out.markers.items()}
    found = find_stages([*rest, *(n for axes in placed.values() for n in axes)], inputs, out.values)
    for owner, axes in placed.items():
        if all(n in found for n in axes):
            del out.markers[owner]
        else:
            found = [n for n in found if n not in axes]
    out.remarks += [
        f"column {n.column!r} stands still in holds, and not where the inputs say: taken for an input, too"
        for n in found
    ]
    return found


def _travels(rest: list[Name]) -> list[Name]:
    """How far a testing machine went, of its stroke before what it stretched; none where it measured no force."""
    found = [n for n in rest if n.has(names.TRAVEL) and n.unit != "percent"]
    found.sort(key=lambda n: n.has(names.STRETCH))
    return found if any(n.has(names.FORCE) for n in rest) else []


def _is_stretch(n: Name) -> bool:
    """Whether a column is a length or a strain: beside a machine's travel, an extensometer's."""
    return n.unit in {"1", "percent"} or (n.unit is not None and is_length(n.unit))


def _any_input(out: Roles, rest: list[Name], remarks: list[str]) -> list[Name]:
    """What may be the input where nothing is called so: what stands still in holds, else the first column."""
    if sum(n.axis is not None for n in rest) > 2:
        rest = [n for n in rest if n.axis is None]
    travels = _travels(rest)
    quiet = [n for n in rest if not n.has(_NO_INPUT) and not (travels and _is_stretch(n))]
    if out.markers and not quiet:
        return []
    held = find_held(quiet or travels or rest, out.values)
    if held and (len(held) < len(rest) or out.markers):
        inputs = held
    elif len(rest) > 1 or (rest and out.markers):
        able = quiet or travels or rest
        moving = [n for n in able if np.nanmax(out.values[n.column]) > np.nanmin(out.values[n.column])]
        moving.sort(key=lambda n: n.has(names.FORCE))  # a testing machine moves, and measures forces
        inputs = with_siblings(moving[:1], able, out.values)
        if len(inputs) == len(rest) and not out.markers:  # of many sensors that are alike none was set
            inputs = moving[:1] if len(rest) == 2 else []
    else:
        inputs = []
    if inputs:
        which = ", ".join(repr(n.column) for n in inputs)
        remarks.append(f"{NO_INPUT}: {which} {'is' if len(inputs) == 1 else 'are'} taken for it")
    return inputs
