"""Numbers that stand for something that was not seen: trackers and loggers write one where they have none."""

from collections.abc import Sequence

import numpy as np

from labrig.arrays import Floats, Ints

_FEWEST = 2
_FAR = 100.0
"""Times the range of all others by which a number that comes again and again is off."""
_JUMP = 0.5
"""Share of its range that a marker keeps from the origin in all rows where it is seen: rest may be there."""
_HUGE = 1e20


def unseen(values: Floats, names: Sequence[str], marker: Ints) -> tuple[Floats, list[str]]:
    """Values (n, K) of observables with NaN where nothing was seen, and a line for each that had such numbers.

    `marker` (K,) numbers the markers, -1 elsewhere. Not seen is a marker at exactly 0, 0, 0 that is never near it else,
    and a number that comes back exactly and lies farther from all others than a hundred times their range.
    """
    out, said = values.copy(), []
    for k, name in enumerate(names):
        if (code := _code(out[:, k])) is not None:
            gone = out[:, k] == code
            out[gone, k] = np.nan
            said.append(
                f"{name} is {code:g} in {gone.sum()} rows, far from all others: taken as not measured there"
            )
    for m in np.unique(marker[marker >= 0]).tolist():
        own = np.flatnonzero(marker == m)
        gone = (out[:, own] == 0).all(axis=1)
        seen = ~gone & np.isfinite(out[:, own]).all(axis=1)
        if len(own) < 2 or not gone.any() or seen.sum() < _FEWEST:
            continue
        away = np.linalg.norm(out[np.ix_(seen, own)], axis=1)
        if away.min() > _JUMP * np.linalg.norm(np.ptp(out[np.ix_(seen, own)], axis=0)):
            out[np.ix_(gone, own)] = np.nan
            who = ", ".join(names[k] for k in own.tolist())
            said.append(
                f"{who} are exactly 0 in {gone.sum()} rows, and far from it in all others: not seen there"
            )
    return out, said


def _code(values: Floats) -> float | None:
    """The number that stands for nothing in a column (n,), if there is one."""
    known = values[np.isfinite(values)]
    if not len(known):
        return None
    far = float(known[np.abs(known).argmax()])
    others = known[known != far]
    count = len(known) - len(others)
    if abs(far) > _HUGE:
        return far
    if count < _FEWEST or count > len(others):
        return None
    spread = float(np.ptp(others))
    return far if spread > 0 and np.abs(others - far).min() > _FAR * spread else None
