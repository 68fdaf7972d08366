"""A small set of shapes with known slopes, that every test learns from."""

import numpy as np
import pytest

from labrig.surface import Spline, grid
from labrig.surrogate import TrainingSet


@pytest.fixture(scope="session")
def shapes():
    """What makes shapes of pressures."""
    return _shapes


def _shapes(pressure_kpa, spline):
    """Control points (N, nu, nv, 3) of a sheet that three chambers bulge, and their slopes (N, nu, nv, 3, 3)."""
    u, v = np.meshgrid(spline.greville[0], spline.greville[1], indexing="ij")
    fade = np.sin(np.pi * u) * np.sin(np.pi * v)
    bumps = [
        fade * np.exp(-8 * ((u - a) ** 2 + (v - b) ** 2)) for a, b in ((0.3, 0.3), (0.7, 0.4), (0.5, 0.7))
    ]
    x = pressure_kpa / 60.0
    rise, slope = np.log1p(2 * x), 2 / (1 + 2 * x) / 60.0
    rest = np.stack([200 * u, 20 * fade, 200 * v], axis=-1)
    control = np.tile(rest, (len(x), 1, 1, 1))
    slopes = np.zeros((*control.shape, 3))
    for c, bump in enumerate(bumps):
        control[..., 1] += 12 * rise[:, c, None, None] * bump
        slopes[..., 1, c] += 12 * slope[:, c, None, None] * bump
    both = bumps[0] * bumps[2]
    control[..., 1] -= 6 * (x[:, 0] * x[:, 2])[:, None, None] * both
    slopes[..., 1, 0] -= 6 * (x[:, 2] / 60.0)[:, None, None] * both
    slopes[..., 1, 2] -= 6 * (x[:, 0] / 60.0)[:, None, None] * both
    return control, slopes


@pytest.fixture(scope="session")
def data(shapes):
    """A hundred shapes of an 8 x 7 sheet under three chambers, with nine markers."""
    spline = Spline((8, 7), 2)
    pressure = np.random.default_rng(0).random((100, 3)) * 60.0
    pressure[:8] = 60.0 * np.array([[a, b, c] for a in (0, 1) for b in (0, 1) for c in (0, 1)])
    control, slopes = shapes(pressure, spline)
    uv, _ = grid(5, 5)
    inside = uv[((uv > 0) & (uv < 1)).all(axis=1)]
    names = tuple(f"m{i + 1:02d}" for i in range(len(inside)))
    chambers = ("c1", "c2", "c3")
    return TrainingSet(
        chambers, np.zeros(3), np.full(3, 60.0), spline, pressure, control, slopes, names, inside
    )
