"""Markers that a run lost on its way: seen in no frame of many captures, or of all from one capture on."""

from collections.abc import Sequence
from typing import TYPE_CHECKING

import numpy as np

if TYPE_CHECKING:
    from numpy.typing import NDArray
    from xarray import Dataset

    from labrig.arrays import Floats

_AT_THE_END = 3
"""From so many captures without it at the end of a run on a marker is lost; one that is covered comes back."""
_SHARE_AT_THE_END = 0.1
_SHARE = 1 / 3
"""In so many of the captures, anywhere, a marker is missed; fewer are those that a pose of the body covers."""
_NAMED = 4


def lost_markers(run: "Dataset") -> list[str]:
    """A line for each marker, or group that went together, that a run lost: how often, and since which capture."""
    if "position_mm" not in run:
        return []
    return lost_of(run["marker"].values.tolist(), np.asarray(run["position_mm"].values, float))


def lost_of(markers: Sequence[str], position_mm: "Floats") -> list[str]:
    """The same of the markers' names (M,), and their places, (n, T, M, 3) mm, NaN where they were not seen."""
    if not len(position_mm):
        return []
    seen = np.any(np.asarray(np.isfinite(position_mm).all(axis=3)), axis=1)  # captures, markers
    groups: dict[bytes, list[str]] = {}
    for name, own in zip(markers, list(seen.T), strict=True):
        if _is_lost(own):
            groups.setdefault(own.tobytes(), []).append(str(name))
    return [_line(names, np.frombuffer(own, dtype=bool)) for own, names in groups.items()]


def _is_lost(seen: "NDArray[np.bool_]") -> bool:
    n = len(seen)
    at_the_end = n - _end(seen)
    return (~seen).sum() >= max(_SHARE * n, 1) or at_the_end >= max(_AT_THE_END, _SHARE_AT_THE_END * n)


def _end(seen: "NDArray[np.bool_]") -> int:
    """The capture from which on it was never seen again; as many as there are where it was seen in the last."""
    return int(np.flatnonzero(seen)[-1]) + 1 if seen.any() else 0


def _line(names: Sequence[str], seen: "NDArray[np.bool_]") -> str:
    n, gone = len(seen), int((~seen).sum())
    more = [f"{len(names) - _NAMED} more"] if len(names) > _NAMED else []
    listed = [*names[:_NAMED], *more]
    who = " and ".join(filter(None, (", ".join(listed[:-1]), listed[-1])))
    were = "was" if len(names) == 1 else "were"
    why = "fallen off, covered, or without a label?"
    if gone == n:
        return f"{who} {were} never seen, in {n} captures: {why}"
    if (end := _end(seen)) < n:
        when = f"not once since capture {end}"
    else:
        when = f"first in capture {int(np.flatnonzero(~seen)[0])}"
    return f"{who} {were} not seen in {gone} of {n} captures ({100 * gone / n:.0f} %), {when}: {why}"
