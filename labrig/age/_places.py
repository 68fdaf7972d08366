"""Where each marker is off from where the model has it, at rest if the run was at rest; and what all share."""

from collections.abc import Iterator

import numpy as np
from scipy.linalg import lstsq

from labrig.age._known import Beside
from labrig.age._reading import Reading, reading
from labrig.arrays import Bools, Floats, Ints
from labrig.diagnosis import capture_means

_ROUNDS = 8
_FAR = 4.0
_FEWEST = 5
_AT_REST = 0.01


def place_readings(beside: Beside) -> Iterator[Reading | None]:
    """A shift, mm, of each marker by itself, and of the cameras: what all markers do together, as one rigid body.

    The rigid motion is fitted robustly, so that a marker that slipped does not carry the others along.
    """
    rows = beside.context.rows
    if rows.rest_mm is None or set(rows.unit) != {"mm"} or not (rows.marker >= 0).any():
        return
    off, sd = _offsets(beside)
    place = rows.rest_mm[: len(off)]
    known = np.asarray(np.isfinite(off).all(axis=1) & np.isfinite(place).all(axis=1))
    if known.sum() < _FEWEST:
        return
    motion, motion_sd, left = _rigid(place, off, sd, known)
    yield reading("frame", "shift", motion[:3].tolist(), float(motion_sd[:3].mean()), "mm")
    yield reading("frame", "turn", (1e3 * motion[3:]).tolist(), 1e3 * float(motion_sd[3:].mean()), "mrad")
    for m in np.flatnonzero(known):
        yield reading("marker", rows.markers[m], left[m].tolist(), float(sd[m]), "mm")


def _offsets(beside: Beside) -> tuple[Floats, Floats]:
    """The mean error of each marker, (M, 3) mm, and its standard deviation (M,); NaN where it was never seen."""
    rows = beside.context.rows
    means, captures = capture_means(beside.residual, rows.capture)
    means = means[_chosen(beside, captures)]
    seen = np.isfinite(means)
    count = seen.sum(axis=0)
    mean = np.where(count > 0, np.where(seen, means, 0.0).sum(axis=0) / np.maximum(count, 1), np.nan)
    sd_each = beside.floor.row / np.sqrt(np.maximum(count, 1))
    markers = len(rows.rest_mm) if rows.rest_mm is not None else 0
    off, sd = np.full((markers, 3), np.nan), np.full(markers, np.nan)
    for m in range(markers):
        own = np.flatnonzero(rows.marker == m)
        if len(own) == 3:
            off[m, rows.axis[own]] = mean[own]
            sd[m] = np.sqrt((sd_each[own] ** 2).mean())
    return off, sd


def _chosen(beside: Beside, captures: Ints) -> Bools:
    """Captures at rest before anything was filled; else all that are at rest; else all."""
    rows = beside.context.rows
    first = np.searchsorted(rows.capture, captures)
    resting = np.abs(rows.fraction[first]).max(axis=1) <= _AT_REST
    filled = np.abs(rows.event_actuation).max(axis=1) > _AT_REST * float((rows.high - rows.low).max())
    before = rows.event[first] < (np.argmax(filled) if filled.any() else len(filled))
    for chosen in (resting & before, resting):
        if chosen.any():
            return chosen
    return np.ones(len(captures), dtype=bool)


def _rigid(place: Floats, off: Floats, sd: Floats, known: Bools) -> tuple[Floats, Floats, Floats]:
    """A small rigid motion about the middle of the markers, least squares over those that it fits.

    Shift, mm, and turn, rad, (6,); their standard deviations (6,); what it leaves of the offsets (M, 3). A trimmed
    M-estimate.
    """
    about = place - place[known].mean(axis=0)
    modes = np.zeros((len(place), 3, 6))
    modes[:, :, :3] = np.eye(3)
    for axis in range(3):
        modes[:, :, 3 + axis] = np.cross(np.eye(3)[axis], about)
    used = known.copy()
    motion = np.zeros(6)
    for _ in range(_ROUNDS):
        found = lstsq(modes[used].reshape(-1, 6), off[used].ravel())
        motion = np.asarray(found[0]) if found is not None else motion
        size = np.linalg.norm(off - modes @ motion, axis=1)
        usual = max(1.4826 * float(np.median(size[known])), float(np.median(sd[known])))
        now = known & (size <= _FAR * usual)
        if now.sum() < _FEWEST or (now == used).all():
            break
        used = now
    spread = np.linalg.pinv(np.einsum("mai,maj->ij", modes[used], modes[used]), hermitian=True)
    noise = float(np.median(sd[used]))
    return motion, noise * np.sqrt(np.diag(spread)), off - modes @ motion
