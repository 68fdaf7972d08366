"""The effect library as plain regression columns, for the baselines: no streams, no guards, no folds."""

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from labrig.arrays import Floats
from labrig.effects import Context, Variant, contribution

PATTERNS = 3  # free shapes over the observables are looked for among this many directions of the residuals


@dataclass(frozen=True)
class Residuals:
    """What the base leaves, (N,), over the entries of (F, K) that were seen in the rows that are used."""

    context: Context
    seen: NDArray[np.bool_]
    value: Floats
    modes: Floats


def residuals(context: Context, random: np.random.Generator, most_rows: int) -> Residuals:
    """Residuals of a base over at most `most_rows` rows, clipped at six robust deviations against outliers."""
    left = context.rows.values - context.base
    seen = np.isfinite(left)
    spread = 1.4826 * np.median(np.abs(left[seen] - np.median(left[seen])))
    left = np.clip(left, -6.0 * spread, 6.0 * spread)
    filled = np.where(seen, left, 0.0)
    modes = np.linalg.svd(filled, full_matrices=False)[2][:PATTERNS]
    seen[np.sort(random.permutation(len(seen))[most_rows:])] = False
    return Residuals(context, seen, left[seen], modes)


def columns(data: Residuals, variant: Variant) -> Floats:
    """One column (N,) for each unknown coefficient of a variant, (N, Q), each of unit length."""
    context = data.context
    zeros = [_zeros(term, context.base.shape[1]) for term in variant.terms]
    out = []
    for index, term in enumerate(variant.terms):
        units = _units(zeros[index], data.modes) if term.kind == "pattern" else _units(zeros[index], None)
        for unit in units:
            coefficients = [unit if k == index else zero for k, zero in enumerate(zeros)]
            out.append(contribution(context, variant, coefficients)[data.seen])
    X = np.stack(out, axis=1) if out else np.zeros((data.value.size, 0))
    length = np.linalg.norm(X, axis=0)
    return X[:, length > 1e-9] / length[length > 1e-9]


def _zeros(term, observables: int) -> Floats:
    if term.kind == "frame":
        return np.zeros(6)
    width = term.feature.shape[-1]
    return np.zeros((width, observables)) if term.kind == "pattern" else np.zeros(width)


def _units(zero: Floats, modes: Floats | None) -> list[Floats]:
    units = []
    if modes is None:
        for k in range(zero.size):
            unit = zero.copy()
            unit[k] = 1.0
            units.append(unit)
        return units
    for k in range(len(zero)):
        for mode in modes:
            unit = zero.copy()
            unit[k] = mode
            units.append(unit)
    return units
