"""What each part of an explanation is worth: how large it is in the joint fit, and what would be missed without it."""

from collections.abc import Callable
from functools import cache

import numpy as np
from scipy.special import ndtr

from labrig.diagnosis import _constants as k
from labrig.diagnosis._design import DECLARED, SLOW
from labrig.diagnosis._evidence import beside_free, free_fit, free_variances, unexplained
from labrig.diagnosis._posterior import (
    ALWAYS_FLOORS,
    DECLARED_FLOORS,
    REST,
    Explanation,
    Search,
    is_name,
    split,
)

_SMALLEST = 1e-3
"""Floors that nothing is told apart by; numerical."""


def missed(search: Search, e: Explanation, least: float) -> list[tuple[float, dict[str, float]]]:
    """What would be missed without each part of an explanation, all else fitted again, in floors, by owner.

    Parts may stand in for each other. So the one that would be missed least is let go, if by less than `least`, and the
    others are asked again, until each that stays would be missed. Of two effects that would be missed by nearly as
    little either may be the one: then there are two such lists, each with its probability (`MATERIAL_SPREAD`).
    """
    left = _left(search, e)
    whole = frozenset(o for o, _, _ in e.raised)
    total = max(left(frozenset()) - left(whole), 1e-9)

    def lost(stay: frozenset[str]) -> dict[str, float]:
        shares = {o: max(left(stay - {o}) - left(stay), 0.0) / total for o in stay}
        return {o: search.T * float(np.sqrt(min(share, 1.0))) for o, share in shares.items()}

    def let_go(stay: frozenset[str], gone: dict[str, float]) -> dict[str, float]:
        while stay:
            floors = lost(stay)
            last = min(floors, key=lambda o: (floors[o], o))
            if floors[last] >= least:
                return gone | floors
            gone = gone | {last: floors[last]}
            stay = stay - {last}
        return gone

    usual = let_go(whole, {})
    few = sorted((size, o) for o, size in lost(whole).items() if size < least)
    if len(few) < 2 or not all(is_name(o) for _, o in few[:2]):
        return [(1.0, usual)]
    (one, _), (two, second) = few[:2]
    apart = np.log(max(two, _SMALLEST) / max(one, _SMALLEST))
    p = float(ndtr(-apart / (np.sqrt(2) * k.MATERIAL_SPREAD)))
    other = let_go(whole - {second}, {second: two})
    stays = [{o for o, size in each.items() if size >= least} for each in (usual, other)]
    if p < k.NEGLIGIBLE or stays[0] == stays[1]:
        return [(1.0, usual)]
    return [(1 - p, usual), (p, other)]


def _left(search: Search, e: Explanation) -> Callable[[frozenset[str]], float]:
    """What is not explained with only some of the parts of an explanation."""
    design = search.design
    always = [
        (b.at, e.slow if b.owner == SLOW else DECLARED_FLOORS)
        for b in design.blocks
        if b.owner in (SLOW, DECLARED)
    ]
    fixed = {f.owner: ALWAYS_FLOORS.get(f.owner, 0.0) for f in design.free}

    @cache
    def left(keep: frozenset[str]) -> float:
        chosen = [q for q in e.raised if q[0] in keep]
        sd = fixed | {o: s for o, b, s in chosen if b < 0}
        acting = [*always, *[(design.blocks[b].at, s) for _, b, s in chosen if b >= 0]]
        columns = np.concatenate([np.arange(at.start, at.stop) for at, _ in acting])
        sums = search.sums.some(columns)  # all others are asked nothing
        sds = np.concatenate([np.full(at.stop - at.start, s) for at, s in acting])
        return unexplained(beside_free(sums, free_variances(design, sd)), sds)

    return left


def sizes(search: Search, e: Explanation) -> dict[str, tuple[float, float, float]]:
    """How large each part of an explanation is in the joint fit, root mean square in floors, its sd, and how large what
    no curve of the set-points makes of it, by owner.

    Of free patterns the size only; `REST` is what nothing follows, above the noise.
    """
    design = search.design
    background, raised = split(e.raised)
    blocks = [design.blocks[b] for _, b, _ in raised]
    fitted = search.raise_blocks(background, e.slow, raised)
    # in the observables' own floors, whatever shakes
    counts = (design.observations.counts_for[:, None] / design.counts**2).ravel()
    out, curves = {}, design.observations.curves
    for owner in dict.fromkeys(o for o, _, _ in raised):
        own = [(block.at, sd) for (o, _, sd), block in zip(raised, blocks, strict=True) if o == owner]
        at = np.concatenate([np.arange(a.start, a.stop) for a, _ in own])
        prior = np.concatenate([np.full(a.stop - a.start, sd) for a, sd in own])
        share = (prior / fitted.sd[at]) ** 2  # of columns that another part has, too, a share only
        w, cov = share * fitted.mean[at], share[:, None] * fitted.covariance(at) * share
        cov[np.diag_indices_from(cov)] += (1 - share) * prior**2
        columns = np.concatenate([design.W.of(a) for a, _ in own], axis=1).astype(float)
        made = columns @ w
        size = float(np.sqrt(counts @ made**2))
        way = columns.T @ (counts * made) / max(size, 1e-300)
        curved = curves.T @ (made * np.sqrt(counts)).reshape(len(curves), -1)
        beyond = float(np.sqrt(max(size**2 - (curved**2).sum(), 0.0)))
        out[owner] = (size, float(np.sqrt(max(way @ cov @ way, 0.0))), beyond)
    beta = free_fit(search.sums, free_variances(design, search.free_sizes(background)), fitted.mean)
    observations, all_free = design.observations, np.zeros((len(design.observations.values), beta.shape[1]))
    start = 0
    for free in design.free:
        part = free.G @ beta[start : start + free.G.shape[1]]
        start, all_free = start + free.G.shape[1], all_free + part
        if any(owner == free.owner for owner, _, _ in background):
            out[free.owner] = (observations.size_of(part / design.counts @ design.V.T), 0.0, 0.0)
    explained = design.W.made(fitted.mean) + all_free
    left = observations.values - explained @ design.V.T
    out[REST] = (observations.size_of(left, noise=1.0), 0.0, 0.0)
    return out
