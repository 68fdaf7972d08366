"""What repeats of a set-point differ by: which captures repeat each other, and which of them say the noise."""

from collections import Counter
from collections.abc import Collection, Iterable, Iterator
from itertools import pairwise

import numpy as np
from numpy.typing import NDArray
from scipy.special import chdtri, fdtri

from labrig.arrays import Floats, Ints
from labrig.effects import Context, is_payload, is_temperature, is_tilt

Pair = tuple[str, int, int]
"""The kind of their history, and two captures by number."""
FEWEST_PAIRS = 3
"""Pairs of repeats from which on they say the noise."""
SAME = 0.02
"""Share of the range by which pressures that are the same may differ, chamber by chamber."""
_STEP = 0.5
"""Share of its range by which what wanders changes from one capture to the next, at most."""
_SLOW = 0.1
"""The same of a temperature that stays as it is from most captures to the next, as it is logged to few digits."""
_ALIKE = "same history"
_MOST_TO_MATCH = 2000
"""Captures up to which repeats without a label are looked for; numerical."""
_EFFICIENCY = 0.37
"""What a square counts for in a median of squares, beside one in their mean; see `limit_of`."""
_BY_CHANCE = 0.001
"""How improbable it must be that repeats tell a session from all others."""


def repeats_of(context: Context, means: Floats, captures: Ints) -> dict[str, list[Floats]]:
    """What repeats of a set-point differ by, each (K,), per kind of history."""
    return differences_of(pairs_of(context, captures), means)


def differences_of(pairs: Iterable[Pair], means: Floats) -> dict[str, list[Floats]]:
    """What the means (n, K) of pairs differ by, each (K,), by the kind of their history."""
    kinds: dict[str, list[Floats]] = {_ALIKE: [], "opposite history": [], "early against late": []}
    for kind, a, b in pairs:
        kinds[kind].append(means[b] - means[a])
    return kinds


def pairs_of(context: Context, captures: Ints, apart: Collection[int] = ()) -> Iterator[Pair]:
    """Which captures repeat each other, by number, and the kind of their history; those of a session that stands
    `apart` repeat each other alone, and so do those in which the same effects were ruled out.
    """
    rows = context.rows
    first = np.searchsorted(rows.capture, captures)
    came_from = context.previous[rows.event[first]]
    tolerance = SAME * np.abs(context.span)
    labels: dict[tuple[str, frozenset[str]], list[int]] = {}
    for i, (label, c) in enumerate(zip(_labels(context, captures), captures.tolist(), strict=True)):
        if label:
            ruled_out = rows.ruled_out[c] if rows.ruled_out else frozenset()
            labels.setdefault((label, ruled_out), []).append(i)
    session = rows.session[first]
    for group in labels.values():
        for own in (None, *apart):
            members = [
                i for i in group if (session[i] == own if own is not None else session[i] not in apart)
            ]
            for a, b in pairwise(members):
                alike = (np.abs(came_from[a] - came_from[b]) <= tolerance).all()
                yield _ALIKE if alike else "opposite history", a, b
            if len(members) > 2:
                yield "early against late", members[0], members[-1]


def _labels(context: Context, captures: Ints) -> list[str]:
    """Which captures repeat each other: as labelled, else those with equal actuation and covariates.

    What is logged and wanders, as the temperature of a room, is no part of a condition: no more than the time is.
    """
    rows = context.rows
    given = [rows.repeat[c] for c in captures]
    if any(given) or len(captures) > _MOST_TO_MATCH:
        return given
    first = np.searchsorted(rows.capture, captures)
    known = [rows.fraction[first]]
    for name, cov in rows.covariates.items():
        set_by_hand = is_payload(name, cov) or is_tilt(name, cov)
        if set_by_hand or not _wanders(cov.values[first], rows.session[first], is_temperature(name, cov)):
            known.append(cov.values[first, None])
    keys = [",".join(f"{v:.4g}" for v in row) for row in np.concatenate(known, axis=1)]
    times = Counter(keys)
    return [key if times[key] > 1 else "" for key in keys] if len(times) > 1 else given


def _wanders(values: Floats, session: Ints, temperature: bool) -> bool:
    """Whether values (n,) of captures in order, within sessions, are mostly others than those before, but near them; of
    a temperature, which few digits may be logged of, whether it goes on in small steps.
    """
    steps = np.abs(np.diff(values))[np.diff(session) == 0]
    often = bool(2 * np.count_nonzero(steps) > len(steps))
    most = _STEP if often else _SLOW
    return bool((often or temperature) and steps.any() and steps.max() <= most * np.ptp(values))


def odd_sessions(context: Context, means: Floats, captures: Ints) -> list[int]:
    """The sessions that differ from all others by more than these do among each other: a specimen that sticks, a day on
    which something stood in the way. What they differ by is no noise.

    Of the means (n, K) of captures, by an F-test on repeats with the same history, one session after the other while
    three others are left.
    """
    rows = context.rows
    session = rows.session[np.searchsorted(rows.capture, captures)]
    odd: list[int] = []
    while len(left := [s for s in np.unique(session).tolist() if s not in odd]) > 3:
        ratios = {s: _unlike(context, means, captures, session, odd, s) for s in left}
        most = max(ratios, key=lambda s: ratios[s])
        if ratios[most] <= 1.0:
            break
        odd.append(most)
    return odd


def _unlike(
    context: Context, means: Floats, captures: Ints, session: Ints, odd: list[int], one: int
) -> float:
    """How much more what repeats in one session differ by from those in others is than chance makes of the others."""
    across = [(a, b) for kind, a, b in pairs_of(context, captures, odd) if kind == _ALIKE]
    touching = [means[b] - means[a] for a, b in across if (session[a] == one) != (session[b] == one)]
    others = differences_of(pairs_of(context, captures, [*odd, one]), means)[_ALIKE]
    far, near = spread_of(touching), spread_of(others)
    if far is None or not near:
        return 0.0
    n, m = (_EFFICIENCY * sum(int(np.isfinite(d).sum()) for d in some) for some in (touching, others))
    limit = fdtri(n, m, 1 - _BY_CHANCE / len(np.unique(session)))
    return float((far / near) ** 2 / limit)


def beside_drift(
    context: Context, means: Floats, captures: Ints, pairs: Iterable[Pair], own: NDArray[np.bool_]
) -> tuple[Floats, int]:
    """What repeats with the same history differ by, (P, k), beside a shift and a gain that go on with the time between
    them, and how many say it: what was measured again at the end differs by all that drifted meanwhile.
    """
    rows = context.rows
    both = np.array([pair for kind, *pair in pairs if kind == _ALIKE], dtype=int).reshape(-1, 2)
    differ = means[both[:, 1]] - means[both[:, 0]]
    if len(both) < FEWEST_PAIRS:  # too few to tell: a note says it where a learner knows better
        return differ, len(both)
    first = np.searchsorted(rows.capture, captures)
    when = (
        rows.time_s[first] if np.isfinite(rows.time_s[first]).all() else np.arange(len(captures), dtype=float)
    )
    gap = when[both[:, 1]] - when[both[:, 0]]
    moved = context.displacement[first][both[:, 0]][:, own]
    free = 2 if len(both) > FEWEST_PAIRS else 1
    out = differ.copy()
    for k in range(differ.shape[1]):
        known = np.isfinite(differ[:, k])
        if (left := int(known.sum()) - free) <= 0:
            continue
        X = np.column_stack([gap, gap * moved[:, k]])[known, :free]
        fit = X @ np.linalg.lstsq(X, differ[known, k], rcond=None)[0]
        out[known, k] = (differ[known, k] - fit) * np.sqrt(known.sum() / left)
    return out, len(both) - free


def spread_of(differences: list[Floats]) -> float | None:
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


def limit_of(differences: list[Floats]) -> float:
    """The largest standard deviation that such differences (K,) leave room for, by the chi-square distribution; of
    their squares the median is worth `_EFFICIENCY` (F. R. Hampel, J. Am. Stat. Assoc. 69 (1974) 383).
    """
    size = spread_of(differences)
    if not size:
        return np.inf
    n = _EFFICIENCY * sum(int(np.isfinite(d).sum()) for d in differences)
    return float(size * np.sqrt(n / chdtri(n, 0.975)))
