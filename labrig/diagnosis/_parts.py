"""What each part of an explanation is worth: how large it is in the joint fit, and what would be missed without it."""

from collections.abc import Callable
from functools import cache
from typing import NamedTuple

import numpy as np
from scipy.special import ndtr

from labrig.diagnosis import _constants as k
from labrig.diagnosis._design import DECLARED, SLOW
from labrig.diagnosis._evidence import beside_free, free_fit, free_variances, unexplained
from labrig.diagnosis._explanation import REST, Explanation, is_name, split
from labrig.diagnosis._posterior import ALWAYS_FLOORS, DECLARED_FLOORS, Search

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
        """What would be missed without each of the parts that stay, floors."""
        shares = {o: max(left(stay - {o}) - left(stay), 0.0) / total for o in stay}
        return {o: search.to_explain * float(np.sqrt(min(share, 1.0))) for o, share in shares.items()}

    def let_go(stay: frozenset[str], gone: dict[str, float]) -> dict[str, float]:
        """What would be missed without each part, when those that would hardly be are let go one after the other."""
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


class PartSize(NamedTuple):
    """How large a part of an explanation is in the joint fit, root mean square in floors, the sd of that, and the size
    of what no curve of the set-points makes of it; of what has no columns the size alone.
    """

    floors: float
    sd: float = 0.0
    beyond_curves: float = 0.0


def sizes(search: Search, e: Explanation) -> dict[str, PartSize]:
    """How large each part of an explanation is, by owner; `REST` is what nothing follows, above the noise."""
    design = search.design
    background, raised = split(e.raised)
    blocks = [design.blocks[b] for _, b, _ in raised]
    fitted = search.raise_blocks(background, e.slow, raised)
    # the weights of squares along the design's directions: in the observables' own floors, whatever shakes
    counts = (design.observations.counts_for[:, None] / design.counts**2).ravel()
    observations, curves, found = design.observations, design.observations.curves, {}
    for owner in dict.fromkeys(o for o, _, _ in raised):
        own = [(block.at, sd) for (o, _, sd), block in zip(raised, blocks, strict=True) if o == owner]
        index = np.concatenate([np.arange(at.start, at.stop) for at, _ in own])
        prior = np.concatenate([np.full(at.stop - at.start, sd) for at, sd in own])
        share = (prior / fitted.sd[index]) ** 2  # of columns that another part has, too, a share only
        mean, covariance = share * fitted.mean[index], share[:, None] * fitted.covariance(index) * share
        covariance[np.diag_indices_from(covariance)] += (1 - share) * prior**2
        columns = np.concatenate([design.W.of(at) for at, _ in own], axis=1).astype(float)
        made = columns @ mean
        size = float(np.sqrt(counts @ made**2))
        gradient = columns.T @ (counts * made) / max(size, 1e-300)  # of the size by the coefficients
        sd = float(np.sqrt(max(gradient @ covariance @ gradient, 0.0)))
        curved = curves.T @ (made * np.sqrt(counts)).reshape(len(curves), -1)
        found[owner] = PartSize(size, sd, float(np.sqrt(max(size**2 - (curved**2).sum(), 0.0))))
    beta = free_fit(search.sums, free_variances(design, search.free_sizes(background)), fitted.mean)
    all_free, start = np.zeros((len(observations.values), beta.shape[1])), 0
    for free in design.free:
        made = free.G @ beta[start : start + free.G.shape[1]]
        start, all_free = start + free.G.shape[1], all_free + made
        if any(owner == free.owner for owner, _, _ in background):
            found[free.owner] = PartSize(observations.size_of(made / design.counts @ design.V.T))
    left = observations.values - (design.W.made(fitted.mean) + all_free) @ design.V.T
    found[REST] = PartSize(observations.size_of(left, noise=1.0))
    return found
