"""Honest standard deviations: sizes from errors on shapes that a model did not learn from."""

from dataclasses import replace

import numpy as np

from labrig._linalg import svd
from labrig.arrays import Floats
from labrig.surface import grid
from labrig.surrogate._forward import ForwardModel

_GRID = 34
_PARTS = 60
"""Directions of the latent errors that are kept; they hold nearly all of them."""
NORMAL_95 = 1.96


def calibrated(model: ForwardModel, missed: Floats, doubt: Floats) -> ForwardModel:
    """The model with the sizes of its errors set: where on the surface they are, and how large.

    `missed` (n, D): errors of the control points of shapes that were left out; `doubt` (n,): the head's, likewise.
    The pattern over the surface is the covariance of errors per unit of doubt; the factor makes 95 % of all samples
    lie within 1.96 standard deviations.
    """
    modes = model.modes_mm.reshape(len(model.modes_mm), -1)
    errors = np.linalg.lstsq(modes.T, missed.T, rcond=None)[0].T
    part = (errors / doubt[:, None]) / np.sqrt(len(errors))
    _, size, direction = svd(part)
    model = replace(model, spread=np.ascontiguousarray((direction * size[:, None])[:_PARTS].T), factor=1.0)
    uv, _ = grid(_GRID, _GRID)
    basis = model.spline.basis(uv)
    distance = np.stack([np.linalg.norm(basis @ one, axis=1) for one in missed.reshape(len(missed), -1, 3)])
    pattern = model.pattern_mm(uv)
    moved = pattern > 1e-9  # a clamped border has no error at all
    ratio = distance[:, moved] / (doubt[:, None] * pattern[moved])
    return replace(model, factor=float(np.quantile(ratio, 0.95)) / NORMAL_95 if ratio.size else 1.0)
