"""Columns that number captures or set-points, whatever they are called: by what was commanded beside them."""

from collections.abc import Mapping, Sequence
from typing import TYPE_CHECKING

import numpy as np
from numpy.typing import NDArray

from labrig.arrays import Floats
from labrig.tables import _names as names
from labrig.tables._inputs import A_FEW, counts_up, find_commands, is_pressure
from labrig.tables._names import Name

if TYPE_CHECKING:
    from labrig.tables._roles import Roles

_SESSIONS = 12
"""So many blocks of rows with one set-point each are no sessions; fewer may be records of one hold each."""
_NUMBER = "taken for the number of the capture, and for no session or repeat"
_COUNTED = "counts set-points and is left out"


def number_captures(
    out: "Roles", rest: Sequence[Name], inputs: Sequence[Name], clock_s: Floats | None
) -> list[Name]:
    """The columns of `rest` that number captures, and were neither set nor measured.

    The first is the capture, where several rows have one number and nothing else is; what is left out is said. So is
    what is called a session or a repeat, and does the same: a session holds many set-points. `clock_s` (n,) are the
    times of the rows, where they are known.
    """
    if not inputs:
        return []
    u = np.column_stack([out.values[n.column] for n in inputs])
    moves = (np.diff(u, axis=0) != 0).any(axis=1)
    found = [n for n in rest if _counts(n, out.values, moves)]
    if not (np.diff(u, axis=0) < 0).any() or (len(found) == len(rest) and not out.markers):
        return []
    labels = []
    if out.session is not None and _one_set_point_each(out.session, out.values, moves, clock_s):
        labels.append(out.session)
        out.session = None
    if out.repeat is not None and _counts(out.repeat, out.values, moves):
        labels.append(out.repeat)
        out.repeat = None
    for n in [*labels, *found]:
        if out.capture is None and (np.diff(out.values[n.column]) == 0).any():
            out.capture = n
            if n in labels:
                out.remarks.append(f"column {n.column!r} is another at each set-point: {_NUMBER}")
        else:
            out.remarks.append(f"column {n.column!r} {_COUNTED}")
    return found


def number_set_points(out: "Roles", rest: Sequence[Name]) -> list[Name]:
    """The columns of `rest`, and of what is called a number, that number set-points: 1, 2, 3 ... in any order, each
    always with the same commands.

    The first says which captures repeat each other, where numbers come again and nothing else does; what each is taken
    for is said. What is called a command, too, is a number beside others that are, or where it is called a number.
    """
    able = [n for n in (*rest, *out.numbers) if _may_number(n, out.values[n.column])]
    others = [n for n in rest if n not in able]
    if not able or not (others or out.markers):
        return []
    inputs, _ = find_commands(others, out.values)
    if not inputs or (len(inputs) == len(others) and not out.markers):
        return []
    u = np.column_stack([out.values[n.column] for n in inputs])
    commanded = all(n.has(names.COMMANDED) for n in inputs)
    found = [
        n
        for n in able
        if (commanded or n.has(names.COUNTER) or not n.has(names.COMMANDED | names.INPUT))
        and _one_to_one(out.values[n.column], u)
    ]
    for n in found:
        blocks = int((np.diff(out.values[n.column]) != 0).sum()) + 1
        what = "and is left out"
        if out.repeat is None and blocks > len(np.unique(out.values[n.column])):
            out.repeat, what = n, "and says which captures repeat each other"
        elif n in out.numbers:
            continue
        if n in out.numbers:
            out.remarks.remove(said_of_number(n))
        out.remarks.append(f"column {n.column!r} has one number for each set-point {what}")
    return found


def said_of_number(n: Name) -> str:
    """What is said of a column that is called a number of something."""
    return f"column {n.column!r} is a number or a name, no measurement, and is left out"


def _may_number(n: Name, values: Floats) -> bool:
    """Whether numbers (n,) without a unit are whole, several, none of them left out, from 0 or 1 on."""
    seen = np.unique(values)
    if n.unit is not None or n.written or is_pressure(n) or n.has(names.MEASURED | names.OUTPUT | names.DUTY):
        return False
    first = seen[0] if len(seen) > A_FEW else np.nan
    return bool(first in (0, 1) and (seen == first + np.arange(len(seen))).all())


def _one_to_one(numbers: Floats, u: Floats) -> bool:
    """Whether each number (n,) always has the same commands (n, C), and they have no other, but for those of one place
    to which a programme may return, as where all is vented. What only goes up numbers captures.
    """
    if not np.isfinite(u).all() or not (np.diff(numbers) < 0).any():
        return False
    _, place = np.unique(u, axis=0, return_inverse=True)
    pairs = np.unique(np.column_stack([numbers, place.reshape(-1)]), axis=0)
    have = np.bincount(pairs[:, 1].astype(int))
    return bool(len(pairs) == len(np.unique(numbers)) and len(have) > A_FEW and (have > 1).sum() <= 1)


def _counts(name: Name, values: Mapping[str, Floats], moves: NDArray[np.bool_]) -> bool:
    """Whether a column goes up by one, a few times, and wherever an input changes (n - 1,)."""
    if name.column not in values or name.unit not in (None, "1"):
        return False
    own = values[name.column]
    return bool(counts_up(own) and moves.any() and (moves <= (np.diff(own) == 1)).all())


def _one_set_point_each(
    name: Name, values: Mapping[str, Floats], moves: NDArray[np.bool_], clock_s: Floats | None
) -> bool:
    """Whether what is called a session has one set-point only, in each of many, and the next goes on by its clock."""
    if name.column not in values or (clock_s is not None and (np.diff(clock_s) < 0).any()):
        return False
    step = np.diff(values[name.column]) != 0
    return bool(step.sum() + 1 >= _SESSIONS and (moves <= step).all() and 2 * moves.sum() > step.sum())
