"""What was ruled out in some captures: whether it is gone there, or stays, or neither."""

from collections.abc import Collection, Mapping, Sequence
from functools import cache

import numpy as np

from labrig.arrays import Floats
from labrig.diagnosis._constants import NEGLIGIBLE, P_EFFECT
from labrig.diagnosis._explanation import split
from labrig.diagnosis._posterior import HOPELESS, Search
from labrig.effects import STAYING, Rows, Space, times_changed

_LEAST = 1e-6
"""Share of a function that is nothing; numerical: columns may be of single precision."""
_ANY = 0.5
"""From how much of its freedom on a space may take another law where it was ruled out: even odds."""


def gone(search: Search) -> dict[str, float]:
    """How probable it is that what an effect explains is gone where it was ruled out, and not something else that
    stays, by the effects that were ruled out in some captures: a half where these captures could not tell.

    Whenever it was ruled out, or could act again, something else may have changed as well, with the probability that
    anything is there: to measure once more as it was makes that improbable.

    What became less there, and is not gone, tells neither: a frame that is registered again is as good as that
    registration, and a wall may be moved and not taken away. Such are forms in which a part is gone and another stays,
    and those of a space that may have another law there. What would be nothing there anyway tells neither, too.
    """
    blocks, traces = search.design.blocks, search.traces
    ruled_out = {b.owner for b in blocks if b.space.stays}
    if not ruled_out:
        return {}
    _look_at_both(search, ruled_out)
    said_by = cache(_Tells(search, ruled_out).said_by)
    best = search.best().score
    weight: dict[str, dict[str, float]] = {o: {"gone": 0.0, "stays": 0.0, "neither": 0.0} for o in ruled_out}
    for score, raised, _ in search.forms():
        if score < best - HOPELESS:
            continue
        for owner in {o for o, _, size in raised if o in ruled_out and size not in traces}:
            own = tuple(b for o, b, size in raised if o == owner and size not in traces)
            weight[owner][said_by(owner, own)] += float(np.exp(score - best))
    rows = search.design.observations.context.rows
    return {owner: min(_share(each), gone_at_most(rows, owner)) for owner, each in weight.items()}


def _share(weight: Mapping[str, float]) -> float:
    """How probable it is that something is gone, where forms that tell neither count for both; a half without any."""
    total = weight["neither"] + weight["gone"] + weight["stays"]
    return (weight["gone"] + weight["neither"] / 2) / total if total else 0.5


class _Tells:
    """What a form says of an effect that was ruled out: that it is `gone` there, that it `stays`, or `neither`."""

    def __init__(self, search: Search, ruled_out: Collection[str]) -> None:
        self.search, self.blocks = search, search.design.blocks
        self.staying = {(b.owner, _named(b.space)): i for i, b in enumerate(self.blocks) if b.space.stays}
        self.acting = {o: np.repeat(_acts(search, o), search.design.V.shape[1]) for o in ruled_out}
        self._silent: dict[int, bool] = {}

    def said_by(self, owner: str, raised: tuple[int, ...]) -> str:
        """What a form says in which these blocks of an effect are raised."""
        for b in raised:
            if b not in self._silent:
                self._silent[b] = self._is_silent(b)
        heard = [b for b in raised if not self._silent[b]]
        stays = {self.blocks[b].space.stays for b in heard}
        if stays == {False}:
            return "gone"
        bound = stays == {True} and _as_elsewhere(self._columns(heard), self.acting[owner])
        return "stays" if bound else "neither"

    def _is_silent(self, block: int) -> bool:
        """Whether it would be nothing where it was ruled out if it stayed, as what is in another session alone."""
        owner = self.blocks[block].owner
        as_stays = self.staying.get((owner, _named(self.blocks[block].space)))
        if as_stays is None:
            return False
        columns = self._columns([as_stays])
        there = columns[self.acting[owner] == 0]
        return float(np.square(there).sum()) <= _LEAST * float(np.square(columns).sum())

    def _columns(self, blocks: Sequence[int]) -> Floats:
        """The columns (N, q) of some blocks, side by side."""
        W = self.search.design.W
        return np.concatenate([W.of(self.blocks[b].at) for b in blocks], axis=1).astype(float)


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
    numbers = {(b.owner, _named(b.space), b.space.stays): i for i, b in enumerate(blocks)}
    keys = [(b.owner, _named(b.space), not b.space.stays) for b in blocks]
    other = {i: numbers[key] for i, key in enumerate(keys) if key in numbers}
    forms = [*search.forms()]
    for owner in sorted(both):
        own = [f for f in forms if any(o == owner and s not in search.traces for o, _, s in f.raised)]
        best = max((form.score for form in own), default=0.0)
        for form in own:
            if form.score < best + np.log(NEGLIGIBLE):
                continue
            if any(o == owner and b not in other for o, b, _ in form.raised):
                continue
            as_other = tuple(sorted((o, other[b] if o == owner else b, size) for o, b, size in form.raised))
            if (as_other, form.slow) not in search.seen:
                background, raised = split(as_other)
                search.score(background, form.slow, raised)
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
