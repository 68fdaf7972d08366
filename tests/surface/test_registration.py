"""Rigid registration and signed distances, on a shape whose motion is known."""

import numpy as np
import pytest

from labrig import LabrigError
from labrig.surface import Mesh, Target, clean, distances, grid, register
from labrig.surface._pose import angle_deg, rotation_of, spread_rotations


def torso(nu=41, nv=51):
    """An open shell with no symmetry, 300 x 400 mm, (nu * nv) vertices."""
    uv, triangles = grid(nu, nv)
    u, v = uv.T
    angle = (u - 0.5) * 2.4
    radius = 120 + 18 * np.exp(-(((v - 0.7) / 0.15) ** 2) - ((u - 0.35) / 0.15) ** 2) + 12 * np.sin(3 * v) * u
    points = np.stack([radius * np.sin(angle), 0.8 * radius * np.cos(angle), 400 * v], axis=1)
    return Mesh(points, triangles)


def noisy(mesh, seed, sd_mm=0.1):
    return Mesh(
        mesh.vertices_mm + np.random.default_rng(seed).normal(0, sd_mm, mesh.vertices_mm.shape),
        mesh.triangles,
    )


def error_mm(found, moved_from, rotation, shift):
    """The largest distance between where a point should come to lie and where it does."""
    return np.linalg.norm(
        found.apply(moved_from.vertices_mm @ rotation.T + shift) - moved_from.vertices_mm, axis=1
    ).max()


def test_any_pose_is_recovered():
    """However a scan is turned and wherever it lies, it is brought back."""
    shape = torso()
    for number, rotation in enumerate(spread_rotations(6)):
        shift = np.array([300.0, -200.0, 50.0 * number])
        found = register(noisy(shape, number).moved(rotation, shift), Target(shape))
        assert error_mm(found, shape, rotation, shift) < 0.1


def test_scans_repeat():
    """Scans of one shape with noise of 0.1 mm come to lie within 0.05 mm of each other."""
    shape = torso(81, 101)
    places = []
    for seed in range(6):
        rotation, shift = rotation_of(np.random.default_rng(seed).normal(0, 0.3, 3)), np.full(3, 10.0 * seed)
        found = register(noisy(shape, seed).moved(rotation, shift), shape)
        places.append(found.apply(shape.vertices_mm @ rotation.T + shift))
    assert np.linalg.norm(places - np.mean(places, axis=0), axis=-1).max() < 0.05


def test_partial_scan_with_holes_and_debris():
    """Two thirds of a shape, with a hole and a foreign blob of 8 % of the points, lie where the whole one would."""
    shape = torso()
    x, z = shape.vertices_mm[:, 0], shape.vertices_mm[:, 2]
    kept = (z < 270) & (np.hypot(x - 20, z - 120) > 25)
    triangles = shape.triangles[kept[shape.triangles].all(axis=1)]
    bump = np.exp(-((x + 60) ** 2 + (z - 200) ** 2) / 400.0)[:, None] * np.array([0.0, 25.0, 0.0])
    part = clean(shape.vertices_mm, triangles)
    scan = clean(noisy(shape, 3).vertices_mm + bump, triangles)
    rotation, shift = rotation_of(np.array([0.3, 0.2, -0.4])), np.array([40.0, 0.0, -30.0])
    found = register(scan.moved(rotation, shift), shape)
    assert error_mm(found, part, rotation, shift) < 4 * found.sd_mm < 0.7
    assert found.share < 0.95


def test_cloud_without_normals():
    """Points alone are enough, on either side."""
    shape = torso()
    cloud = Mesh(noisy(shape, 5).vertices_mm, np.zeros((0, 3), np.int64))
    rotation, shift = rotation_of(np.array([0.1, 0.5, -0.2])), np.array([20.0, 10.0, 0.0])
    assert error_mm(register(cloud.moved(rotation, shift), shape), shape, rotation, shift) < 0.15
    assert error_mm(register(noisy(shape, 6).moved(rotation, shift), cloud), shape, rotation, shift) < 0.3


def test_registration_says_how_sure_it_is():
    """The stated standard deviation of the worst point is of the order of what repeats differ by."""
    shape = torso()
    errors, stated = [], []
    for seed in range(8):
        found = register(noisy(shape, seed), shape)
        errors.append(error_mm(found, shape, np.eye(3), np.zeros(3)))
        stated.append(found.sd_mm)
    assert 0.3 < np.sqrt(np.mean(np.square(errors))) / np.mean(stated) < 3.0


def test_what_does_not_fit_is_said():
    """Two surfaces without a common part, held where they are, are an error and no motion."""
    shape = torso(11, 11)
    far = shape.moved(np.eye(3), np.array([0.0, 0.0, 5000.0]))
    with pytest.raises(LabrigError) as error:
        register(far, shape, start=(np.eye(3), np.zeros(3)))
    assert (
        str(error.value) == "the scan and the surface do not fit each other: no part of one lies on the other"
    )


def test_signed_distances_are_exact():
    """Points at known heights over a fine flat mesh are at that distance: positive outside, negative inside."""
    uv, triangles = grid(15, 15)
    flat = Mesh(np.stack([100 * uv[:, 0], np.zeros(len(uv)), 100 * uv[:, 1]], axis=1), triangles)
    outwards = flat.normals[100]
    rng = np.random.default_rng(0)
    height = rng.normal(0, 5, 200)
    foot = np.stack([rng.uniform(5, 95, 200), np.zeros(200), rng.uniform(5, 95, 200)], axis=1)
    found = distances(foot + height[:, None] * outwards, flat)
    np.testing.assert_allclose(found.signed_mm, height, atol=1e-9)
    np.testing.assert_allclose(found.feet_mm, foot, atol=1e-9)
    assert not found.beyond.any()


def test_points_beside_a_border_are_beyond():
    """A point that has nothing opposite is marked and does not count in the summary."""
    uv, triangles = grid(9, 9)
    flat = Mesh(np.stack([100 * uv[:, 0], np.zeros(len(uv)), 100 * uv[:, 1]], axis=1), triangles)
    found = distances(np.array([[150.0, 0.0, 50.0], [50.0, 3.0, 50.0], [110.0, 2.0, 110.0]]), flat)
    assert found.beyond.tolist() == [True, False, True]
    assert found.summary()["max_mm"] == pytest.approx(3.0)
    assert found.summary()["share"] == pytest.approx(1 / 3)


def test_distance_to_a_mesh_equals_brute_force():
    """On a curved, uneven mesh the nearest triangle is found among those of the nearest vertices."""
    import trimesh

    shape = torso(21, 26)
    points = shape.vertices_mm[::3] + np.random.default_rng(2).normal(0, 4, shape.vertices_mm[::3].shape)
    corners = shape.vertices_mm[shape.triangles]
    everything = [
        np.linalg.norm(
            trimesh.triangles.closest_point(corners, np.repeat(p[None], len(corners), axis=0)) - p, axis=1
        ).min()
        for p in points
    ]
    np.testing.assert_allclose(np.abs(distances(points, shape).signed_mm), everything, atol=1e-9)


def test_rotation_vectors():
    """A rotation vector's length is the angle it turns by."""
    assert angle_deg(rotation_of(np.array([0.0, np.pi / 3, 0.0]))) == pytest.approx(60.0)
