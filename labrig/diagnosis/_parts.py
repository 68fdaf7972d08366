"""What each part of an explanation is worth: how large it is in the joint fit, and what would be missed without it."""

import numpy as np

from labrig.diagnosis import _constants as k
from labrig.diagnosis._design import DECLARED, SLOW
from labrig.diagnosis._evidence import beside_free, free_fit, free_variances, unexplained
from labrig.diagnosis._posterior import REST, Explanation, Search, split


def missed(search: Search, e: Explanation, least: float) -> dict[str, float]:
    """What would be missed without each part of an explanation, all else fitted again, in floors, by owner.

    Parts may stand in for each other. So the one that would be missed least is let go, if by less than `least`, and the
    others are asked again, until each that stays would be missed.
    """
    design = search.design
    always = [
        (b.at, e.slow if b.owner == SLOW else k.DECLARED_FLOORS)
        for b in design.blocks
        if b.owner in (SLOW, DECLARED)
    ]
    fixed = {f.owner: (k.DECLARED_FLOORS if f.owner == DECLARED else 0.0) for f in design.free}
    known: dict[frozenset[str], float] = {}

    def left(keep: frozenset[str]) -> float:
        if keep not in known:
            chosen = [q for q in e.raised if q[0] in keep]
            sd = fixed | {o: s for o, b, s in chosen if b < 0}
            beside = beside_free(search.sums, free_variances(design, sd))
            columns = [*always, *[(design.blocks[b].at, s) for _, b, s in chosen if b >= 0]]
            known[keep] = unexplained(beside, [at for at, _ in columns], [s for _, s in columns])
        return known[keep]

    stay = frozenset(o for o, _, _ in e.raised)
    total = max(left(frozenset()) - left(stay), 1e-9)
    out: dict[str, float] = {}
    while stay:
        lost = {o: max(left(stay - {o}) - left(stay), 0.0) / total for o in stay}
        floors = {o: search.T * float(np.sqrt(min(share, 1.0))) for o, share in lost.items()}
        last = min(floors, key=lambda o: (floors[o], o))
        if floors[last] >= least:
            return out | floors
        out[last] = floors[last]
        stay = stay - {last}
    return out


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
