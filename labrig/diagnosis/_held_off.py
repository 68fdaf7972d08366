"""Whole holds of a marker or a sensor that were left out as mistaken: said by their captures, for nobody knows."""

from collections.abc import Sequence

import numpy as np

from labrig.arrays import Floats
from labrig.contents import HeldOff
from labrig.diagnosis._amount import amount
from labrig.effects import Rows

_ROWS = 3
"""Rows of a hold, at least, from which it can be told to be off all along."""
_ALIKE = 0.5
"""By how much of its error, at most, such a hold changes: what comes and goes is no set-point's."""
_NAMED = 6  # captures in a line


def held_off(rows: Rows, raw: Floats, kept: Floats) -> list[HeldOff]:
    """Where a marker or sensor was left out through whole holds and was off all along, by as much.

    A mistake can look like that (a marker that another took the place of), and so can what acts at a few set-points
    only (a wall that is met there). `raw` (F, K) is the residual as it was, `kept` without what was left out.
    """
    gone = np.isfinite(raw) & ~np.isfinite(kept)
    owner = np.where(rows.marker >= 0, rows.marker, -1 - np.arange(len(rows.marker)))
    found: dict[str, tuple[list[int], list[float], str]] = {}
    for capture in np.unique(rows.capture[gone.any(axis=1)]).tolist():
        own = rows.capture == capture
        for one in np.unique(owner[gone[own].any(axis=0)]).tolist():
            values = raw[np.ix_(own, owner == one)]
            whole = (
                np.isfinite(values).all(axis=1).sum() >= _ROWS
                and not np.isfinite(kept[np.ix_(own, owner == one)]).any()
            )
            if not whole:
                continue
            mean = np.nanmean(values, axis=0)
            size = float(np.linalg.norm(mean))
            if np.linalg.norm(np.nanstd(values, axis=0)) > _ALIKE * size:
                continue
            k = int(np.flatnonzero(owner == one)[0])
            name = rows.markers[one] if one >= 0 else rows.observables[k]
            captures, sizes, _ = found.setdefault(name, ([], [], rows.unit[k]))
            captures.append(capture)
            sizes.append(size)
    return [
        {"name": name, "captures": captures, "error": max(sizes), "units": unit}
        for name, (captures, sizes, unit) in found.items()
    ]


def held_off_lines(found: Sequence[HeldOff]) -> list[str]:
    """A line on each."""
    out = []
    for each in found:
        shown = ", ".join(map(str, each["captures"][:_NAMED]))
        more = ", ..." if len(each["captures"]) > _NAMED else ""
        several = "s" if len(each["captures"]) > 1 else ""
        out.append(
            f"{each['name']} was left out in capture{several} {shown}{more}, where it is off all along the hold, by up "
            f"to {amount(each['error'], each['units'])}: mistaken, or held by something that acts there only; measure "
            f"{'these set-points' if several else 'this set-point'} again, which tells"
        )
    return out
