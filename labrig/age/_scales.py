"""How large each effect of a model is on one run, as a multiple of what the model has."""

import numpy as np

from labrig.age._known import Beside
from labrig.arrays import Bools, Floats

GAIN = "?gain"
_LOST = "?lost"
_FEWEST = 3
"""Captures from which on each observable's own offset is left out: a marker that slipped is no creep."""
_LEAST_INFORMATION = 16.0
"""An effect whose size this run would say to a quarter of it, at best, or worse, is not asked for."""
_ALIKE = 0.98
"""Correlation from which on an effect is a gain of the whole displacement by another name."""


def scales(beside: Beside) -> dict[str, tuple[float, float]]:
    """The multiple of each effect that fits a run best, and its standard deviation; 1 is the model's own.

    Under `GAIN` how large the whole displacement is, 1 where it is as the base has it: rubber is softer on a warm day,
    and that is no creep. What the sensors saw escape from the chambers is fitted beside them too.

    Weighted least squares of what the model leaves on what its effects do, all together, in units of the noise. The
    standard deviation is that by the noise, which differs from run to run: what the model gets wrong of this programme
    is the same in every run of it. Effects that hardly act on this run are left out, and the gain where an effect is
    nearly the same.
    """
    observations = beside.observations
    seen = observations.seen
    changes = beside.changes | _gain(beside) | _lost(beside)
    names = list(changes)
    columns = [observations.whiten @ (changes[n] / observations.unit) for n in names]
    left = observations.values[:, seen]
    fields = np.array([column[:, seen] for column in columns]).reshape(len(names), *left.shape)
    means = observations.n_captures
    if means >= _FEWEST:
        left = left.copy()
        left[:means] -= left[:means].mean(axis=0)
        fields[:, :means] -= fields[:, :means].mean(axis=1, keepdims=True)
    acting = (fields**2).sum(axis=(1, 2)) >= _LEAST_INFORMATION
    if GAIN in names and acting[names.index(GAIN)]:
        acting[names.index(GAIN)] = _is_apart(fields, acting, names)
    names = [name for name, acts in zip(names, acting, strict=True) if acts]
    if not names:
        return {}
    fields = fields[acting]
    gram, product = np.einsum("aij,bij->ab", fields, fields), np.einsum("aij,ij->a", fields, left)
    inverse = np.linalg.pinv(gram, rcond=1e-9, hermitian=True)  # what nothing speaks of stays at zero
    off, sd = inverse @ product, np.sqrt(np.diag(inverse))
    found = {n: (1.0 + float(o), float(s)) for n, o, s in zip(names, off, sd, strict=True)}
    return {name: each for name, each in found.items() if name != _LOST}


def _gain(beside: Beside) -> dict[str, Floats]:
    """The whole displacement of the base, without that of the effects."""
    moved = beside.context.displacement
    return {GAIN: moved} if np.ptp(moved) > 0 else {}


def _is_apart(fields: Floats, acting: Bools, names: list[str]) -> bool:
    """Whether the gain is told apart from every effect of the model."""
    gain = fields[names.index(GAIN)]
    for name, field, acts in zip(names, fields, acting, strict=True):
        if acts and not name.startswith("?"):
            size = np.sqrt((field**2).sum() * (gain**2).sum())
            if abs(float((field * gain).sum())) > _ALIKE * size:
                return False
    return True


def _lost(beside: Beside) -> dict[str, Floats]:
    """What pressure that the sensors saw escape does, by the base's own slope: it is no effect's doing but a leak's."""
    fall = beside.context.measured_fall
    if fall is None or "leak" in beside.changes:
        return {}
    return {_LOST: np.einsum("fkc,fc->fk", beside.context.jacobian, fall)}
