"""Angles that begin again after a whole turn, and quaternions, which are the same turn with either sign.

Both jump where the body does not: from 179 to -179 degrees, from a quaternion to its negative. A mean over such rows is
of no use, nor is a map that is fitted to them.
"""

from collections.abc import Sequence

import numpy as np

from labrig._turns import quaternions, turn_of
from labrig.arrays import Floats

_JUST, _FREE = 1 / 12, 1 / 2
"""Shares of a turn: so little lies between both ends of what was seen, and so much is free elsewhere."""


def opened(names: Sequence[str], units: Sequence[str], values: Floats) -> tuple[Floats, list[str]]:
    """Values (n, K) of observables without such jumps, and a line for each that had them.

    An angle of which half a turn was never seen goes on over the end of its scale. A quaternion has, in each row, the
    sign in which it is nearest to most others.
    """
    out, said = values.copy(), []
    for k, unit in enumerate(units):
        turn, known = turn_of(unit), np.isfinite(out[:, k])
        cut = _cut(out[known, k], turn) if turn else None
        if cut is not None:
            out[known & (out[:, k] < cut), k] += turn
            low, high = (f"{end(out[known, k]):.4g}" for end in (np.min, np.max))
            said.append(
                f"{names[k]} begins again after a whole turn: here it goes on, from {low} to {high} {unit}"
            )
    for own in quaternions(units, values):
        four = out[:, own]
        whole = four[np.isfinite(four).all(axis=1)]
        main = np.linalg.eigh(whole.T @ whole)[1][:, -1]
        main = main * np.sign(main[np.abs(main).argmax()])
        other = four @ main < 0
        if other.any():
            out[other, own] *= -1
            said.append(
                f"{', '.join(names[own][:3])} and {names[own][3]} are a quaternion, the same turn with either sign: "
                f"{other.sum()} of {len(other)} rows have the other sign here"
            )
    return out, said


def _cut(angles: Floats, turn: float) -> float | None:
    """Where angles (n,) that were seen on both sides of the end of their scale are cut instead; None of others."""
    order = np.sort(angles)
    if len(order) < 2 or not (1 - _JUST) * turn <= order[-1] - order[0] <= turn:
        return None
    gaps = np.diff(order)
    widest = int(np.argmax(gaps))
    return float(order[widest : widest + 2].mean()) if gaps[widest] > _FREE * turn else None
