"""A target and the surface beside it, as they are drawn."""

import numpy as np
import pytest

from labrig.surface import grid
from labrig.view._target_figures import coarser


@pytest.fixture
def bowl():
    """A bowl of 18 432 triangles, mm."""
    uv, triangles = grid(97, 97)
    x, y = 100.0 * uv.T
    return np.stack([x, y, 0.01 * (x - 50.0) ** 2 + 0.01 * (y - 50.0) ** 2], axis=1), triangles


def area_mm2(vertices_mm, triangles):
    corners = vertices_mm[triangles]
    across = np.cross(corners[:, 1] - corners[:, 0], corners[:, 2] - corners[:, 0])
    return np.linalg.norm(across, axis=1).sum() / 2


def test_a_fine_target_is_drawn_coarser(bowl):
    """With few triangles it has the same size and place: nothing is torn, no corner is collapsed."""
    vertices, triangles = coarser(*bowl, 2000)
    assert 500 < len(triangles) <= 3000
    assert area_mm2(vertices, triangles) == pytest.approx(area_mm2(*bowl), rel=0.06)
    assert np.abs(vertices.max(axis=0) - bowl[0].max(axis=0)).max() < 5.0
    assert (np.sort(triangles, axis=1)[:, 1:] != np.sort(triangles, axis=1)[:, :-1]).all()
    edges = np.sort(np.concatenate([triangles[:, [a, b]] for a, b in ((0, 1), (1, 2), (2, 0))]), axis=1)
    _, used = np.unique(edges, axis=0, return_counts=True)
    assert (used == 1).sum() < 0.12 * len(edges)  # borders: those of the bowl, none within it


def test_a_coarse_one_stays_as_it_is(bowl):
    """Vertex by vertex."""
    vertices, triangles = coarser(*bowl, 20_000)
    assert vertices is bowl[0]
    assert triangles is bowl[1]
