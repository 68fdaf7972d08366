"""One chamber, or one session, alone: what leaks, sticks or is worn is often a single one, and says nothing of others.

A space in which each chamber has a measure of its own makes such a fault improbable, the more so the wider it is and
the more chambers there are; a narrower space of another effect then takes its place. A specimen that sticks among five
that do not is a fifth of what it would be, and little more than noise.
"""

from collections.abc import Callable, Iterator
from dataclasses import dataclass, replace
from functools import cache
from typing import Literal

import numpy as np
from numpy.typing import NDArray

from labrig.arrays import Floats
from labrig.diagnosis._observations import Observations
from labrig.effects import MOST_SESSIONS, Context, Feature, Space, acting, may_act

FEWEST = 3
"""Chambers, or sessions, from which on there are spaces of one alone: of two, two measures are hardly wider than
one."""
MOST = 0.5
"""Share of what all chambers explain, or of what is missing in all sessions, that one has to, else it is not one alone:
it saves time where it is not."""


@dataclass(frozen=True)
class _One:
    """One of several chambers, or sessions: its name, which rows or chambers it is (True), and of how many."""

    kind: Literal["chamber", "session"]
    name: str
    own: NDArray[np.bool_]
    of: int

    def within(self, feature: Feature) -> Feature:
        """A feature there alone."""
        own = self.own if self.kind == "chamber" else self.own.reshape(-1, *[1] * (feature.values.ndim - 1))
        return replace(feature, values=np.where(own, feature.values, 0.0))

    def has(self, space: Space) -> bool:
        """Whether it may have such a space for itself: one that no scan found, in all observables as one; a chamber
        one of changes of the pressures, a session none with a free shape.
        """
        kinds = {f.kind for f in space.features}
        may = kinds <= {"pressure"} if self.kind == "chamber" else "pattern" not in kinds
        return may and space.apart is None and not space.scanned


def with_single(observations: Observations) -> Callable[[str, Space], Iterator[Space]]:
    """What gives an owner's space, and then itself in the likeliest chamber alone, and in the likeliest session.

    Not in the only session in which an effect could act: what is there alone is gone where it was ruled out. They come
    one by one, as of many captures there would not be room for all of them.
    """
    ones = [one for one in (_chamber(observations), _session(observations)) if one is not None]
    rows = observations.context.rows

    @cache
    def may_have(owner: str) -> list[_One]:
        """The chamber and the session that an owner's spaces may be in alone."""
        acts = may_act(rows, owner)
        return [
            one for one in ones if one.kind == "chamber" or acts.all() or not np.array_equal(one.own, acts)
        ]

    return lambda owner, space: _with_single(space, may_have(owner))


def _with_single(space: Space, ones: list[_One]) -> Iterator[Space]:
    """A space, and the same in one chamber or session each, where these may have it for themselves."""
    having = [one for one in ones if one.has(space) and any(acting([one.within(f)]) for f in space.features)]
    whole = 1.0 + len(having)  # all have it, one chamber, or one session: each as likely
    yield replace(space, rarer=whole)
    for one in having:
        features = acting([one.within(f) for f in space.features])
        along = None if space.along is None else one.within(space.along)
        name = one.name if one.kind == "chamber" else f"session {one.name}"
        key = f"{space.key}, {name} alone"
        yield replace(space, key=key, features=features, along=along, alone_in=name, rarer=whole * one.of)


def _chamber(observations: Observations) -> _One | None:
    """The likeliest single chamber; None where there are few, or none explains most of it."""
    c = _likeliest(observations)
    names = observations.context.rows.chambers
    return None if c is None else _One("chamber", names[c], np.arange(len(names)) == c, len(names))


def _session(observations: Observations) -> _One | None:
    """The session in which half of what is missing is, or more; None where there are few, or too many."""
    rows = observations.context.rows
    count = len(rows.sessions)
    if not FEWEST <= count <= MOST_SESSIONS:
        return None
    beyond = (observations.values[:, observations.seen] ** 2).mean(axis=1) - observations.left
    of_capture = rows.session[observations.first][observations.capture]
    each = np.bincount(of_capture, weights=observations.counts_for * beyond, minlength=count)
    each = np.maximum(each, 0.0)
    s = int(np.argmax(each))
    if not each.any() or each[s] < MOST * each.sum():
        return None
    return _One("session", rows.sessions[s], rows.session == s, count)


def _likeliest(observations: Observations) -> int | None:
    """The chamber whose own pressure, history and time explain most, by least squares; None where there are few, or
    where it explains less than half of what all of them together do.

    What is planned and was not measured, which is zero, says nothing.
    """
    context, values = observations.context, observations.values
    C = len(context.rows.chambers)
    measured = values.any(axis=1)
    if C < FEWEST or not measured.any():
        return None
    Q, R = np.linalg.qr(observations.slopes)
    capture, values, own = observations.capture[measured], values[measured], _own(context)
    Z = (observations.whiten @ own.reshape(len(own), -1))[measured].reshape(len(values), C, -1)
    columns = (R[capture][..., None] * Z[:, None]).reshape(-1, C * Z.shape[2])
    said = np.einsum("skr,sk->sr", Q[capture], values).reshape(-1)
    gram, product = columns.T @ columns, (columns.T @ said).reshape(C, -1)
    apart = gram.reshape(C, len(gram) // C, C, -1)
    gains = [_explained(apart[c, :, c], product[c]) for c in range(C)]
    most = max(gains)
    return int(np.argmax(gains)) if most > 0 and most >= MOST * _explained(gram, product.ravel()) else None


def _explained(gram: Floats, product: Floats) -> float:
    """The square that columns take off, by least squares, of their Gram matrix and products."""
    return float(product @ np.linalg.pinv(gram, rcond=1e-9, hermitian=True) @ product)


def _own(context: Context) -> Floats:
    """What an effect in each chamber alone may go by, (F, C, 7)."""
    rows = context.rows
    x = rows.fraction
    before = rows.share(context.previous)[rows.event]
    held = np.log1p(context.elapsed_s)[:, None]
    late = context.session_time_s / max(float(context.session_time_s.max(initial=0.0)), 1e-300)
    way = context.direction[rows.event]
    return np.stack([x, x**2, x**3, before, way, x * held, x * late[:, None]], axis=2)
