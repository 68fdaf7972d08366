"""How large the noise is of what few observables of a unit say: repeats alone say it badly, so all spaces are asked."""

from collections.abc import Collection, Mapping
from dataclasses import replace

import numpy as np
from numpy.typing import NDArray

from labrig.arrays import Floats, Ints
from labrig.diagnosis import _constants as k
from labrig.diagnosis._design import Design, design_of
from labrig.diagnosis._floor import Floor
from labrig.diagnosis._observations import Observations, observe
from labrig.diagnosis._problem import Prepared
from labrig.effects import Effect, without_failing

_FEW = 6
"""Observables of a unit below which the residuals' spectrum says nothing about their noise."""
_SCALES = np.geomspace(0.2, 5.0, 33)
"""Scales of the noise that are tried, as parts of what the floor says: a grid."""
_SIZES = np.geomspace(0.2, 200.0, 21)
"""Common sizes of everything else that are tried, floors: a grid."""


def of_few(observations: Observations) -> list[NDArray[np.bool_]]:
    """Which observables (K,) that were seen share a unit with no more than a few others, unit by unit."""
    units = np.array(observations.context.rows.unit)
    each = [(units == unit) & observations.seen for unit in dict.fromkeys(units[observations.seen].tolist())]
    return [own for own in each if own.sum() < _FEW]


def noise_of_few(design: Design) -> Floor:
    """The floor with the noise of captures' means put right where few observables say it, each unit by itself.

    What captures beside each other, or repeats, say of a force may be wrong where it is right of an angle.
    """
    observations = design.observations
    floor, unit = observations.floor, observations.unit
    mean = floor.mean.copy()
    for own in of_few(observations):
        mean[own] = unit[own] * noise_scale(design, own)
    return replace(floor, mean=mean)


def with_noise_of_few(ready: Prepared, effects: Mapping[str, Effect]) -> Prepared:
    """Measurements that are prepared, with the noise that a diagnosis takes where few observables leave it open.

    Own effects that fail say nothing of it.
    """
    observations = observe(ready.context, ready.residual, ready.floor, ready.declared)
    if observations.n_captures < k.FEWEST_OBSERVATIONS or not of_few(observations):
        return ready

    def attempt(failing: Collection[str]) -> Design:
        able = {name: effect for name, effect in effects.items() if name not in failing}
        return design_of(observations, able, ready.nuisance, ready.calibrated)

    return replace(ready, floor=noise_of_few(without_failing(attempt, ())[0]))


def noise_scale(design: Design, own: NDArray[np.bool_]) -> float:
    """How large the noise of a capture's mean is in the observables that are `own` (K,), in their unit, by the evidence
    of everything together.

    Every space, named or not, acts at one common size; noise is what none of them can follow. The logarithm of the
    scale has a prior around what the floor says: repeats may differ by what they remember, too, so that the noise may
    well be smaller (`FLOOR_SPREAD`); larger it is only as far as the repeats were few, and no larger than what repeats
    of a set-point differ by, whatever came before them: what is the same at a set-point each time is an error of the
    model. Of the captures' means only, since noise within holds is well known.
    """
    observations = design.observations
    n, floor = observations.n_captures, observations.floor
    values = observations.values[:n, own]
    power, square, rest = along(
        everything(design, np.arange(n), np.asarray(design.V, dtype=float)[own]), values.reshape(-1)
    )
    few = min(1.0 / np.sqrt(max(int(floor.freedom[own].max()), 1)), 2 * k.FLOOR_SPREAD)
    off = np.log(_SCALES * float((observations.unit[own] / floor.mean[own]).mean()))
    log = -0.5 * (off / np.where(off > 0, few, k.FLOOR_SPREAD)) ** 2
    larger = _SCALES * float((observations.unit[own] / floor.upper[own]).mean()) > 1
    larger[0] = False
    log[larger] = -np.inf
    log += log_evidence(_SCALES, power, square, rest, values.size)
    p = np.exp(log - log.max())
    return float(np.exp((p * np.log(_SCALES)).sum() / p.sum()))


def log_evidence(scales: Floats, power: Floats, square: Floats, rest: float, numbers: int) -> Floats:
    """The log evidence of each scale of the noise, whatever the common size of everything else: of so many `numbers`,
    their squares along the columns' principal axes, and the square beside them.
    """
    out = np.zeros(len(scales))
    for i, scale in enumerate(scales):
        variance = np.square(_SIZES)[:, None] * power + scale**2
        evidence = -0.5 * (np.log(variance) + square / variance).sum(axis=1)
        evidence -= 0.5 * ((numbers - len(power)) * np.log(scale**2) + rest / scale**2)
        out[i] = np.logaddexp.reduce(evidence)
    return out


def everything(design: Design, captures: Ints, V: Floats) -> Floats:
    """Columns (n k, q) of unit prior variance for the means of n captures, in those observables, or combinations of
    them, that the directions V (k, r) are of, when every owner acts at one floor; what one chamber has alone is in
    those of all chambers.
    """
    W = design.W
    made = W.some(captures).turned(V.T.astype(W.dtype)).whole.astype(float)
    blocks = [b for b in design.blocks if not b.space.alone_in]
    owners = [b.owner for b in blocks]
    columns = [made[:, block.at] / np.sqrt(owners.count(block.owner)) for block in blocks]
    columns += [np.kron(free.G[captures], V * np.sqrt(design.spread)) for free in design.free]
    return np.concatenate(columns, axis=1) / np.sqrt(len(set(owners)) + len(design.free))


def along(columns: Floats, values: Floats) -> tuple[Floats, Floats, float]:
    """The variances along the columns' principal axes, the values' squares along them, and the square beside them."""
    if columns.shape[1] < columns.shape[0]:
        power, turn = np.linalg.eigh(columns.T @ columns)
        keep = power > 1e-12 * max(power[-1], 1e-300)
        power, along = power[keep], turn[:, keep].T @ (columns.T @ values) / np.sqrt(power[keep])
    else:
        power, turn = np.linalg.eigh(columns @ columns.T)
        power, along = np.maximum(power, 0.0), turn.T @ values
    return power, along**2, max(float(values @ values - along @ along), 0.0)
