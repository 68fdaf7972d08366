"""Which captures are left out together."""

import numpy as np

from labrig.arrays import Ints
from labrig.effects import MOST_SESSIONS, Context

MAX_GROUPS = MOST_SESSIONS + 1
"""Most blocks that are left out in turn."""
_MANY_SESSIONS = 6
"""Sessions from which on each has a stretch in every block."""
_FEWEST_BLOCKS = 3
"""Blocks, at least, that each of a few sessions has."""
_FEW_BLOCKS = 2
"""Blocks that each session would have by its captures, at least, where all are cut as one."""
_LONG_HOLD = 0.4
"""Share of the rows from which on a single hold is most of a session, which is then cut by rows."""


def blocks_of(context: Context, index: Ints, use_means: bool) -> Ints:
    """Which block each row is left out with: sessions where none can have a value of its own, else stretches of them.

    Beside a much longer session a short one has blocks of its own, three or more, so that what a follow-up
    run says is heard. Of six sessions and more a block has one stretch of each. A stretch is one of captures, or of
    rows where a single hold is most of it all.
    """
    rows = context.rows
    if not use_means:
        place = np.arange(len(index)) - np.searchsorted(index, index)
        length = np.bincount(index)[index]
        return np.minimum((place * MAX_GROUPS) // length, MAX_GROUPS - 1).astype(np.int64)
    n = int(index.max()) + 1
    sessions = np.unique(rows.session)
    if len(sessions) > MOST_SESSIONS or len(sessions) == n:
        return (np.searchsorted(sessions, rows.session) * min(len(sessions), MAX_GROUPS)) // len(sessions)
    group = np.zeros(len(index), dtype=np.int64)
    first = 0
    members = [np.flatnonzero(rows.session == s) for s in sessions]
    sizes = [len(np.unique(index[m])) for m in members]
    many = len(sessions) >= _MANY_SESSIONS
    if not many and min(sizes) * MAX_GROUPS >= _FEW_BLOCKS * n:
        members, sizes = [np.arange(len(index))], [n]
    shares = [MAX_GROUPS // 2] * len(sessions) if many else _share_out(sizes)
    for own, blocks in zip(members, shares, strict=True):
        captures, place = np.unique(index[own], return_inverse=True)
        longest = np.bincount(place).max() / len(own)
        if len(captures) < blocks or longest > _LONG_HOLD:
            place, length = np.arange(len(own)), len(own)
        else:
            length = len(captures)
        group[own] = first + (place * min(blocks, length)) // length
        first += 0 if many else min(blocks, length)
    return group


def _share_out(captures: list[int]) -> list[int]:
    """How many of the blocks each session gets, by its captures, no fewer than three."""
    total = sum(captures)
    least = min(_FEWEST_BLOCKS, MAX_GROUPS // len(captures))
    out = [max(least, round(MAX_GROUPS * c / total)) for c in captures]
    while sum(out) > MAX_GROUPS:
        out[int(np.argmax(out))] -= 1
    return out
