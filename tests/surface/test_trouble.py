"""What goes wrong with real scans: fragments, a hand, half of it missing, wrong sides, wrong units, a table, holes."""

import numpy as np
import pytest

from labrig import LabrigError
from labrig.surface import Mesh, clean, distances, grid, read_mesh, register
from labrig.surface._pose import rotation_of
from labrig_drivers.simulated._artec_twin import ply_bytes
from tests.surface.test_registration import torso

TURN, SHIFT = rotation_of(np.array([1.1, -0.7, 0.9])), np.array([250.0, -120.0, 80.0])


def ball(middle, radius_mm, side=15):
    """A closed ball of `side` x `side` points."""
    uv, triangles = grid(side, side)
    a, b = 2 * np.pi * uv[:, 0], np.pi * uv[:, 1]
    at = np.stack([np.sin(b) * np.cos(a), np.sin(b) * np.sin(a), np.cos(b)], axis=1)
    return Mesh(np.asarray(middle) + radius_mm * at, triangles)


def together(*meshes):
    """Several meshes as one; they share no vertex."""
    starts = np.cumsum([0, *(len(mesh.vertices_mm) for mesh in meshes)])
    triangles = [mesh.triangles + start for mesh, start in zip(meshes, starts, strict=False)]
    return np.concatenate([mesh.vertices_mm for mesh in meshes]), np.concatenate(triangles)


def scanned(vertices, triangles, seed=0):
    """With noise of 0.1 mm, cleaned, and in another pose."""
    noise = np.random.default_rng(seed).normal(0, 0.1, vertices.shape)
    return clean(vertices + noise, triangles).moved(TURN, SHIFT)


def off_mm(found, points):
    """How far points of the surface, as they lie in the scan's pose, are brought from where they belong, at most."""
    return np.linalg.norm(found.apply(points @ TURN.T + SHIFT) - points, axis=1).max()


def test_fragments_are_dropped():
    """Loose bits beside the surface go, the surface stays whole, and it is said how many there were."""
    shape = torso(61, 71)
    bits = [ball([200.0 + 40 * k, 60.0 * k, 100.0], 4.0) for k in range(3)]
    mesh = clean(*together(shape, *bits))
    assert len(mesh.vertices_mm) == len(shape.vertices_mm)
    assert mesh.notes == ("loose fragments dropped: 3",)


def test_a_clouds_fragments_are_dropped():
    """Of a cloud, clusters and single points beside it go, and its corners stay."""
    shape = torso(31, 36)
    bit = np.random.default_rng(0).normal([300.0, 0.0, 0.0], 5.0, (12, 3))
    points = np.concatenate([shape.vertices_mm, bit, [[0.0, 400.0, 0.0], [900.0, 0.0, 0.0]]])
    cloud = clean(points, np.zeros((0, 3)))
    assert len(cloud.vertices_mm) == len(shape.vertices_mm)
    assert cloud.notes == ("outliers and fragments dropped: 14 points",)


@pytest.mark.parametrize("touching", [False, True])
def test_a_hand_in_the_picture_does_not_move_the_scan(touching):
    """A fist of a sixth of all points, beside or against it, leaves the pose right to 0.15 mm."""
    shape = torso(61, 71)
    fist = ball([140.0 if touching else 220.0, 60.0, 330.0], 60.0, 30)
    found = register(scanned(*together(shape, fist)), shape)
    assert off_mm(found, shape.vertices_mm) < 0.15
    assert found.share < 0.95


@pytest.mark.parametrize("axis", [0, 2])
def test_half_of_the_surface_is_enough(axis):
    """A scan that shows one half, left or upper, lies where the whole would, to 0.4 mm where it is."""
    shape = torso(61, 71)
    at = shape.vertices_mm[:, axis]
    triangles = shape.triangles[(at > np.median(at))[shape.triangles].all(axis=1)]
    found = register(scanned(shape.vertices_mm, triangles), shape)
    assert off_mm(found, shape.vertices_mm[np.unique(triangles)]) < 0.4


def test_triangles_that_face_the_other_way_are_turned():
    """A patch wound the wrong way round gets the side of those around it, and the normals are whole again."""
    shape = torso(61, 71)
    patch = np.zeros(len(shape.triangles), bool)
    patch[500:900] = True
    mixed = np.where(patch[:, None], shape.triangles[:, ::-1], shape.triangles)
    mesh = clean(shape.vertices_mm, mixed)
    np.testing.assert_allclose(mesh.normals, shape.normals, atol=1e-9)
    assert mesh.notes == ("400 triangles faced the other way than those around them, and were turned",)


def test_a_scan_that_is_inside_out_is_placed_and_said():
    """With every normal flipped a scan is registered all the same, and turned it has the surface's outside."""
    shape = torso(61, 71)
    scan = scanned(shape.vertices_mm, shape.triangles).turned()
    found = register(scan, shape)
    assert off_mm(found, shape.vertices_mm) < 0.1
    assert found.turned
    again = register(scan.turned(), shape)
    assert not again.turned
    above = shape.vertices_mm[2000] + 5.0 * shape.normals[2000]
    right = scan.turned().moved(found.rotation, found.translation_mm)
    assert distances(above[None], right).signed_mm[0] == pytest.approx(5.0, abs=0.5)


@pytest.mark.parametrize(("scale", "notes"), [(1.0, 0), (0.001, 1)])
def test_millimetres_or_metres_are_told_by_the_model(tmp_path, scale, notes):
    """A small model's scan comes out in mm from a file in mm or in m, and what was guessed is said in one line."""
    small = Mesh(
        0.05 * torso(21, 26).vertices_mm, torso(21, 26).triangles
    )  # 24 mm: no size for a person's surface
    like_mm = float(np.linalg.norm(np.ptp(small.vertices_mm, axis=0)))
    path = tmp_path / "scan.ply"
    path.write_bytes(ply_bytes(scale * small.vertices_mm, small.triangles))
    mesh = read_mesh(path, like_mm=like_mm)
    assert np.ptp(mesh.vertices_mm[:, 2]) == pytest.approx(20.0, rel=1e-4)
    assert len(mesh.notes) == notes
    assert all(
        note == "scan.ply is 0.0235 across and does not say its unit: taken for m" for note in mesh.notes
    )


def test_a_size_far_from_the_models_is_an_error(tmp_path):
    """What is in mm or in m nowhere near the model's size is not guessed at, neither read nor registered."""
    shape = torso(21, 26)
    path = tmp_path / "scan.ply"
    path.write_bytes(ply_bytes(0.04 * shape.vertices_mm, shape.triangles))
    with pytest.raises(LabrigError) as error:
        read_mesh(path, like_mm=500.0)
    assert str(error.value).endswith("in mm or in m not near to the model's 500 mm: say its unit (--unit)")
    metres = Mesh(0.001 * shape.vertices_mm, shape.triangles)
    with pytest.raises(LabrigError) as error:
        register(metres, shape)
    assert str(error.value).endswith("is the scan's unit right?")


def on_a_table(shape):
    """The torso standing on a table of 900 x 900 mm, in one piece with nothing."""
    uv, triangles = grid(61, 61)
    table = Mesh(
        np.stack([900 * uv[:, 0] - 450, 900 * uv[:, 1] - 450, np.full(len(uv), -1.0)], axis=1), triangles
    )
    return together(shape, table)


def test_a_base_plane_is_cut_away():
    """The table under a surface goes, all of it, where the model's size says that it is too much, and not otherwise."""
    shape = torso(61, 71)
    vertices, triangles = on_a_table(shape)
    like_mm = float(np.linalg.norm(np.ptp(shape.vertices_mm, axis=0)))
    mesh = clean(vertices, triangles, like_mm=like_mm)
    assert np.ptp(mesh.vertices_mm[:, 0]) < 1.05 * np.ptp(shape.vertices_mm[:, 0])
    assert len(mesh.vertices_mm) > 0.95 * len(shape.vertices_mm)
    assert "base plane cut away" in mesh.notes[0]
    assert np.ptp(clean(vertices, triangles).vertices_mm[:, 0]) > 890
    flat = Mesh(*on_a_table(torso(5, 5)))
    plate = flat.vertices_mm[25:], flat.triangles[32:] - 25
    assert len(clean(*plate, like_mm=100.0).vertices_mm) == 61 * 61


def test_a_sheet_that_lies_askew_stands_on_nothing():
    """A square sheet with a flat rim stays whole in any pose, though its box along the axes grows as it is turned."""
    uv, triangles = grid(41, 41)
    x, y = 200 * uv[:, 0] - 100, 200 * uv[:, 1] - 100
    bulge = 30 * np.maximum(1 - (np.hypot(x, y) / 60) ** 2, 0.0)
    sheet = np.stack([x, y, bulge], axis=1)
    like_mm = float(np.linalg.norm(np.ptp(sheet, axis=0)))
    for turn in ([0, 0, 0], [0, 0, np.pi / 4], [0.6, -0.5, 0.8]):
        mesh = clean(sheet @ rotation_of(np.array(turn)).T, triangles, like_mm=like_mm)
        assert len(mesh.vertices_mm) == len(sheet), turn


def test_a_clouds_base_plane_is_cut_away():
    """The same for points alone."""
    shape = torso(61, 71)
    vertices, _ = on_a_table(shape)
    like_mm = float(np.linalg.norm(np.ptp(shape.vertices_mm, axis=0)))
    cloud = clean(vertices, np.zeros((0, 3)), like_mm=like_mm)
    assert np.ptp(cloud.vertices_mm[:, 0]) < 1.05 * np.ptp(shape.vertices_mm[:, 0])
    assert len(cloud.vertices_mm) > 0.95 * len(shape.vertices_mm)


def test_small_holes_are_closed_and_large_ones_stay():
    """A hole of a marker's size is closed with triangles that face outwards; one of a fifth of the surface is not."""
    shape = torso(61, 71)
    middle = shape.vertices_mm[61 * 35 + 30]
    far = np.linalg.norm(shape.vertices_mm - middle, axis=1)
    small = shape.triangles[(far > 4.0)[shape.triangles].all(axis=1)]
    mesh = clean(shape.vertices_mm, small)
    assert len(mesh.triangles) > len(small)
    assert mesh.border.sum() == shape.border.sum()
    assert distances((middle + 5.0 * shape.normals[61 * 35 + 30])[None], mesh).signed_mm[0] == pytest.approx(
        5.0, abs=0.5
    )
    assert mesh.notes[-1].startswith("small holes closed with ")
    large = shape.triangles[(far > 80.0)[shape.triangles].all(axis=1)]
    assert len(clean(shape.vertices_mm, large).triangles) == len(large)


def test_a_scan_always_comes_to_lie_at_the_same_place():
    """The global search draws by chance from a seed: the same scan gives the same motion, every time."""
    shape = torso(31, 36)
    scan = scanned(shape.vertices_mm, shape.triangles)
    first, second = register(scan, shape), register(scan, shape)
    np.testing.assert_allclose(first.rotation, second.rotation, atol=1e-12)
    np.testing.assert_allclose(first.translation_mm, second.translation_mm, atol=1e-9)
