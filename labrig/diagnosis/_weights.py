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
    form_of,
    labels_of,
    made_of,
    pressures_of,
    weighable,
)

DIRECTIONS = 64
"""Most directions that a family is weighted by: those in which its laws differ most on the run."""


def family_forms(effect: Effect, context: Context) -> Iterator[Variant]:
    """The forms in which an effect's family is weighted."""
    for space in weighable(effect, context):
        pressures = pressures_of(space, context)
        basis = _directions(space, context, pressures)[:, :DIRECTIONS]
        labels = tuple(labels_of(space, context.rows.chambers))
        if basis.shape[1]:
            term = Term(WEIGHTS.name, "pressure", made_of(pressures, basis), labels, basis)
            yield Variant(form_of(space), (term,))


def _directions(space: Space, context: Context, pressures: Floats) -> Floats:
    """Principal directions (q, r) of the family's prior as it shows in the observables, most important first.

    What a chamber does by itself overlaps with what all do alike, and with no other chamber: so sums are one for each.
    """
    prior = prior_of(space)
    own, C = len(prior.own), pressures.shape[1]
    alike, apart = factor(prior.shared[:own, :own]), factor(prior.own)[:, : None if C > 1 else 0]
    seen = (context.jacobian**2).mean(axis=(0, 1))
    sums = [size * pressures[:, c].T @ pressures[:, c] for c, size in enumerate(seen)]
    beside = np.concatenate([alike.T @ each @ apart for each in sums], axis=1)
    power, turn = np.linalg.eigh(
        np.block(
            [
                [alike.T @ np.sum(sums, axis=0) @ alike, beside],
                [beside.T, block_diag(*(apart.T @ each @ apart for each in sums))],
            ]
        )
    )
    L = block_diag(alike, *[apart] * (C if C > 1 else 0))
    keep = power > 1e-9 * max(power[-1], 1e-300)
    return (L @ turn[:, keep])[:, ::-1]
