"""The noise floor: what repeats of the same set-point with the same history differ by."""

from dataclasses import dataclass

import numpy as np

from labrig.arrays import Floats, Ints
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
_ANY_HISTORY = ("same history", "opposite history")
_BULK = "the bulk of the residuals' spectrum"
_NEIGHBOURS = "differences between neighbouring captures"


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
    rows = context.rows
    means, captures = capture_means(residual, rows.capture)
    index = np.searchsorted(captures, rows.capture)
    deviation = residual - means[index]
    many = np.bincount(index)[index] > 1
    units = {u: np.array([unit == u for unit in rows.unit]) for u in dict.fromkeys(rows.unit)}
    mean, within = np.zeros(len(rows.unit)), np.zeros(len(rows.unit))
    single = len(captures) == len(rows.capture) >= 12
    stream = single and not any(rows.repeat)
    repeats: dict[str, dict[str, float | None]] = {}
    hows, freedom = [], np.zeros(len(rows.unit), dtype=int)
    upper = np.full(len(rows.unit), np.inf)
    for unit, own in units.items():
        groups = groups_of(rows, own)
        each = noise_within(context, deviation[many][:, own], index[many], np.flatnonzero(many), groups)
        again_at = list(pairs_of(context, captures, odd_sessions(context, means[:, own], captures)))
        again = differences_of(again_at, means[:, own])
        alike, told = beside_drift(context, means[:, own], captures, again_at, own)
        even = profile_of_means(means[:, own], alike[: 0 if stream else None], each, groups)
        inside = float(np.sqrt(np.mean((each / even) ** 2)))
        pairs, same = len(alike), spread_of(list(alike / even))
        bulk = bulk_noise(means[:, own] / even, lost) if len(captures) >= 12 else float("nan")
        none = _tiny(residual[:, own])  # repeats that are alike to the last digit
        found = {_REPEATS: same, _BULK: bulk}
        if single and not np.isfinite(bulk) and (stream or same is None):
            found[_NEIGHBOURS] = _neighbours((means if at_full_rate is None else at_full_rate)[:, own])
        usable = {how: v for how, v in found.items() if v is not None and np.isfinite(v) and v > none}
        if len(usable) > 1 and (stream or pairs < FEWEST_PAIRS):
            usable.pop(_REPEATS, None)
        if not usable:
            usable = {"the noise within a capture": inside}
        how = min(usable, key=lambda name: usable[name])
        size = usable[how]
        if not np.isfinite(size) or size <= 0:
            size, how = max(inside, none), "the noise within a capture"
        step = float(np.sqrt(np.mean(rows.resolution[own] ** 2) / 12)) if len(rows.resolution) else 0.0
        if step > size:
            size, how = step, "the steps in which it was recorded"
        mean[own] = size * even
        within[own] = each
        hows.append(how if same is not None else f"{how} (no same-history repeats)")
        freedom[own] = told * int(own.sum()) if how == _REPEATS else 0
        if not stream:
            upper[own] = limit_of([d / even for kind in _ANY_HISTORY for d in again[kind]]) * even
        rows_differ = float(np.sqrt(np.mean(each**2)))
        repeats[unit] = {"within a capture": rows_differ if rows_differ > 0 else None}
        repeats[unit] |= {kind: spread_of(differences) for kind, differences in again.items()}
    none_shaken = np.zeros((len(mean), 0))
    beside = float(np.mean(1 - 1 / np.bincount(index)[index]))
    how = "; ".join(dict.fromkeys(hows))
    return Floor(mean, within, how, repeats, freedom, none_shaken, upper, beside)


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
