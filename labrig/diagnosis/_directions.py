"""The directions, over all observables, in which everything that has a name lies."""

from collections.abc import Sequence
from typing import cast

import numpy as np
from numpy.typing import NDArray
from scipy.linalg import qr

from labrig._linalg import svd
from labrig.arrays import Floats, Ints
from labrig.diagnosis._constants import EVEN
from labrig.diagnosis._observations import Observations
from labrig.effects import FEW_OBSERVABLES, Space, bulk_edge, frame_modes

_MOST_DIRECTIONS = 24
"""Most that are taken from what the families hold, and most from what was measured: it bounds the columns."""
_NEW = 0.1
"""Share of its length by which a direction must stand off those before it."""
_LEFT, _CLEAR = 0.005, 1e-4
"""Share of how everything moves that may be left out, and the least share of a direction that is kept; numerical."""
_ROWS = 60
"""About how many captures of a field are looked at; numerical."""
_SINGLE = 30_000
"""Numbers from which on columns are kept in single precision: half the time, and errors that are one in a million."""


def directions(observations: Observations, spaces: Sequence[Space]) -> tuple[Floats, Floats]:
    """Orthonormal directions (K, r) in which everything named lies, and the spread along each (r,).

    What is unnamed spreads over them as what is named does: along how the base moves, above all; a share
    (`EVEN`) of it evenly.
    """
    exact, clouds = _known(observations, spaces)
    K = len(observations.unit)
    power = np.zeros((K, K))
    for cloud in (c * observations.seen for c in clouds):
        norm = (cloud**2).sum()
        if norm > 0:
            power += cloud.T @ cloud / norm / len(clouds)
    Q = _independent((np.array(exact) * observations.seen).T)
    if _MOST_DIRECTIONS + Q.shape[1] >= K:
        V = np.eye(K)[:, observations.seen]
    else:
        V, _ = np.linalg.qr(np.concatenate([Q, _main(power, Q)], axis=1))
        V, _ = np.linalg.qr(np.concatenate([V, _clear(observations, V)], axis=1))
    along, turn = np.linalg.eigh(V.T @ power @ V)
    along = (1 - EVEN) * np.maximum(along, 0) / max(along.sum(), 1e-300) + EVEN / len(along)
    many = len(observations.values) * V.shape[1] > _SINGLE
    return (V @ turn).astype(np.float32 if many else np.float64), along * K  # type: ignore[return-value]


def _known(observations: Observations, spaces: Sequence[Space]) -> tuple[list[Floats], list[Floats]]:
    """Directions (K,) that are kept as they are: each axis, rigid motions, single sensors, single markers; and clouds
    (n, K) of which the main directions are: how the base and the families' fields move all observables.
    """
    context, unit, first = observations.context, observations.unit, observations.first
    rows, K = context.rows, len(unit)
    exact = [(rows.axis == a).astype(float) for a in range(3) if (rows.axis == a).any()] or [np.ones(K)]
    if (rows.axis >= 0).sum() >= 3:
        exact += list((frame_modes(context)[first] / unit[None, :, None]).mean(axis=0).T)
    lone = np.flatnonzero((rows.axis < 0) & observations.seen)
    exact += list(np.eye(K)[lone]) if len(lone) <= FEW_OBSERVABLES else []  # a sensor is no part of a body
    clouds = [np.moveaxis(observations.slopes, 2, 1).reshape(-1, K), context.displacement[first] / unit]
    fields = [(space, f) for space in spaces for f in space.features if f.kind == "field"]
    for space, field in fields:
        values = field.values[first] / unit
        used = np.abs(values).max(axis=0) > 0
        if used.sum() <= 3:  # one marker: of a scan all its ways, else the one that it moves above all
            exact += _ways(values[:, used], used, None if space.scanned else 1)
        else:
            clouds.append(values[:: max(1, len(values) // _ROWS)])
    return exact, clouds


def _main(power: Floats, Q: Floats) -> Floats:
    """The main directions (K, q) of a Gram matrix (K, K) beside those of Q (K, p): as many as leave `_LEFT` of it."""
    left = power - Q @ (Q.T @ power)
    w, U = np.linalg.eigh(left - (left @ Q) @ Q.T)
    enough = int((np.cumsum(w[::-1]) < w.sum() - _LEFT).sum()) + 1
    clear = int((w > _CLEAR).sum())
    return U[:, -int(np.clip(min(enough, clear), 2, _MOST_DIRECTIONS)) :]


def _independent(ways: Floats) -> Floats:
    """Orthonormal directions (K, q) of those given (K, n) that stand off the others."""
    size = np.linalg.norm(ways, axis=0)
    if not size.any():
        return ways[:, :0]
    # pivots: there may be more of them than observables, and all but the first few the same
    pivoted = qr(ways[:, size > 0] / size[size > 0], mode="economic", pivoting=True)
    Q, R, _ = cast("tuple[Floats, Floats, Ints]", pivoted)  # what it returns goes by its arguments
    return Q[:, np.abs(np.diag(R)) > _NEW]


def _clear(observations: Observations, V: Floats) -> Floats:
    """The directions (K, q) beside those of V in which there is clearly more than noise: a rest shape is any, and
    nothing that is known beforehand tells which.
    """
    values = observations.values * observations.seen
    left = values - values @ V @ V.T
    power, U = np.linalg.eigh(left.T @ left)
    clear = np.sqrt(np.maximum(power, 0.0)) > bulk_edge(*values.shape)
    return U[:, clear][:, -_MOST_DIRECTIONS:]


def _ways(values: Floats, used: NDArray[np.bool_], most: int | None) -> list[Floats]:
    """The directions (K,) that values (n, k) of some observables go in, those that they go in most first."""
    _, size, Vt = svd(values)
    out = np.zeros((int((size > _NEW * size[:1]).sum()), len(used)))
    out[:, used] = Vt[: len(out)]
    return list(out[:most])
