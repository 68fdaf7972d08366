"""Meshes as scanners export them: units, seams, debris, normals, borders."""

import numpy as np
import pytest

from labrig import LabrigError
from labrig.surface import Mesh, Nearest, Target, clean, grid, read_mesh
from labrig_drivers.simulated._artec_twin import obj_bytes, ply_bytes, stl_bytes, xyz_bytes

WRITERS = {
    "obj": lambda v, t: obj_bytes(v, t, "none.mtl", True),
    "ply": ply_bytes,
    "stl": stl_bytes,
    "xyz": xyz_bytes,
}


def dome(scale=1.0):
    uv, triangles = grid(21, 21)
    x, z = 300 * (uv[:, 0] - 0.5), 300 * (uv[:, 1] - 0.5)
    return Mesh(scale * np.stack([x, 80 - (x**2 + z**2) / 500, z], axis=1), triangles)


@pytest.mark.parametrize("kind", sorted(WRITERS))
@pytest.mark.parametrize("scale", [1.0, 0.001])
def test_every_export_gives_the_same_surface(tmp_path, kind, scale):
    """OBJ with seams (its colours lost), PLY, STL and a cloud, in mm or m, come out in mm with as many points."""
    shape = dome(scale)
    path = tmp_path / f"Eva scan 1.{kind}"
    path.write_bytes(WRITERS[kind](shape.vertices_mm, shape.triangles))
    mesh = read_mesh(path)
    assert mesh.is_cloud == (kind == "xyz")
    assert len(mesh.vertices_mm) == len(shape.vertices_mm)
    assert Nearest(mesh.vertices_mm).one(dome().vertices_mm)[1].max() < 2e-3**2


def test_a_unit_that_is_given_is_believed(tmp_path):
    """The option goes before the guess, and a PLY's own comment does too."""
    shape = dome()
    path = tmp_path / "a.ply"
    path.write_bytes(ply_bytes(shape.vertices_mm, shape.triangles))
    assert np.ptp(read_mesh(path, "cm").vertices_mm[:, 0]) == pytest.approx(3000)
    said = ply_bytes(shape.vertices_mm, shape.triangles).replace(b"1.0\n", b"1.0\ncomment unit inch\n", 1)
    path.write_bytes(said)
    assert np.ptp(read_mesh(path).vertices_mm[:, 0]) == pytest.approx(7620)


def test_errors_name_the_file(tmp_path):
    """What cannot be read is said in one line with the file's name."""
    path = tmp_path / "a.ply"
    with pytest.raises(LabrigError) as error:
        read_mesh(path)
    assert str(error.value) == f"cannot read {path}: No such file or directory"
    shape = dome(20.0)
    path.write_bytes(ply_bytes(shape.vertices_mm, shape.triangles)[:-100])
    with pytest.raises(LabrigError, match="promises at least"):
        read_mesh(path)
    path.write_bytes(ply_bytes(shape.vertices_mm, shape.triangles))
    with pytest.raises(LabrigError) as error:
        read_mesh(path)
    assert str(error.value).endswith(" across, in mm or in m no size for a surface: say its unit (--unit)")
    with pytest.raises(LabrigError) as error:
        read_mesh(path, "foot")
    assert str(error.value) == "unit 'foot': choose one of mm, cm, m, inch"


def test_debris_goes_and_the_border_is_known():
    """A loose piece of a few triangles is dropped; holes and the outer rim are border, the rest is not."""
    shape = dome()
    hole = np.flatnonzero((shape.triangles == 220).any(axis=1))
    kept = np.delete(shape.triangles, hole, axis=0)
    loose = np.array([[500.0, 0, 0], [510, 0, 0], [500, 10, 0]])
    mesh = clean(np.concatenate([shape.vertices_mm, loose]), np.concatenate([kept, [[441, 442, 443]]]))
    assert len(mesh.vertices_mm) == 440
    assert mesh.border.sum() == 80 + 6


def test_normals_point_outwards():
    """A mesh's normals follow its triangles; a cloud's are turned away from its inside."""
    shape = dome()
    x, _, z = shape.vertices_mm.T
    truth = np.stack([x / 250, np.ones_like(x), z / 250], axis=1)
    truth /= np.linalg.norm(truth, axis=1, keepdims=True)
    inner = ~shape.border
    assert (np.einsum("pi,pi->p", shape.normals, truth)[inner] > 0.999).all()
    cloud = Mesh(shape.vertices_mm, np.zeros((0, 3), np.int64))
    assert (np.einsum("pi,pi->p", cloud.normals, truth)[inner] > 0.99).mean() > 0.95
    assert cloud.border[shape.border].mean() > 0.9
    assert cloud.border[inner].mean() < 0.1


def test_a_clouds_outliers_go():
    """Points far from all others are no part of the surface."""
    shape = dome()
    cloud = clean(np.concatenate([shape.vertices_mm, [[0, 400.0, 0], [700, 0, 0]]]), np.zeros((0, 3)))
    assert len(cloud.vertices_mm) == len(shape.vertices_mm)
    with pytest.raises(LabrigError) as error:
        clean(shape.vertices_mm[:5], np.zeros((0, 3)), "x.xyz")
    assert str(error.value) == "x.xyz: has 5 different points, which is no surface"


def test_inwardness_rises_from_the_border():
    """Border vertices count nothing, those two edges away in full, more on finer meshes; a cloud's all or none."""
    shape = dome()
    ring = shape.inwardness.reshape(21, 21)
    assert ring[0].max() == ring[:, -1].max() == 0.0
    assert ring[1, 5] == ring[5, 1] == 0.5
    assert ring[2:19, 2:19].min() == 1.0
    uv, triangles = grid(81, 61)
    fine = Mesh(np.column_stack([uv, np.zeros(len(uv))]), triangles).inwardness.reshape(61, 81)
    np.testing.assert_array_equal(fine[30, :6], [0.0, 0.25, 0.5, 0.75, 1.0, 1.0])
    assert set(np.unique(Mesh(shape.vertices_mm, np.zeros((0, 3), np.int64)).inwardness)) == {0.0, 1.0}


def test_the_slope_of_inwardness_points_inwards():
    """Its slope along the surface is a half an edge near a border, none far from it, and along the surface."""
    uv, triangles = grid(21, 21)
    flat = Mesh(np.column_stack([100.0 * uv, np.zeros(len(uv))]), triangles)  # edges of 5 mm
    slope = flat.inward_slope.reshape(21, 21, 3)
    np.testing.assert_allclose(slope[1, 10], [0, 0.1, 0], atol=1e-12)
    np.testing.assert_allclose(slope[10, 19], [-0.1, 0, 0], atol=1e-12)
    assert not slope[6:15, 6:15].any()
    assert not Mesh(flat.vertices_mm, np.zeros((0, 3), np.int64)).inward_slope.any()
    across = np.einsum("vi,vi->v", dome().inward_slope, dome().normals)
    assert np.abs(across).max() < 0.2 * np.abs(dome().inward_slope).max()


def test_nearest_vertices_from_near_ones():
    """Found along the surface they are the tree's, as long as nothing moved far; a cloud asks its tree."""
    target = Target(dome())
    before = np.arange(441)[::3]
    moved = target.mesh.vertices_mm[before] + np.random.default_rng(0).normal(0, 8.0, (147, 3))
    expected, _ = target.nearest.one(moved)
    assert (expected != before).mean() > 0.1
    np.testing.assert_array_equal(target.near(moved, before), expected)
    cloud = Target(Mesh(target.mesh.vertices_mm, np.zeros((0, 3), np.int64)))
    np.testing.assert_array_equal(cloud.near(moved, np.zeros(147, np.int64)), expected)
    uv, triangles = grid(101, 101)
    fine = Target(
        Mesh(np.column_stack([uv, np.sin(3 * uv[:, 0])]), triangles)
    )  # more than its small tree holds
    moved = fine.mesh.vertices_mm[::7] + np.random.default_rng(0).normal(0, 0.02, (1458, 3))
    np.testing.assert_array_equal(fine.near(moved), fine.nearest.one(moved)[0])


def test_a_file_of_nothing_holds_no_vertices(tmp_path):
    """An empty PLY is named as such, and not as something that a library stumbles over."""
    path = tmp_path / "empty.ply"
    header = "format ascii 1.0\nelement vertex 0\nproperty float x\nproperty float y\nproperty float z"
    faces = "element face 0\nproperty list uchar int vertex_indices"
    path.write_text(f"ply\n{header}\n{faces}\nend_header\n")
    with pytest.raises(LabrigError, match=r"empty\.ply holds no vertices"):
        read_mesh(path)
