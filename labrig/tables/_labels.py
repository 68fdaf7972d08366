"""Columns of a foreign table that number or name something, and are no measurement."""

import re
from collections.abc import Iterable, Mapping, Sequence
from dataclasses import replace
from typing import TYPE_CHECKING

import numpy as np
from numpy.typing import NDArray

from labrig._errors import LabrigError
from labrig.arrays import Floats
from labrig.tables import _names as names
from labrig.tables._counters import said_of_number
from labrig.tables._held import is_held
from labrig.tables._names import Name, take_apart
from labrig.tables._pairs import OF_A_DATE, counts_parts
from labrig.tables._stages import parts_holds
from labrig.tables._table import Table, short
from labrig.tables._units import factor

if TYPE_CHECKING:
    import pandas as pd

    from labrig.tables._roles import Roles

_NO_NAME = re.compile(r"column\.\d+|unnamed.*|#|index|no\.?|", re.I)
_TIME = re.compile("time|stamp|clock|tick|sec", re.I)
_TURNS = 3
_SPREAD = {"sd", "std", "stdev", "stddev", "sem", "deviation", "sigma"}
_MEAN = {"mean", "avg", "average", "median"}
_A_FEW = 4  # set-points after the first
_HOLDS = 3
"""Holds of the inputs in a session, at least, in the mean: fewer of one number are counted."""
_IN_HOLDS = ("s", "ms", "min")
"""Units in which the time since a set-point is written."""
_SINCE = {"since", "after", "seit", "nach", "depuis", "desde"}
"""What stands before what a time is counted from."""
_OF_A_SECOND = {"ms": 1e3, "us": 1e6, "ns": 1e9}


def numbers_rows(name: Name, values: Floats) -> bool:
    """Whether a column (n,) without a name, or called an index, is 0, 1, 2 ... or 1, 2, 3 ..."""
    if not _NO_NAME.fullmatch(name.column.strip()) or len(values) < 2:
        return False
    return values[0] in (0, 1) and bool((np.diff(values) == 1).all())


def find_labels(out: "Roles", rest: list[Name], clock_s: Floats | None) -> list[Name]:
    """Take out what numbers captures, sessions and repeats, parts of a clock, and the time within a hold.

    `clock_s` (n,) are the times of the rows, where they are known. What is left out is said in `out.remarks`. Returns
    the names that are left.
    """
    rest = _without_parts_of_the_clock(out, rest)
    clock = _bare(take_apart(out.time.columns[0])) if out.time and out.time.columns else None
    kept = []
    for n in rest:
        values = out.values[n.column]
        seen = values[np.isfinite(values)]
        whole = bool(np.all(seen == np.round(seen)))
        blocks = int((np.diff(values) != 0).sum()) + 1
        together = 1 < blocks == len(np.unique(values)) and n.unit is None
        in_holds = _unit_in_holds(n, values, clock_s) if out.hold is None else None
        if _is_clock_too(n, values, clock_s, clock) or (
            in_holds is None and _begins_anew(n, values, clock_s)
        ):
            out.remarks.append(f"column {n.column!r} is a clock as well and is left out")
        elif (unit := in_holds) is not None:
            out.hold = replace(n, unit=unit)
            if n.unit is None:
                out.remarks.append(
                    f"column {n.column!r} goes with the clock and begins anew in each hold: taken for the time since "
                    f"the set-point, in {unit}"
                )
        elif (
            whole
            and together
            and out.session is None
            and (n.has(names.SESSION) or _restarts(values, clock_s))
        ):
            out.session = n
        elif (
            whole
            and n.has(names.CAPTURE)
            and together
            and out.capture is None
            and (blocks < len(values) or not n.has(names.SEEN))
        ):
            out.capture = n
        elif whole and n.has(names.REPEAT) and n.unit is None and out.repeat is None:
            out.repeat = n
        elif whole and out.capture is None and together and blocks < len(values) and _counts(n, values):
            out.capture = n
        elif whole and together and values[0] in (0, 1) and _counts_set_points(n, rest, out.values):
            if out.capture is None and blocks < len(values):
                out.capture = n
            else:
                out.remarks.append(f"column {n.column!r} counts set-points and is left out")
        elif (of := _spread_of(n, rest)) is not None:
            out.remarks.append(f"column {n.column!r} is the spread of {of.column!r} and is left out")
        elif whole and n.unit is None and _is_number(n, rows := _rises_evenly(values)):
            out.remarks.append(
                f"column {n.column!r} counts rows and is left out" if rows else said_of_number(n)
            )
            out.numbers += [] if rows else [n]
        else:
            kept.append(n)
    return kept


def find_counters(out: "Roles", rest: list[Name], inputs: list[Name]) -> list[Name]:
    """The columns of `rest` that only count, and were neither set nor measured; what each is taken for is said.

    Few whole numbers that never fall, though an input does, and change only where a hold may begin: the session, if
    several holds have each of them.
    """
    u = np.column_stack([out.values[n.column] for n in inputs] or [np.zeros((0, 1))])
    begins = np.r_[True, (np.diff(u, axis=0) != 0).any(axis=1)]
    anew = [n for n in rest if n.unit is None and _counts_in_holds(out.values[n.column], begins)]
    if len(anew) < len(rest) or out.markers:
        out.remarks += [f"column {n.column!r} counts the rows of each hold and is left out" for n in anew]
        rest = [n for n in rest if n not in anew]
    else:
        anew = []
    return [*anew, *_find_labels_of_holds(out, rest, u, begins)]


def _find_labels_of_holds(out: "Roles", rest: list[Name], u: Floats, begins: NDArray[np.bool_]) -> list[Name]:
    """The columns of `rest` that are numbers of holds or sessions of inputs (n, C); `begins` (n,) where holds do."""
    found = [n for n in rest if n.unit is None and _only_counts(out.values[n.column], begins)]
    if not (np.diff(u, axis=0) < 0).any() or (len(found) == len(rest) and not out.markers):
        return []
    for n in found:
        jumps = np.r_[False, np.diff(out.values[n.column]) != 0]
        several = np.logical_or(begins, jumps).sum() >= _HOLDS * (jumps.sum() + 1)
        what = "taken for a counter, and is left out"
        if several and out.session is None:
            out.session, what = n, "taken for the session"
        out.remarks.append(
            f"column {n.column!r} is a whole number that never falls and stands still in holds: {what}"
        )
    return found


def _counts_in_holds(values: Floats, begins: NDArray[np.bool_]) -> bool:
    """Whether numbers (n,) rise by one step all through each of several holds, and begin anew with the next."""
    step, goes_on = np.diff(values), ~begins[1:]
    if begins.sum() < _HOLDS or not goes_on.any() or goes_on.mean() < 0.5:
        return False
    up = float(step[goes_on][0])
    return bool(up > 0 and (step[goes_on] == up).all() and (values[begins] == values[0]).all())


def _only_counts(values: Floats, begins: NDArray[np.bool_]) -> bool:
    """Whether numbers (n,) are whole, hardly one left out, and go up where holds begin, by the inputs or by them."""
    step = np.diff(values)
    few = (
        is_held(values) and (values == np.round(values)).all() and np.ptp(values) < 2 * len(np.unique(values))
    )
    return bool(few and step.any() and (step >= 0).all()) and parts_holds(np.r_[False, step != 0], begins)


def _bare(name: Name) -> list[str]:
    """The words of a name without numbers."""
    return [word for word in name.words if not word.isdigit()]


def _is_clock_too(name: Name, values: Floats, clock_s: Floats | None, clock: list[str] | None) -> bool:
    """Whether a column that is called a time, or as the `clock` is, goes as that does, in a unit of its own and from
    another zero.
    """
    called = bool(_TIME.search(name.column)) or _bare(name) == clock
    if clock_s is None or not called or not np.isfinite(values).all():
        return False
    step_s = float(np.median(np.abs(np.diff(clock_s)))) if len(clock_s) > 1 else 0.0
    off = (np.ptp((values - values[0]) / each - (clock_s - clock_s[0])) for each in (1.0, 1e3, 1e6, 1e9))
    return bool(min(off) < step_s)


def _begins_anew(name: Name, values: Floats, clock_s: Floats | None) -> bool:
    """Whether a column that is called a time goes as the clock does wherever it does not begin anew, as the time since
    a cycle began.
    """
    if clock_s is None or not _TIME.search(name.column) or not np.isfinite(values).all():
        return False
    step, step_s = np.diff(values), np.diff(clock_s)
    on = step > 0
    anew = on.mean() > 0.5 and (step < 0).any() if len(step) else False
    return bool(anew) and any(np.allclose(step[on], each * step_s[on], rtol=0.05) for each in (1.0, 1e3, 1e6))


def _unit_in_holds(name: Name, values: Floats, clock_s: Floats | None) -> str | None:
    """The unit of the time since a set-point, of a column that is called so: its own, or that in which it goes as far
    as the clock does wherever it does not begin anew. None where it is no such time.
    """
    if "hold" in name.words and name.unit is not None:
        return name.unit if name.unit in _IN_HOLDS else None
    since = bool(_SINCE & set(name.words)) and (
        name.unit in _IN_HOLDS or (name.unit is None and name.has(names.TIME))
    )
    if "hold" not in name.words and not since:
        return None
    if clock_s is None or not np.isfinite(values).all():
        return None
    step, step_s = np.diff(values), np.diff(clock_s)
    on = step > 0
    if not on.any() or not (step < 0).any():
        return None
    units = _IN_HOLDS if name.unit is None else (name.unit,)
    goes = (
        unit for unit in units if np.allclose(step[on] * factor(unit, "s", "hold"), step_s[on], rtol=0.05)
    )
    return next(goes, None)


def _restarts(values: Floats, clock_s: Floats | None) -> bool:
    """Whether the clock goes back where a column changes, and nowhere else."""
    if clock_s is None:
        return False
    back = np.diff(clock_s) < 0
    return bool(back.any() and (back == (np.diff(values) != 0)).all())


def _is_number(name: Name, rows: bool) -> bool:
    """Whether a column is called a number of something, or a capture and nothing else."""
    ends = {*name.words[:1], *(name.words[-1:] if rows else ())}
    if ends & names.COUNTER or name.words == ("n",):
        return True
    return name.has(names.CAPTURE) and all(word in names.CAPTURE or word.isdigit() for word in name.words)


def _rises_evenly(values: Floats) -> bool:
    step = np.diff(values)
    return len(step) > 0 and bool(step[0] > 0 and (step == step[0]).all())


def _counts(name: Name, values: Floats) -> bool:
    """Whether a column is called a number of something, and goes up by one at a time."""
    return (
        name.words[:1] != ()
        and name.words[0] in names.COUNTER
        and bool(np.isin(np.diff(values), (0, 1)).all())
    )


def _counts_set_points(name: Name, all_of_them: Sequence[Name], values: Mapping[str, Floats]) -> bool:
    """Whether a column goes up by one where the pressures beside it change: it is the number of the set-point.

    One that is called a pressure is none; one that is not called a set-point either must have gone up a few times.
    """
    step = np.diff(values[name.column])
    commanded = name.has(names.COMMANDED)
    if name.unit is not None or not np.isin(step, (0, 1)).all() or name.has(names.PRESSURE):
        return False
    if not commanded and (step.sum() < _A_FEW or step.all()):
        return False
    said = names.PRESSURE if commanded else names.PRESSURE | names.COMMANDED
    pressures = [values[n.column] for n in all_of_them if n is not name and n.has(said)]
    moves = np.any([np.diff(p) != 0 for p in pressures], axis=0) if pressures else np.zeros(len(step), bool)
    return bool(moves.any() and (moves <= (step == 1)).all())


def _spread_of(name: Name, all_of_them: Sequence[Name]) -> Name | None:
    """What a column is the spread of: another one of the same name and unit, but for the word for it."""
    bare = tuple(word for word in name.words if word not in _SPREAD)
    if not bare or bare == name.words:
        return None
    return next(
        (
            n
            for n in all_of_them
            if n is not name and n.unit == name.unit and tuple(w for w in n.words if w not in _MEAN) == bare
        ),
        None,
    )


def _without_parts_of_the_clock(out: "Roles", rest: list[Name]) -> list[Name]:
    """Leave out milliseconds beside a clock, and years, months, days, hours, minutes and seconds."""
    dated = {n.column for n in rest if len(n.words) == 1 and n.words[0] in OF_A_DATE and n.unit is None}
    if len({n.words for n in rest if n.column in dated}) < 2 and (out.time is None or dated & {"Day", "day"}):
        dated = set()
    kept = []
    for n in rest:
        if n.column in dated or (out.time is not None and _within_a_second(n, out.values[n.column])):
            out.remarks.append(f"column {n.column!r} is a part of the clock, no measurement, and is left out")
        else:
            kept.append(n)
    return kept


def _within_a_second(name: Name, values: Floats) -> bool:
    if name.unit is None and counts_parts(name):
        return True
    if name.unit not in _OF_A_SECOND or not name.words[-1:] or name.words[-1] not in names.TIME:
        return False
    return bool(
        (values >= 0).all() and (values < _OF_A_SECOND[name.unit]).all() and (np.diff(values) < 0).any()
    )


def refuse_long(table: Table, time: str) -> None:
    """Raise `LabrigError` where each time has several rows, one for each marker or quantity that a column names."""
    import pandas as pd

    columns = {str(c): c for c in table.frame.columns}
    moments, _ = pd.factorize(table.frame[columns[time]])
    size = np.bincount(moments[moments >= 0])
    if not len(size) or (several := int(np.median(size))) < 2:
        return
    for name, column in columns.items():
        values = table.frame[column]
        words = take_apart(name).words
        if name == time or (
            values.dtype.kind in "fiub" and not set(words[:1]) & (names.COUNTER | names.LABEL)
        ):
            continue
        label, found = pd.factorize(values)
        pairs = pd.DataFrame({"at": moments, "label": label})
        few = several <= len(found) <= min(2 * several, len(size))
        if int((np.diff(label) != 0).sum()) + 1 == len(found):  # sessions, one behind the other
            continue
        if few and (label >= 0).all() and not pairs.duplicated().any() and _come_again(pairs, several):
            have = [short(str(v) if isinstance(v, str) else f"m{v:g}", quote=False) for v in found[:3]]
            wanted = (
                [f"{one}.{axis}" for one in have[:1] for axis in "xyz"]
                if {"x", "y"} <= _axes(columns)
                else have
            )
            raise LabrigError(
                f"{table.path}: has {several} rows at one time, which column {name!r} tells apart; make it one row of "
                f"each time (pivot it), with columns such as {', '.join(wanted)}"
            )


def refuse_turns(table: Table, parsed: list[Name], values: Mapping[str, Floats]) -> None:
    """Raise `LabrigError` where rows take turns, one for each sensor or marker that a column numbers, while all that
    was commanded stands still.
    """
    for n in parsed:
        if not n.has(names.LABEL) or n.has(names.COMMANDED) or n.unit is not None:
            continue
        turn = values[n.column]
        several = len(np.unique(turn))
        whole = len(turn) - len(turn) % several
        each = turn[:whole].reshape(-1, several)
        if several < 2 or len(each) < _TURNS or len(np.unique(each[0])) < several or (each != each[0]).any():
            continue
        others = (values[m.column][:whole].reshape(-1, several) for m in parsed if m is not n)
        if any((o == o[:, :1]).all() and np.ptp(o) for o in others):
            have = ", ".join(f"{v:g}" for v in each[0][:3]) + (", ..." if several > 3 else "")
            raise LabrigError(
                f"{table.path}: has {several} rows for each measurement, which column {n.column!r} tells apart; make "
                f"it one row (pivot it), with a column for each of {have}"
            )


def _axes(columns: Iterable[str]) -> set[str | None]:
    return {take_apart(name).axis for name in columns}


def _come_again(pairs: "pd.DataFrame", several: int) -> bool:
    """Whether the same labels come at nearly all times."""
    often = pairs["label"].value_counts().head(several)
    return bool((often >= 0.8 * pairs["at"].nunique()).all())
