"""The noise floor: what repeats of the same set-point with the same history differ by."""

from collections.abc import Iterable, Iterator
from dataclasses import dataclass
from itertools import pairwise

import numpy as np
from numpy.typing import NDArray
from scipy.special import chdtri

from labrig.arrays import Floats, Ints
from labrig.diagnosis._uneven import groups_of, profile_of_means
from labrig.diagnosis._within import noise_within
from labrig.effects import Context, bulk_noise

_Pair = tuple[str, int, int]
"""The kind of their history, and two captures by number."""
_MOST_TO_MATCH = 2000
_FEWEST_PAIRS = 3
_REPEATS = "repeats with the same history"
_ANY_HISTORY = ("same history", "opposite history")
_EFFICIENCY = 0.37
_BULK = "the bulk of the residuals' spectrum"
_NEIGHBOURS = "differences between neighbouring captures"


UNREPEATED = "no repeats with the same history: the noise floor is an estimate, repeat some set-points"
"""What is said where nothing else says the noise."""


@dataclass(frozen=True)
class Floor:
    """Noise of each observable, (K,), of two kinds: of a capture's mean, and within its hold.

    `how` says in words where it comes from; `repeats` holds, in units, what each kind of repeat differs
    by (None where there are none): within a capture, same history, opposite history, early against late.
    """

    mean: Floats
    within: Floats
    how: str
    repeats: dict[str, float | None]
    freedom: Ints
    """How many differences between repeats with the same history it comes from, (K,); 0 where from none."""
    shaken: Floats
    """How all markers shake together from capture to capture, (K, m): the covariance of the means' noise is that of
    `mean` and this times its transpose."""
    upper: Floats
    """What the noise of captures' means is no larger than, (K,): the upper 97.5 % limit by all repeats of a set-point,
    whatever came before them; infinite where there are none."""

    @property
    def row(self) -> Floats:
        """Noise of one row: all together, (K,)."""
        return np.sqrt(self.mean**2 + self.within**2 + self.shakes**2)

    @property
    def shakes(self) -> Floats:
        """How far each observable (K,) is shaken, root mean square."""
        return np.sqrt(np.square(self.shaken).sum(axis=1))


def capture_means(values: Floats, capture: Ints) -> tuple[Floats, Ints]:
    """Mean of each capture over its rows, NaN where nothing was seen, and the captures, sorted."""
    captures, index = np.unique(capture, return_inverse=True)
    seen = np.isfinite(values)
    total = np.zeros((len(captures), values.shape[1]))
    count = np.zeros_like(total)
    np.add.at(total, index, np.where(seen, values, 0.0))
    np.add.at(count, index, seen)
    return np.where(count > 0, total / np.maximum(count, 1), np.nan), captures


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
    repeats: dict[str, float | None] = {}
    hows, freedom = [], np.zeros(len(rows.unit), dtype=int)
    upper = np.full(len(rows.unit), np.inf)
    again_at = list(_pairs(context, captures))
    for number, own in enumerate(units.values()):
        groups = groups_of(rows, own)
        each = noise_within(context, deviation[many][:, own], index[many], np.flatnonzero(many), groups)
        again = _differences(again_at, means[:, own])
        alike, told = _beside_drift(context, means[:, own], captures, again_at, own)
        even = profile_of_means(means[:, own], alike[: 0 if stream else None], each, groups)
        inside = float(np.sqrt(np.mean((each / even) ** 2)))
        pairs, same = len(alike), _spread(list(alike / even))
        bulk = bulk_noise(means[:, own] / even, lost) if len(captures) >= 12 else float("nan")
        none = _tiny(residual[:, own])  # repeats that are alike to the last digit
        found = {_REPEATS: same, _BULK: bulk}
        if single and not np.isfinite(bulk) and (stream or same is None):
            found[_NEIGHBOURS] = _neighbours((means if at_full_rate is None else at_full_rate)[:, own])
        usable = {how: v for how, v in found.items() if v is not None and np.isfinite(v) and v > none}
        if len(usable) > 1 and (stream or pairs < _FEWEST_PAIRS):
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
            upper[own] = _limit([d / even for kind in _ANY_HISTORY for d in again[kind]]) * even
        if number == 0:
            rows_differ = float(np.sqrt(np.mean(each**2)))
            repeats = {"within a capture": rows_differ if rows_differ > 0 else None}
            repeats |= {kind: _spread(differences) for kind, differences in again.items()}
    none_shaken = np.zeros((len(mean), 0))
    return Floor(mean, within, "; ".join(dict.fromkeys(hows)), repeats, freedom, none_shaken, upper)


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


def repeats_of(context: Context, means: Floats, captures: Ints) -> dict[str, list[Floats]]:
    """What repeats of a set-point differ by, each (K,), per kind of history."""
    return _differences(_pairs(context, captures), means)


def _differences(pairs: Iterable[_Pair], means: Floats) -> dict[str, list[Floats]]:
    kinds: dict[str, list[Floats]] = {"same history": [], "opposite history": [], "early against late": []}
    for kind, a, b in pairs:
        kinds[kind].append(means[b] - means[a])
    return kinds


def _pairs(context: Context, captures: Ints) -> Iterator[_Pair]:
    """Which captures repeat each other, by number, and the kind of their history."""
    rows = context.rows
    first = np.searchsorted(rows.capture, captures)
    came_from = context.previous[rows.event[first]]
    tolerance = 0.02 * np.abs(context.span)
    labels: dict[str, list[int]] = {}
    for i, label in enumerate(_labels(context, captures)):
        if label:
            labels.setdefault(label, []).append(i)
    for members in labels.values():
        for a, b in pairwise(members):
            alike = (np.abs(came_from[a] - came_from[b]) <= tolerance).all()
            yield "same history" if alike else "opposite history", a, b
        if len(members) > 2:
            yield "early against late", members[0], members[-1]


def _beside_drift(
    context: Context, means: Floats, captures: Ints, pairs: Iterable[_Pair], own: NDArray[np.bool_]
) -> tuple[Floats, int]:
    """What repeats with the same history differ by, (P, k), beside a shift and a gain that go on with the time between
    them, and how many say it: what was measured again at the end differs by all that drifted meanwhile.
    """
    rows = context.rows
    both = np.array([pair for kind, *pair in pairs if kind == "same history"], dtype=int).reshape(-1, 2)
    differ = means[both[:, 1]] - means[both[:, 0]]
    if len(both) < _FEWEST_PAIRS:  # too few to tell: a note says it where a learner knows better
        return differ, len(both)
    first = np.searchsorted(rows.capture, captures)
    when = (
        rows.time_s[first] if np.isfinite(rows.time_s[first]).all() else np.arange(len(captures), dtype=float)
    )
    gap = when[both[:, 1]] - when[both[:, 0]]
    moved = context.displacement[first][both[:, 0]][:, own]
    free = 2 if len(both) > _FEWEST_PAIRS else 1
    out = differ.copy()
    for k in range(differ.shape[1]):
        known = np.isfinite(differ[:, k])
        if (left := int(known.sum()) - free) <= 0:
            continue
        X = np.column_stack([gap, gap * moved[:, k]])[known, :free]
        fit = X @ np.linalg.lstsq(X, differ[known, k], rcond=None)[0]
        out[known, k] = (differ[known, k] - fit) * np.sqrt(known.sum() / left)
    return out, len(both) - free


def _labels(context: Context, captures: Ints) -> list[str]:
    """Which captures repeat each other: as labelled, else those with equal actuation and covariates."""
    rows = context.rows
    given = [rows.repeat[c] for c in captures]
    if any(given) or len(captures) > _MOST_TO_MATCH:
        return given
    first = np.searchsorted(rows.capture, captures)
    known = [rows.fraction[first], *(cov.values[first, None] for cov in rows.covariates.values())]
    keys = [",".join(f"{v:.4g}" for v in row) for row in np.concatenate(known, axis=1)]
    return [key if keys.count(key) > 1 else "" for key in keys] if len(set(keys)) > 1 else given


def _spread(differences: list[Floats]) -> float | None:
    """Standard deviation of one of two captures from their differences, by the median over the pairs.

    The median of a mean of k squares lies below its expectation (Wilson and Hilferty 1931), most for k = 1.
    """
    if not differences:
        return None
    d = np.array(differences)
    d = d[np.isfinite(d).any(axis=1)]
    if not len(d):
        return None
    k = np.isfinite(d).sum(axis=1)
    return float(np.sqrt(np.median(np.nanmean(d**2, axis=1) / (1 - 2 / (9 * k)) ** 3) / 2))


def _limit(differences: list[Floats]) -> float:
    """The largest standard deviation that such differences (K,) leave room for, by the chi-square distribution; of
    their squares the median is worth `_EFFICIENCY` (F. R. Hampel, J. Am. Stat. Assoc. 69 (1974) 383).
    """
    size = _spread(differences)
    if not size:
        return np.inf
    n = _EFFICIENCY * sum(int(np.isfinite(d).sum()) for d in differences)
    return float(size * np.sqrt(n / chdtri(n, 0.975)))
