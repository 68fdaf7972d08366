"""The noise floor: what repeats of the same set-point with the same history differ by."""

from dataclasses import dataclass

import numpy as np

from labrig._linalg import rms
from labrig.arrays import Bools, Floats, Ints
from labrig.contents import FloorSource
from labrig.diagnosis._repeats import (
    FEWEST_PAIRS,
    beside_drift,
    differences_of,
    limit_of,
    odd_sessions,
    pairs_of,
    spread_of,
)
from labrig.diagnosis._uneven import groups_of, profile_of_means
from labrig.diagnosis._within import noise_within
from labrig.effects import Context, bulk_noise, capture_means

_REPEATS = "repeats with the same history"
_BULK = "the bulk of the residuals' spectrum"
_NEIGHBOURS = "differences between neighbouring captures"
_INSIDE = "the noise within a capture"
_STEPS = "the steps in which it was recorded"
_ANY_HISTORY = ("same history", "opposite history")
_FEWEST_CAPTURES = 12
"""Captures from which on their spectrum says the noise, and rows without holds are a stream."""
UNREPEATED = "no repeats with the same history: the noise floor is an estimate, repeat some set-points"
"""What is said where nothing else says the noise."""


@dataclass(frozen=True)
class Floor:
    """Noise of each observable, (K,), of two kinds: of a capture's mean, and within its hold.

    `how` says in words where it comes from; `repeats` holds, by unit and in it, what each kind of repeat differs
    by (None where there are none): within a capture, same history, opposite history, early against late.
    """

    mean: Floats
    within: Floats
    how: str
    repeats: dict[str, dict[str, float | None]]
    freedom: Ints
    """How many differences between repeats with the same history it comes from, (K,); 0 where from none."""
    shaken: Floats
    """How all markers shake together from capture to capture, (K, m): the covariance of the means' noise is that of
    `mean` and this times its transpose."""
    upper: Floats
    """What the noise of captures' means is no larger than, (K,): the upper 97.5 % limit by all repeats of a set-point,
    whatever came before them; infinite where there are none."""
    beside: float = 1.0
    """How much of the square of the noise within holds a row has that its capture's mean has not: of n rows the mean
    has an n-th."""

    @property
    def row(self) -> Floats:
        """Noise of one row: all together, (K,)."""
        return np.sqrt(self.mean**2 + self.beside * self.within**2 + self.shakes**2)

    @property
    def shakes(self) -> Floats:
        """How far each observable (K,) is shaken, root mean square."""
        return np.sqrt(np.square(self.shaken).sum(axis=1))

    def told(self, unit: str) -> FloorSource:
        """As a result has it, whose errors are in a unit."""
        return {"how": self.how, "repeats": self.repeats[unit]}


@dataclass(frozen=True)
class _OfMeans:
    """The noise of captures' means of one unit's observables (k,), where it comes from, and what it is at most (k,).

    `freedom`: from how many differences between repeats with the same history it comes; `repeats` is what each kind of
    repeat differs by.
    """

    noise: Floats
    how: str
    freedom: int
    upper: Floats
    repeats: dict[str, float | None]


def noise_floor(
    context: Context, residual: Floats, lost: int = 0, at_full_rate: Floats | None = None
) -> Floor:
    """Estimate the floor from repeats and from the spectrum's bulk, and take the lower.

    A stream, each row of which is a capture, has no repeats that anybody named: of one observable its floor is also
    what neighbours differ by, of a stream that was thinned those of the whole, `at_full_rate` (N, K).

    No lower than what rounding to the recorded steps leaves, a twelfth of their square (B. Widrow, I. Kollar,
    Quantization Noise, Cambridge 2008).

    `residual` (F, K) is what the base leaves (its declared parameters fitted, which took `lost` degrees
    of freedom). Observables of one unit share one floor, but for how uneven it is over them.
    """
    rows, K = context.rows, len(context.rows.unit)
    means, captures = capture_means(residual, rows.capture)
    index = np.searchsorted(captures, rows.capture)
    count = np.bincount(index)
    several = np.flatnonzero(count[index] > 1)
    deviation = (residual - means[index])[several]
    mean, within, upper, freedom = np.zeros(K), np.zeros(K), np.full(K, np.inf), np.zeros(K, dtype=int)
    hows, repeats = [], {}
    for unit in dict.fromkeys(rows.unit):
        own = np.array([each == unit for each in rows.unit])
        groups = groups_of(rows, own)
        within[own] = noise_within(context, deviation[:, own], index[several], several, groups)
        found = _of_means(context, residual, own, within[own], groups, lost, at_full_rate)
        mean[own], upper[own], freedom[own] = found.noise, found.upper, found.freedom
        hows.append(found.how)
        rows_differ = rms(within[own])
        repeats[unit] = {"within a capture": rows_differ if rows_differ > 0 else None, **found.repeats}
    return Floor(
        mean=mean,
        within=within,
        how="; ".join(dict.fromkeys(hows)),
        repeats=repeats,
        freedom=freedom,
        shaken=np.zeros((K, 0)),
        upper=upper,
        beside=float(np.mean(1 - 1 / count[index])),
    )


def _of_means(
    context: Context,
    residual: Floats,
    own: Bools,
    within: Floats,
    groups: list[Ints],
    lost: int,
    at_full_rate: Floats | None,
) -> _OfMeans:
    """The noise of captures' means of the observables that are `own` (K,), of one unit; see `noise_floor`.

    `within` (k,) is their noise within holds; `groups` are those that may have more or less of it together.
    """
    rows = context.rows
    means, captures = capture_means(residual[:, own], rows.capture)
    single = len(captures) == len(rows.capture) >= _FEWEST_CAPTURES
    stream = single and not any(rows.repeat)
    pairs = list(pairs_of(context, captures, odd_sessions(context, means, captures)))
    differences = differences_of(pairs, means)
    alike, freedom = beside_drift(context, means, captures, pairs, own)
    uneven = profile_of_means(means, alike[: 0 if stream else None], within, groups)
    repeated = spread_of(list(alike / uneven))
    bulk = bulk_noise(means / uneven, lost) if len(captures) >= _FEWEST_CAPTURES else float("nan")
    found = {_REPEATS: repeated, _BULK: bulk}
    if single and not np.isfinite(bulk) and (stream or repeated is None):
        found[_NEIGHBOURS] = _neighbours(means if at_full_rate is None else at_full_rate[:, own])
    least = _tiny(residual[:, own])
    usable = {how: v for how, v in found.items() if v is not None and np.isfinite(v) and v > least}
    if len(usable) > 1 and (stream or len(alike) < FEWEST_PAIRS):
        usable.pop(_REPEATS, None)
    if usable:
        how = min(usable, key=lambda name: usable[name])
        size = usable[how]
    else:
        how, size = _INSIDE, rms(within / uneven) or least
    step = float(np.sqrt(np.mean(rows.resolution[own] ** 2) / 12)) if len(rows.resolution) else 0.0
    if step > size:
        how, size = _STEPS, step
    upper = np.full(len(uneven), np.inf)
    if not stream:
        upper = limit_of([d / uneven for kind in _ANY_HISTORY for d in differences[kind]]) * uneven
    return _OfMeans(
        noise=size * uneven,
        how=how if repeated is not None else f"{how} (no same-history repeats)",
        freedom=freedom * int(own.sum()) if how == _REPEATS else 0,
        upper=upper,
        repeats={kind: spread_of(each) for kind, each in differences.items()},
    )


def _tiny(residual: Floats) -> float:
    """A floor where there is no noise at all: a millionth of the residual, so that nothing divides by zero; one where
    nothing was seen.
    """
    if not np.isfinite(residual).any():
        return 1.0
    return float(1e-6 * np.sqrt(np.nanmean(residual**2)) + 1e-12)


def _neighbours(means: Floats) -> float:
    """Noise from second differences of captures in order of time: for continuous records."""
    bends = means[2:] - 2 * means[1:-1] + means[:-2]
    good = np.abs(bends[np.isfinite(bends)])
    return float(1.4826 * np.median(good) / np.sqrt(6.0)) if len(good) else float("nan")
