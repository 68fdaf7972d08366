"""A family's own weights, fitted: for laws of which no formula is good enough."""

from collections.abc import Iterator
from dataclasses import replace

import numpy as np
from scipy.linalg import block_diag

from labrig.arrays import Floats
from labrig.diagnosis._spectra import factor, prior_of
from labrig.effects import (
    Context,
    Effect,
    Space,
    Variant,
    fields_of,
    form_of,
    labels_of,
    motion_scale,
    pressures_of,
    term_of,
    weighable,
)

DIRECTIONS = 64
"""Most directions that a family is weighted by: those in which its laws differ most on the run."""
_ROWS = 600
"""Rows by which directions of functions of the observables are told: numerical, bounds memory."""


def family_forms(effect: Effect, context: Context) -> Iterator[Variant]:
    """The forms in which an effect's family is weighted."""
    for space in weighable(effect, context):
        acts = all(f.kind == "pressure" for f in space.features)
        basis = (_through_pressures if acts else _in_observables)(space, context)[:, :DIRECTIONS]
        labels = tuple(labels_of(space, context.rows.chambers))
        if basis.shape[1]:
            term = replace(term_of(space, context, basis, labels), basis=basis)
            yield Variant(form_of(space), (term,), centred=term.kind == "field")


def _through_pressures(space: Space, context: Context) -> Floats:
    """Principal directions (q, r) of the family's prior as it shows in the observables, most important first.

    What a chamber does by itself overlaps with what all do alike, and with no other chamber: so sums are one for each.
    """
    pressures, C = pressures_of(space, context), len(context.span)
    alike, apart = _factors(space, C)
    seen = (context.jacobian**2).mean(axis=(0, 1))
    sums = [size * pressures[:, c].T @ pressures[:, c] for c, size in enumerate(seen)]
    beside = np.concatenate([alike.T @ each @ apart for each in sums], axis=1)
    gram = np.block(
        [
            [alike.T @ np.sum(sums, axis=0) @ alike, beside],
            [beside.T, block_diag(*(apart.T @ each @ apart for each in sums))],
        ]
    )
    return _principal(gram, np.asarray(block_diag(alike, *[apart] * (C if C > 1 else 0))))


def _in_observables(space: Space, context: Context) -> Floats:
    """Principal directions (q, r) of the prior of a family that has functions of the observables, and may have some of
    the pressures; by some rows, with each observable as a share of the rig's motion.
    """
    F, C = context.rows.actuation.shape
    some = np.unique(np.linspace(0, F - 1, min(F, _ROWS)).astype(int))
    P, J = pressures_of(space, context)[some], context.jacobian[some]
    alike, apart = _factors(space, C)
    a, each = P.shape[2], C if C > 1 and P.shape[2] else 0
    columns = [J @ (P @ alike[:a]) + fields_of(space, context)[some] @ alike[a:]]
    columns += [J[:, :, c, None] * (P[:, c] @ apart)[:, None] for c in range(each)]
    Z = (np.concatenate(columns, axis=2) / motion_scale(context)[:, None]).reshape(len(some) * J.shape[1], -1)
    return _principal(Z.T @ Z, _laid(alike, apart, a, each))


def _laid(alike: Floats, apart: Floats, a: int, each: int) -> Floats:
    """Weights (q, r) of all labels: of the pressures alike, of each chamber, of the observables."""
    own = np.asarray(block_diag(*[apart] * each)) if each else np.zeros((0, 0))
    return np.block(
        [
            [alike[:a], np.zeros((a, own.shape[1]))],
            [np.zeros((own.shape[0], alike.shape[1])), own],
            [alike[a:], np.zeros((len(alike) - a, own.shape[1]))],
        ]
    )


def _factors(space: Space, chambers: int) -> tuple[Floats, Floats]:
    """Factors of the prior: of what all chambers have alike, with the observables' own; of each chamber's own."""
    prior = prior_of(space)
    return factor(prior.shared), factor(prior.own)[:, : None if chambers > 1 else 0]


def _principal(gram: Floats, factors: Floats) -> Floats:
    """Factors (q, p) turned to the principal axes of their Gram matrix (p, p), the largest first."""
    power, turn = np.linalg.eigh(gram)
    keep = power > 1e-9 * max(power[-1], 1e-300)
    return (factors @ turn[:, keep])[:, ::-1]
