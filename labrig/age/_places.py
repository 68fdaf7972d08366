"""Where each marker is off from where the model has it, at rest if the run was at rest; and what all share."""

from collections.abc import Iterator
from itertools import combinations

import numpy as np

from labrig.age._known import Beside
from labrig.age._reading import Reading, reading
from labrig.arrays import Bools, Floats, Ints
from labrig.effects import capture_means

_ROUNDS = 3
_FAR = 4.0
"""Of the usual standard deviation of a coordinate: of a thousand markers that did not slip one is farther off."""
_MEDIAN = 1.538
"""Of the distance of a normal marker, in standard deviations of a coordinate: of chi with three degrees of freedom."""
_THREES = 500
"""Of so many triples of markers some are without one that slipped, even if nearly half of all have."""
_FEWEST = 5
"""Markers from which on one that slipped is told from cameras that moved (`slips_told`)."""
_AT_REST = 0.01


def place_readings(beside: Beside) -> Iterator[Reading | None]:
    """A shift, mm, of each marker by itself, and of the cameras: what all markers do together, as one rigid body.

    The rigid motion is fitted robustly, so that a marker that slipped does not carry the others along. Fewer than
    `_FEWEST` markers can't tell the two apart: then what each is off by is given as it is, and nothing of the cameras.
    """
    rows = beside.context.rows
    if rows.rest_mm is None or set(rows.unit) != {"mm"} or not (rows.marker >= 0).any():
        return
    off, sd = _offsets(beside)
    place = rows.rest_mm[: len(off)]
    known = np.asarray(np.isfinite(off).all(axis=1) & np.isfinite(place).all(axis=1))
    if known.sum() >= _FEWEST:
        motion, motion_sd, off = _rigid(place, off, sd, known)
        yield reading("frame", "shift", motion[:3].tolist(), float(motion_sd[:3].mean()), "mm")
        yield reading("frame", "turn", (1e3 * motion[3:]).tolist(), 1e3 * float(motion_sd[3:].mean()), "mrad")
    for m in np.flatnonzero(known):
        yield reading("marker", rows.markers[m], off[m].tolist(), float(sd[m]), "mm")


def slips_told(markers: int) -> int:
    """How many slipped markers, of so many in all, are told from cameras that moved.

    Any motion fits three markers, so of the others more must agree with it than not.
    """
    return max(markers - 3, 0) // 2


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

    Shift, mm, and turn, rad, (6,); their standard deviations (6,); what it leaves of the offsets (M, 3).

    Least trimmed squares (P. J. Rousseeuw, K. Van Driessen, Data Mining and Knowledge Discovery 12, 2006, 29-45): of
    the motions that three markers say, that with the least sum over as many markers as must agree, improved on those;
    then once more over all that are as near as chance allows.
    """
    about = place - place[known].mean(axis=0)
    modes = np.zeros((len(place), 3, 6))
    modes[:, :, :3] = np.eye(3)
    for axis in range(3):
        modes[:, :, 3 + axis] = np.cross(np.eye(3)[axis], about)
    count = int(known.sum())
    agree = count - slips_told(count)
    size = _agreeing(modes[known], off[known], agree)
    scale = float(np.median(size)) / _MEDIAN * np.sqrt(count / (count - 2))
    usual = max(scale, float(np.median(sd[known])))
    used = np.flatnonzero(known)[size <= max(_FAR * usual, float(np.sort(size)[agree - 1]))]
    (motion,) = _fitted(modes[used][None], off[used][None])
    spread = np.linalg.pinv(np.einsum("mai,maj->ij", modes[used], modes[used]), hermitian=True)
    noise = float(np.median(sd[used]))
    return motion, noise * np.sqrt(np.diag(spread)), off - modes @ motion


def _agreeing(modes: Floats, off: Floats, agree: int) -> Floats:
    """How far each marker, (M,) mm, is from the rigid motion that `agree` of them have in common."""
    threes = np.array(list(combinations(range(len(off)), 3)))
    if len(threes) > _THREES:
        threes = threes[:: len(threes) // _THREES]
    size = _sizes(modes, off, _fitted(modes[threes], off[threes]))
    for _ in range(_ROUNDS):
        nearest = np.argsort(size, axis=1)[:, :agree]
        size = _sizes(modes, off, _fitted(modes[nearest], off[nearest]))
    return size[np.argmin((np.sort(size, axis=1)[:, :agree] ** 2).sum(axis=1))]


def _fitted(modes: Floats, off: Floats) -> Floats:
    """The rigid motion (B, 6) that fits each of B sets of m markers, `modes` (B, m, 3, 6) and `off` (B, m, 3)."""
    gram = np.einsum("bmai,bmaj->bij", modes, modes)
    product = np.einsum("bmai,bma->bi", modes, off)
    return np.einsum("bij,bj->bi", np.linalg.pinv(gram, rcond=1e-9, hermitian=True), product)


def _sizes(modes: Floats, off: Floats, motion: Floats) -> Floats:
    """How far M markers are from each of B motions (B, 6): (B, M) mm."""
    return np.asarray(np.linalg.norm(off - np.einsum("mai,bi->bma", modes, motion), axis=2))
