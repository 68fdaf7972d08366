"""What chambers do together that none does alone, anywhere on the body, as far as the residuals speak for it."""

from collections.abc import Iterator
from itertools import combinations

import numpy as np

from labrig.arrays import Floats
from labrig.effects._context import Context
from labrig.effects._family import Space, acting, motion_scale, pattern

_GROUPS = 3
"""Groups of chambers of which each may move the body in a way of its own: a grid."""
_MOST = 150
"""Most groups that are asked; of more chambers, first those that overlap most. Bounds memory and time."""


def together(context: Context, near: Floats) -> Iterator[Space]:
    """The clearest groups of two or three, each with a pattern of its own; and all pairs, one way of the whole body.

    A group acts by the product of its chambers' deflections. Both are found by regression of the captures' residuals,
    beside what each chamber does alone.
    """
    rows, d = context.rows, context.deflection
    captures, first = np.unique(rows.capture, return_index=True)
    groups = _groups(near)
    if len(captures) < 2 * d.shape[1] + len(near) or not groups:
        return
    left = np.nan_to_num(context.residual) / motion_scale(context)
    sums = np.add.reduceat(left, first, axis=0) / np.diff(np.append(first, len(left)))[:, None]
    alone = np.column_stack([np.ones(len(first)), *(d[first] ** power for power in (1, 2, 3))])
    Q, _ = np.linalg.qr(alone)
    products = np.stack([d[:, group].prod(axis=1) for group in groups], axis=1)
    Z = products[first] - Q @ (Q.T @ products[first])
    R = sums - Q @ (Q.T @ sums)
    chosen = _clearest(Z, R)
    features = [pattern("x".join(map(str, groups[g])), products[:, g]) for g in chosen]
    if features:
        yield Space("some at once", "coupling groups", acting(features), scanned=len(groups) ** len(chosen))
    pairs = [i for i, g in enumerate(groups) if len(g) == 2]
    if 2 < len(pairs) < len(first):
        weights = _one_way(Z[:, pairs], R)
        way = acting([pattern("pairs", products[:, pairs] @ weights)])
        if way:
            yield Space("all pairs, one way", "coupling way", way, scanned=3 ** len(pairs))


def _groups(near: Floats) -> list[tuple[int, ...]]:
    """Pairs and triples of chambers; of many, those that overlap most."""
    groups = [g for size in (2, 3) for g in combinations(range(len(near)), size)]
    if len(groups) <= _MOST:
        return groups
    return sorted(groups, key=lambda g: (len(g), -sum(near[i, j] for i, j in combinations(g, 2))))[:_MOST]


def _clearest(Z: Floats, R: Floats) -> list[int]:
    """The columns of Z (n, G) that take most of R (n, K), one after the other (orthogonal matching pursuit)."""
    Z, R, out = Z.copy(), R.copy(), []
    scale = float((Z**2).sum(axis=0).max(initial=0.0))
    for _ in range(_GROUPS):
        power = (Z**2).sum(axis=0)
        gain = ((Z.T @ R) ** 2).sum(axis=1) / np.maximum(power, 1e-6 * scale + 1e-300)
        best = int(np.argmax(gain))
        if best in out or power[best] <= 1e-6 * scale:
            break
        out.append(best)
        unit = Z[:, best] / np.sqrt(power[best])
        R = R - unit[:, None] * (unit @ R)
        Z = Z - unit[:, None] * (unit @ Z)
    return out


def _one_way(Z: Floats, R: Floats) -> Floats:
    """The weights (P,) of the columns of Z (n, P) whose sum, in one pattern, takes most of R (n, K).

    Reduced-rank regression: A. J. Izenman, J. Multivariate Analysis 5 (1975) 248-264.
    """
    ridge = 1e-2 * float(np.trace(Z.T @ Z)) / Z.shape[1] + 1e-300
    B = np.linalg.solve(Z.T @ Z + ridge * np.eye(Z.shape[1]), Z.T @ R)
    _, V = np.linalg.eigh((fitted := Z @ B).T @ fitted)
    return B @ V[:, -1]
