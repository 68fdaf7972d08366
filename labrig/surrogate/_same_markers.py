"""Whether a run's markers can be a model's: by size, by hand, and by name."""

import numpy as np

from labrig._errors import LabrigError
from labrig.arrays import Bools, Floats, Ints

_FEWEST = 3
_OTHER_SIZE = 5.0
"""Times as far apart as the model's from which on the unit is asked about."""
_MIRRORED = 0.4
"""So much nearer to the model a mirror image comes than any motion, where an axis is wrong."""
_EXCHANGED = 0.25


def check_markers(names: tuple[str, ...], here_mm: Floats, there_mm: Floats, seen: Bools) -> None:
    """Raise `LabrigError` where a run's markers, `there_mm` (F, M, 3), are the model's, `here_mm`, in another unit, in
    a mirror, or with names exchanged; `seen` (F, M). Fewer than three markers do not tell.
    """
    if seen.any(axis=0).sum() < _FEWEST:
        return
    a, b = here_mm[seen], there_mm[seen]
    a, b = a - a.mean(axis=0), b - b.mean(axis=0)
    times = float(np.linalg.norm(b) / np.linalg.norm(a))
    if not 1 / _OTHER_SIZE < times < _OTHER_SIZE:
        raise LabrigError(
            f"sim2real: the run's markers lie {times:.3g} times as far apart as the model's: are their places in mm?"
        )
    left, _, right = np.linalg.svd(b.T @ a)
    hand = np.sign(np.linalg.det(left @ right))
    moved, mirrored = (
        float(np.linalg.norm(b - a @ (left @ np.diag([1.0, 1.0, sign]) @ right).T)) for sign in (hand, -hand)
    )
    if mirrored < _MIRRORED * moved:
        raise LabrigError(
            "sim2real: the run's markers are a mirror image of the model's: an axis has the other sign, or two are "
            "exchanged; import them in a right-handed frame (where z and y are exchanged, one also changes its sign)"
        )
    _check_names(names, a @ (left @ np.diag([1.0, 1.0, hand]) @ right).T, b, np.nonzero(seen)[1])


def _check_names(names: tuple[str, ...], here_mm: Floats, there_mm: Floats, marker: Ints) -> None:
    """Raise `LabrigError` where two markers are each where the model has the other; (n, 3), of each `marker` (n,)."""
    own = np.unique(marker)
    here, there = (np.array([x[marker == m].mean(axis=0) for m in own]) for x in (here_mm, there_mm))
    apart = np.linalg.norm(there[:, None] - here[None], axis=2)
    nearest = apart.argmin(axis=1)
    for i, j in enumerate(nearest.tolist()):
        far = min(apart[i, i], apart[j, j])
        if nearest[j] == i != j and max(apart[i, j], apart[j, i]) < _EXCHANGED * far:
            raise LabrigError(
                f"sim2real: the run's markers {names[own[i]]} and {names[own[j]]} are each where the model has the "
                "other: exchange their names"
            )
