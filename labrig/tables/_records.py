"""Records side by side in one table: each has a clock of its own, and the same columns behind it."""

from collections.abc import Mapping
from itertools import pairwise

import numpy as np

from labrig.arrays import Floats
from labrig.tables._names import Name
from labrig.tables._time import called_times


def one_record(parsed: list[Name], values: Mapping[str, Floats], remarks: list[str]) -> list[Name]:
    """The columns without those of other records, as of other specimens; that they are left out is said.

    A row of two records is not one time. Columns that come again with the same clock are of one record, as where each
    channel was written with its time.
    """
    at = [k for k, n in enumerate(parsed) if n in called_times(parsed)]
    if len(at) < 2:
        return parsed
    blocks = [parsed[a:b] for a, b in pairwise([*at, len(parsed)])]
    many, kind = len(blocks[0]), _kind(blocks[0])
    alike = [block[:many] for block in blocks if many > 1 and _kind(block[:many]) == kind]
    main = next((block for block in alike if np.isfinite(values[block[0].column]).all()), blocks[0])
    clock = values[main[0].column]
    others = [b for b in alike if not np.array_equal(values[b[0].column], clock, equal_nan=True)]
    remarks += [
        f"column {block[0].column!r} is the clock of another record ({', '.join(n.column for n in block[1:])}), which "
        "is left out: give it a file of its own"
        for block in others
    ]
    return [n for n in parsed if not any(n in block for block in others)]


def _kind(block: list[Name]) -> list[tuple[str, ...]]:
    """What columns are called, without numbers and what all of them are called."""
    shared = set.intersection(*(set(n.words) for n in block))
    return [tuple(w for w in n.words if w not in shared and not w.isdigit()) for n in block]
