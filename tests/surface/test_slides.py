"""How sure a registration is where a scan can slide: it does not know, and says so."""

import json

import numpy as np
import pytest

from labrig.ik._outcome import _registration
from labrig.surface import Mesh, grid, register
from labrig.view._validation_report import _scan
from tests.surface.test_registration import torso

UV, TRIANGLES = grid(41, 41)
START = np.eye(3), np.zeros(3)


def sheet(*domes):
    """A flat sheet of 200 mm with round domes of a height, mm, at (u, v)."""
    up = sum(height * np.exp(-((UV - at) ** 2).sum(axis=1) / 0.03) for height, at in domes)
    return np.stack([200 * UV[:, 0], up + 0 * UV[:, 0], 200 * UV[:, 1]], axis=1)


def tube():
    """A third of a tube of 100 mm radius, 200 mm long."""
    angle = 2 * UV[:, 0] - 1
    return np.stack([100 * np.sin(angle), 100 * np.cos(angle), 200 * UV[:, 1]], axis=1)


SLIDING = {
    "plane": sheet(),
    "tube": tube(),
    "dome": sheet((20, (0.5, 0.5))),
    "flat dome": sheet((5, (0.5, 0.5))),
}
HELD = {
    "two domes": sheet((15, (0.3, 0.3)), (15, (0.7, 0.6))),
    "a dome aside": sheet((10, (0.3, 0.3)), (4, (0.7, 0.4))),
    "torso": torso(41, 41).vertices_mm,
}


def placed(points, of_scan_mm, of_surface_mm):
    """A scan of a surface, each with noise, registered from 1 mm beside where it belongs."""
    noise = np.random.default_rng(0).normal(size=(2, *points.shape))
    scan = Mesh(points + of_scan_mm * noise[0] + [1.0, 0.0, 0.5], TRIANGLES)
    return register(scan, Mesh(points + of_surface_mm * noise[1], TRIANGLES), START)


@pytest.mark.parametrize("noise", [(0.0, 0.0), (0.1, 0.0), (0.0, 0.1), (0.1, 0.1)])
@pytest.mark.parametrize("shape", SLIDING)
def test_a_scan_that_can_slide_has_no_finite_deviation(shape, noise):
    """On a plane, a tube or a round dome, exact or with noise on either side, the deviation is not finite."""
    assert placed(SLIDING[shape], *noise).sd_mm == np.inf


@pytest.mark.parametrize("noise", [(0.0, 0.0), (0.1, 0.0), (0.0, 0.1), (0.1, 0.1)])
@pytest.mark.parametrize("shape", HELD)
def test_a_scan_that_is_held_has_a_deviation_that_is_small(shape, noise):
    """A surface that holds a scan in every direction gives a deviation that is small, and holds the error."""
    found = placed(HELD[shape], *noise)
    off = np.linalg.norm(found.apply(HELD[shape] + [1.0, 0.0, 0.5]) - HELD[shape], axis=1).max()
    assert found.sd_mm < 0.3
    assert off < 4 * found.sd_mm + 0.01


def test_what_is_not_known_is_null_in_json_and_said_in_the_report():
    """validation.json stays JSON, with null for a deviation that is not finite, and the report says what that means."""
    found = _registration(placed(SLIDING["plane"], 0.1, 0.0))
    assert json.loads(json.dumps(found, allow_nan=False))["sd_mm"] is None
    assert _scan({"registration": found}).startswith("How exactly the scan is registered is not known")
