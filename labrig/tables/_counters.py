"""Columns that go up by one with each set-point: they number the captures, whatever they are called."""

from collections.abc import Mapping, Sequence
from typing import TYPE_CHECKING

import numpy as np
from numpy.typing import NDArray

from labrig.arrays import Floats
from labrig.tables._names import Name

if TYPE_CHECKING:
    from labrig.tables._roles import Roles

_A_FEW = 4
"""Steps from which on a column counts."""
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


def _counts(name: Name, values: Mapping[str, Floats], moves: NDArray[np.bool_]) -> bool:
    """Whether a column goes up by one, a few times, and wherever an input changes (n - 1,)."""
    if name.column not in values or name.unit not in (None, "1"):
        return False
    step = np.diff(values[name.column])
    counts = np.isin(step, (0, 1)).all() and step.sum() >= _A_FEW
    return bool(counts and moves.any() and (moves <= (step == 1)).all())


def _one_set_point_each(
    name: Name, values: Mapping[str, Floats], moves: NDArray[np.bool_], clock_s: Floats | None
) -> bool:
    """Whether what is called a session has one set-point only, in each of many, and the next goes on by its clock."""
    if name.column not in values or (clock_s is not None and (np.diff(clock_s) < 0).any()):
        return False
    step = np.diff(values[name.column]) != 0
    return bool(step.sum() + 1 >= _SESSIONS and (moves <= step).all() and 2 * moves.sum() > step.sum())
