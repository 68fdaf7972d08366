"""How large the noise is of what few observables of a unit say: repeats alone say it badly, so all spaces are asked."""

from dataclasses import replace

import numpy as np
from numpy.typing import NDArray

from labrig.arrays import Floats
from labrig.diagnosis import _constants as k
from labrig.diagnosis._design import Design
from labrig.diagnosis._floor import Floor
from labrig.diagnosis._observations import Observations

_FEW = 6
"""Observables of a unit below which the residuals' spectrum says nothing about their noise."""
_SCALES = np.geomspace(0.2, 5.0, 33)
_SIZES = np.geomspace(0.2, 20.0, 14)


def of_few(observations: Observations) -> list[NDArray[np.bool_]]:
    """Which observables (K,) that were seen share a unit with no more than a few others, unit by unit."""
    units = np.array(observations.context.rows.unit)
    each = [(units == unit) & observations.seen for unit in dict.fromkeys(units[observations.seen].tolist())]
    return [own for own in each if own.sum() < _FEW]


def noise_scales(design: Design) -> Floats:
    """By how much the noise of each observable's means is larger than the floor says, (K,): each unit by itself.

    What captures beside each other, or repeats, say of a force may be wrong where it is right of an angle. Where there
    are many of a unit it is one.
    """
    out = np.ones(len(design.observations.unit))
    for own in of_few(design.observations):
        out[own] = noise_scale(design, own)
    return out


def noise_scale(design: Design, own: NDArray[np.bool_]) -> float:
    """By how much the noise of a capture's mean, of the observables that are `own` (K,), is larger than the floor says,
    by the evidence of everything together.

    Every space, named or not, acts at one common size; noise is what none of them can follow. The logarithm of the
    scale has a prior around zero: repeats may differ by what they remember, too, so that the noise may well be smaller
    (`FLOOR_SPREAD`); larger it is only as far as the repeats were few. Of the captures' means only, since noise within
    holds is well known.
    """
    n, r = design.observations.n_captures, int(own.sum())
    columns = _everything(design, n, np.asarray(design.V, dtype=float)[own])
    power, square, rest = _along(columns, design.observations.values[:n, own].reshape(-1))
    freedom = int(design.observations.floor.freedom[own].max())
    few = min(1.0 / np.sqrt(max(freedom, 1)), 2 * k.FLOOR_SPREAD)
    log = np.empty(len(_SCALES))
    for i, scale in enumerate(_SCALES):
        variance = np.square(_SIZES)[:, None] * power + scale**2
        evidence = -0.5 * (np.log(variance) + square / variance).sum(axis=1)
        evidence -= 0.5 * ((n * r - len(power)) * np.log(scale**2) + rest / scale**2)
        log[i] = (
            np.logaddexp.reduce(evidence)
            - 0.5 * (np.log(scale) / (few if scale > 1 else k.FLOOR_SPREAD)) ** 2
        )
    p = np.exp(log - log.max())
    return float(np.exp((p * np.log(_SCALES)).sum() / p.sum()))


def _everything(design: Design, n: int, V: Floats) -> Floats:
    """Columns (n k, q) of unit prior variance for the means of those observables that the directions V (k, r) are of,
    when every owner acts at one floor; what one chamber has alone is in those of all chambers.
    """
    W = design.W.some(np.arange(n))
    blocks = [b for b in design.blocks if b.space.alone <= 1]
    owners = [b.owner for b in blocks]
    columns = []
    for block in blocks:
        along = W.of(block.at).astype(float).reshape(n, V.shape[1], -1) / np.sqrt(owners.count(block.owner))
        columns.append(np.einsum("kr,nrq->nkq", V, along).reshape(n * len(V), -1))
    columns += [np.kron(free.G[:n], V * np.sqrt(design.spread)) for free in design.free]
    return np.concatenate(columns, axis=1) / np.sqrt(len(set(owners)) + len(design.free))


def _along(columns: Floats, values: Floats) -> tuple[Floats, Floats, float]:
    """The variances along the columns' principal axes, the values' squares along them, and the square beside them."""
    if columns.shape[1] < columns.shape[0]:
        power, turn = np.linalg.eigh(columns.T @ columns)
        keep = power > 1e-12 * max(power[-1], 1e-300)
        power, along = power[keep], turn[:, keep].T @ (columns.T @ values) / np.sqrt(power[keep])
    else:
        power, turn = np.linalg.eigh(columns @ columns.T)
        power, along = np.maximum(power, 0.0), turn.T @ values
    return power, along**2, max(float(values @ values - along @ along), 0.0)


def rescaled(floor: Floor, scale: Floats | float) -> Floor:
    """The floor with the noise of captures' means so much larger, (K,)."""
    return replace(floor, mean=floor.mean * scale)
