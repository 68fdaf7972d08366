"""A family's own weights, fitted: for laws of which no formula is good enough."""

from collections.abc import Iterator

import numpy as np

from labrig.arrays import Floats
from labrig.diagnosis._spectra import factor, prior_of
from labrig.effects import (
    WEIGHTS,
    Context,
    Effect,
    Space,
    Term,
    Variant,
    columns_of_space,
    form_of,
    labels_of,
    weighable,
)

DIRECTIONS = 24
"""Most directions that a family is weighted by: those in which its laws differ most on the run."""


def family_forms(effect: Effect, context: Context) -> Iterator[Variant]:
    """The forms in which an effect's family is weighted."""
    for space in weighable(effect, context):
        basis = _directions(space, context)[:, :DIRECTIONS]
        columns = columns_of_space(space, context) @ basis
        labels = tuple(labels_of(space, context.rows.chambers))
        if basis.shape[1]:
            yield Variant(form_of(space), (Term(WEIGHTS.name, "pressure", columns, labels, basis),))


def _directions(space: Space, context: Context) -> Floats:
    """Principal directions (q, r) of the family's prior as it shows in the observables, most important first."""
    prior = prior_of(space)
    shared = factor(prior.shared[: (a := len(prior.own)), :a])
    each = factor(prior.own)
    C = len(context.rows.chambers)
    blocks = [shared] + ([each] * C if C > 1 else [])
    L = np.zeros((sum(b.shape[0] for b in blocks), sum(b.shape[1] for b in blocks)))
    row = column = 0
    for b in blocks:
        L[row : row + b.shape[0], column : column + b.shape[1]] = b
        row, column = row + b.shape[0], column + b.shape[1]
    size = np.sqrt((context.jacobian**2).mean(axis=(0, 1)))
    seen = columns_of_space(space, context) * size[:, None]
    Z = seen.reshape(-1, seen.shape[2]) @ L
    power, turn = np.linalg.eigh(Z.T @ Z)
    keep = power > 1e-9 * max(power[-1], 1e-300)
    return (L @ turn[:, keep])[:, ::-1]
