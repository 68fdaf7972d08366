"""Points along a line are no surface, straight or bent; few, narrow or uneven ones that are a surface stay."""

import numpy as np
import pytest

from labrig import LabrigError
from labrig.surface import clean, grid, read_mesh
from tests.surface.test_registration import torso

NONE = np.zeros((0, 3), np.int64)
WAY = np.linspace(0.0, 400.0, 500)
LINES = {
    "straight": np.stack([WAY, 0 * WAY, 0.5 * WAY], axis=1),
    "with noise": np.stack([WAY, 0 * WAY, 0 * WAY], axis=1) + np.random.default_rng(0).normal(size=(500, 3)),
    "an arc": 150 * np.stack([np.cos(WAY / 160), np.sin(WAY / 160), 0 * WAY], axis=1),
    "a profile": np.stack([WAY, 60 * np.sin(WAY / 40), 0 * WAY], axis=1),
    "few points": np.stack([WAY, 0 * WAY, 0 * WAY], axis=1)[::17],
}


def sheet(nu, nv, width=100.0, height=100.0):
    """A slightly bent sheet of nu x nv points."""
    uv, _ = grid(nu, nv)
    return np.stack([width * uv[:, 0], 5 * uv[:, 0] ** 2, height * uv[:, 1]], axis=1)


SURFACES = {
    "torso": torso().vertices_mm,
    "rows far apart": sheet(10, 800),
    "a strip": sheet(5, 150, 10.0, 400.0),
    **{f"{n} x {n} points": sheet(n, n) for n in (5, 6, 7, 8, 9, 10)},
}


@pytest.mark.parametrize("shape", LINES)
def test_points_along_a_line_are_refused(shape):
    """Points along a line, straight or bent, are no target: that is said in one line, with what to do."""
    with pytest.raises(LabrigError) as error:
        clean(LINES[shape], NONE, "target.xyz")
    assert str(error.value) == (
        "target.xyz: its points lie along a line, which is no surface: export points all over it, or its mesh"
    )


@pytest.mark.parametrize("shape", SURFACES)
def test_points_of_a_surface_are_not_refused(shape):
    """Surfaces of few points, in rows far apart, or long and narrow are taken."""
    assert len(clean(SURFACES[shape], NONE).vertices_mm) > 0


def test_a_file_of_points_along_a_line_is_refused_by_name(tmp_path):
    """A file that holds a line is refused where it is read, by its name."""
    np.savetxt(tmp_path / "line.xyz", LINES["straight"])
    with pytest.raises(LabrigError, match=r"line\.xyz: its points lie along a line"):
        read_mesh(tmp_path / "line.xyz")
