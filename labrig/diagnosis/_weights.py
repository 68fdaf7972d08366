"""A family's own weights, fitted: for laws of which no formula is good enough."""

from collections.abc import Iterator

import numpy as np
from scipy.linalg import block_diag

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
    own, C = len(prior.own), len(context.rows.chambers)
    apart = [factor(prior.own)] * (C if C > 1 else 0)
    L = np.asarray(block_diag(factor(prior.shared[:own, :own]), *apart), dtype=float)
    size = np.sqrt((context.jacobian**2).mean(axis=(0, 1)))
    seen = columns_of_space(space, context) * size[:, None]
    Z = seen.reshape(-1, seen.shape[2]) @ L
    power, turn = np.linalg.eigh(Z.T @ Z)
    keep = power > 1e-9 * max(power[-1], 1e-300)
    return (L @ turn[:, keep])[:, ::-1]
