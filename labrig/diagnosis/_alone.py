"""One chamber alone: what leaks, sticks or is worn is often a single one, and then says nothing of the others.

A space in which each chamber has a measure of its own makes such a fault improbable, the more so the wider it is and
the more chambers there are; a narrower space of another effect then takes its place.
"""

from collections.abc import Iterator
from dataclasses import replace

import numpy as np

from labrig.arrays import Floats
from labrig.diagnosis._observations import Observations
from labrig.effects import Context, Feature, Space, acting

FEWEST = 3
"""Chambers from which on there are spaces of one alone: of two, two measures are hardly wider than one."""
MOST = 0.5
"""Share of what all chambers explain that one has to, else it is not one alone: it saves time where it is not."""


def single(spaces: list[tuple[str, Space]], observations: Observations) -> list[tuple[str, Space]]:
    """These spaces by owner, each followed by itself in that chamber alone that most speaks for."""
    c = _likeliest(observations)
    if c is None:
        return spaces
    name, of = observations.context.rows.chambers[c], len(observations.context.rows.chambers)
    return [(owner, one) for owner, space in spaces for one in _with_single(space, c, name, of)]


def _with_single(space: Space, c: int, name: str, of: int) -> Iterator[Space]:
    """A space, and the same in one chamber, where it is one of changes of the pressures that no scan found."""
    by_pressure = all(f.kind == "pressure" for f in space.features) and space.apart is None
    features = acting([_within(f, c) for f in space.features]) if by_pressure and not space.scanned else ()
    if features:
        along = None if space.along is None else _within(space.along, c)
        yield replace(space, alone=1)
        yield replace(space, key=f"{space.key}, {name} alone", features=features, along=along, alone=of)
    else:
        yield space


def _within(feature: Feature, c: int) -> Feature:
    """A change of the pressures in one chamber alone."""
    values = np.zeros_like(feature.values)
    values[:, c] = feature.values[:, c]
    return replace(feature, values=values)


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
