"""What was ruled out in some captures: whether it is gone there, or stays, or neither."""

from functools import cache

import numpy as np

from labrig.arrays import Floats
from labrig.diagnosis._constants import NEGLIGIBLE, P_EFFECT
from labrig.diagnosis._posterior import HOPELESS, Raised, Search, split
from labrig.effects import STAYING, Rows, Space, times_changed

_LEAST = 1e-6
"""Share of a function that is nothing; numerical: columns may be of single precision."""
_ANY = 0.5
"""From how much of its freedom on a space may take another law where it was ruled out: even odds."""


def gone(search: Search) -> dict[str, float]:
    """Of each effect that was ruled out in some captures how probable it is that what it explains is gone there, and
    not something else that stays: a half where these captures could not tell.

    Whenever it was ruled out, or could act again, something else may have changed as well, with the probability that
    anything is there: to measure once more as it was makes that improbable.

    What became less there, and is not gone, tells neither: a frame that is registered again is as good as that
    registration, and a wall may be moved and not taken away. Such are forms in which a part is gone and another stays,
    and those of a space that may have another law there. What would be nothing there anyway tells neither, too.
    """
    design, blocks = search.design, search.design.blocks
    both = {b.owner for b in blocks if b.space.stays}

    staying = {(b.owner, _named(b.space)): i for i, b in enumerate(blocks) if b.space.stays}

    @cache
    def silent(b: int) -> bool:
        """Whether it would be nothing where it was ruled out if it stayed, as what is in another session alone."""
        as_stays = staying.get((blocks[b].owner, _named(blocks[b].space)))
        if as_stays is None:
            return False
        columns, acts = columns_of((as_stays,)), acts_of(blocks[b].owner)
        return float(np.square(columns[acts == 0]).sum()) <= _LEAST * float(np.square(columns).sum())

    def columns_of(some: tuple[int, ...]) -> Floats:
        return np.concatenate([design.W.of(blocks[b].at) for b in some], axis=1).astype(float)

    @cache
    def acts_of(owner: str) -> Floats:
        return np.repeat(_acts(search, owner), design.V.shape[1])

    @cache
    def way_of(owner: str, raised: tuple[int, ...]) -> int:
        """1 where these say that it is gone, 2 that it stays, else 0."""
        heard = tuple(b for b in raised if not silent(b))
        ways = {blocks[b].space.stays for b in heard}
        if len(ways) != 1:
            return 0
        if ways == {False}:
            return 1
        return 2 if _as_elsewhere(columns_of(heard), acts_of(owner)) else 0

    if both:
        _look_at_both(search, both)
    forms = [form for some in search.found.values() for form in some]
    best = max(value for value, _, _ in forms)
    mass = {owner: [0.0, 0.0, 0.0] for owner in both}
    for value, whole, _ in forms:
        if value < best - HOPELESS:
            continue
        for owner in {o for o, _, size in whole if o in both and size not in search.traces}:
            raised = tuple(b for o, b, size in whole if o == owner and size not in search.traces)
            mass[owner][way_of(owner, raised)] += float(np.exp(value - best))
    found = {owner: (own[1] + own[0] / 2) / sum(own) if sum(own) else 0.5 for owner, own in mass.items()}
    rows = design.observations.context.rows
    return {owner: min(g, gone_at_most(rows, owner)) for owner, g in found.items()}


def gone_at_most(rows: Rows, name: str, more: int = 0) -> float:
    """How probable it can be, after `more` changes, that an effect is what went whenever it was ruled out, and came."""
    return float(1 - P_EFFECT ** (times_changed(rows, name) + more))


def acting_share(search: Search) -> dict[str, float]:
    """Of each effect that was ruled out in some captures the share of what was measured in which it could act."""
    seen = search.design.observations
    owners = {b.owner for b in search.design.blocks if b.space.stays}
    share = {owner: float(seen.counts_for @ _acts(search, owner) / seen.counts_for.sum()) for owner in owners}
    return {owner: own for owner, own in share.items() if own > 0}


def _look_at_both(search: Search, both: set[str]) -> None:
    """Look at each form that counts, of these owners, as what is gone and as what stays: a search goes on from the
    likelier one alone.
    """
    blocks = search.design.blocks
    other = {(b.owner, _named(b.space), b.space.stays): i for i, b in enumerate(blocks)}
    forms = [form for some in search.found.values() for form in some]
    for owner in sorted(both):
        own = [form for form in forms if any(o == owner and s not in search.traces for o, _, s in form[1])]
        best = max((value for value, _, _ in own), default=0.0)
        for value, whole, slow in own:
            if value < best + np.log(NEGLIGIBLE):
                continue
            turned: dict[int, int] = {}
            for b in (b for o, b, _ in whole if o == owner):
                space = blocks[b].space
                if (as_well := other.get((owner, _named(space), not space.stays))) is not None:
                    turned[b] = as_well
            if len(turned) == sum(o == owner for o, _, _ in whole):
                as_other: Raised = tuple(sorted((o, turned.get(b, b), size) for o, b, size in whole))
                if (as_other, slow) not in search.seen:
                    background, raised = split(as_other)
                    search.score(background, slow, raised)
    search.settle()


def _named(space: Space) -> str:
    """The name that a space has in common with the same as what stays, or as what is gone."""
    return space.key.replace(STAYING, "")


def _acts(search: Search, owner: str) -> Floats:
    """In which observations (S,) an effect could act: 1, or 0 where it was ruled out."""
    seen = search.design.observations
    names = seen.context.rows.ruled_out
    captures = seen.context.rows.capture[seen.first]
    return np.array([owner not in names[c] for c in captures], dtype=float)[seen.capture]


def _as_elsewhere(columns: Floats, acts: Floats) -> bool:
    """Whether functions, columns (N, q), are bound to be where an effect was ruled out what they are elsewhere.

    Of each of their directions a share lies where it `acts` (N,). Where all shares are as large, none can change
    without the others; where each is all or none, what is there is free. So the variance of the shares, of the most
    that it can be, says how free they are. What is nowhere else is bound.
    """
    Q, s, _ = np.linalg.svd(columns, full_matrices=False)
    Q = Q[:, s > _LEAST * s.max(initial=0.0)]
    share = np.linalg.eigvalsh(Q.T @ (acts[:, None] * Q)).clip(0, 1)
    mean = float(share.mean())
    return mean < _LEAST or bool((share * (1 - share)).mean() > _ANY * mean * (1 - mean))
