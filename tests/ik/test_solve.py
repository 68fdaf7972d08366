"""Inverse kinematics: known actuations are found again, from any pose and in part, and what cannot be is said."""

import re

import numpy as np
import pytest

from labrig import LabrigError
from labrig.ik import Pose, Solver
from labrig.ik._gaps import find_gaps, limits_of
from labrig.ik._models import SurfaceModel
from labrig.physics import load_surface
from labrig.surface import Mesh, clean, distances, grid
from labrig.surface._pose import angle_deg, rotation_of, spread_rotations

TRUTH = np.array([20.0, 35.0, 10.0, 40.0, 25.0, 50.0, 15.0, 30.0, 45.0])


def test_a_known_shape_is_found_again(solver, mannequin, make_target):
    """From half pressure and a pose some centimetres off: pressures to 0.5 kPa, surface to the scan's noise."""
    rotation, shift = rotation_of(np.array([0.06, -0.04, 0.05])), np.array([9.0, -12.0, 6.0])
    found = solver.solve(make_target(mannequin, TRUTH, rotation, shift))
    np.testing.assert_allclose(found.pressure_kpa, TRUTH, atol=0.5)
    assert angle_deg(found.rotation @ rotation.T) < 0.1
    assert found.mean_mm < 0.12
    assert found.starts == 1
    assert found.iterations <= 12
    assert not found.gaps


def test_a_compiled_model_with_a_warp(warped, make_target):
    """The warp's derivatives lead to the right actuation."""
    truth = np.array([10.0, 50.0, 35.0, 20.0])
    found = Solver(warped).solve(
        make_target(warped, truth, rotation_of(np.array([0.05, 0.0, 0.03])), np.ones(3))
    )
    np.testing.assert_allclose(found.pressure_kpa, truth, atol=1.5)
    assert found.mean_mm < 0.12


def test_any_pose(solver, mannequin, make_target):
    """However the target lies, it is found."""
    for number, rotation in enumerate(spread_rotations(5)):
        found = solver.solve(
            make_target(mannequin, TRUTH, rotation, np.array([400.0, -300.0, 90.0 * number]))
        )
        assert found.mean_mm < 0.15
        np.testing.assert_allclose(found.pressure_kpa, TRUTH, atol=1.0)


def test_a_flat_sheet_that_is_upside_down_in_its_place(make_target):
    """A sheet that lies where the model is, its face to the back, is turned, not flattened."""
    sheet = SurfaceModel(load_surface({"simulated": {"surface": "membrane"}}))
    target = make_target(sheet, [15.0, 6.0, 10.0, 8.0])
    middle, over = np.array([0.0, 0.0, 100.0]), np.diag([1.0, -1.0, -1.0])
    found = Solver(sheet).solve(Mesh((target.vertices_mm - middle) @ over + middle, target.triangles))
    assert found.mean_mm < 0.15
    np.testing.assert_allclose(np.sort(found.pressure_kpa), [6.0, 8.0, 10.0, 15.0], atol=2.0)


def test_partial_target_with_a_hole_and_a_foreign_body(solver, mannequin, make_target):
    """Two thirds of the surface with a hole and a hand-sized blob still give the pressures of the chambers in it."""
    whole = make_target(mannequin, TRUTH)
    x, y, z = whole.vertices_mm.T
    kept = (z < 300) & (np.hypot(x - 40, z - 150) > 20)
    blob = 40.0 * np.exp(-((x + 70) ** 2 + (z - 60) ** 2) / 500.0)
    points = np.stack([x, y + blob, z], axis=1)
    target = clean(points, whole.triangles[kept[whole.triangles].all(axis=1)])
    found = solver.solve(target, Pose.identity())
    np.testing.assert_allclose(found.pressure_kpa[3:], TRUTH[3:], atol=2.5)
    assert found.share < 0.9
    clear = np.abs(blob[kept]) < 0.5
    placed = points[kept][clear] @ found.rotation.T + found.translation_mm
    back = distances(placed, Mesh(make_target(mannequin, TRUTH).vertices_mm, whole.triangles))
    assert np.abs(back.within).mean() < 0.3


def test_a_surface_that_can_be_turned_onto_itself_says_so(make_target):
    """A target from anywhere fits a square sheet in four ways, and all are named; in its place it fits in one."""
    shell = load_surface({"simulated": {"surface": "membrane"}})
    model = SurfaceModel(shell)
    solver = Solver(model)
    truth = np.array([10.0, 25.0, 40.0, 55.0])
    rotation, shift = rotation_of(np.array([0.5, 1.2, -2.0])), np.array([1000.0, -300.0, 40.0])
    found = solver.solve(make_target(model, truth, rotation, shift))
    (note,) = found.notes
    assert note.count("turned by") == 3
    ways = [[float(kpa) for kpa in re.findall(r"c\d+ (\d+\.\d)", way)] for way in note.split(";")]
    every = sorted([found.pressure_kpa.round(1).tolist(), *ways])
    assert [np.argsort(np.argsort(way))[0] for way in every] == [0, 1, 2, 3]  # c1 in each corner's place once
    for way in every:
        np.testing.assert_allclose(sorted(way), truth, atol=8.0)  # its chambers are not quite alike
    assert not solver.solve(make_target(model, truth)).notes


def test_a_small_part_in_its_place_stays_there(net, make_target):
    """A target that shows a quarter of the surface, where it lies, is compared there and not somewhere else."""
    uv, triangles = grid(71, 81)
    truth = np.array([20.0, 20.0, 40.0, 40.0])
    whole = make_target(net, truth)
    mesh = clean(whole.vertices_mm, triangles[(uv[triangles] < 0.4).all(axis=(1, 2))])
    found = Solver(net).solve(mesh)
    assert angle_deg(found.rotation) < 5.0
    assert np.linalg.norm(found.translation_mm) < 15.0
    assert found.mean_mm < 0.12


def test_a_cloud(solver, mannequin, make_target):
    """Points without triangles will do."""
    target = make_target(mannequin, TRUTH)
    found = solver.solve(Mesh(target.vertices_mm, np.zeros((0, 3), np.int64)))
    np.testing.assert_allclose(found.pressure_kpa, TRUTH, atol=1.0)


def test_triangles_that_face_inwards(solver, mannequin, make_target):
    """A target with its triangles the wrong way round is found, near and far; signs mean the same as ever."""
    target = make_target(mannequin, TRUTH)
    target = Mesh(target.vertices_mm, target.triangles[:, ::-1].copy())
    x, _, z = target.vertices_mm.T
    bump = 15.0 * np.exp(-((x - 30) ** 2 + (z - 250) ** 2) / 400.0)
    bumped = Mesh(target.vertices_mm + bump[:, None] * [0, 1, 0], target.triangles)
    near = solver.solve(bumped)
    assert near.inverted
    assert near.gaps[0].depth_mm < -6.0
    far = solver.solve(target.moved(spread_rotations(9)[4], np.array([300.0, 50.0, -200.0])))
    assert far.mean_mm < 0.15
    assert far.inverted
    assert far.notes[0].startswith("the target lies on the surface inside out: ")


def test_what_a_part_of_a_target_does_not_fix_is_said(solver, mannequin):
    """The left half of a body says nothing of two chambers at the right, whose pressures are a guess then."""
    uv, triangles = grid(71, 81)
    points = mannequin.points(TRUTH[None], uv * [0.5, 1.0])[0]
    found = solver.solve(Mesh(points + np.random.default_rng(0).normal(0, 0.1, points.shape), triangles))
    (said,) = found.notes
    assert said.startswith("the target does not fix the pressures of c3 and c9: other values fit it as well")
    known = [0, 1, 3, 4, 5, 6, 7]
    np.testing.assert_allclose(found.pressure_kpa[known], TRUTH[known], atol=1.0)


def test_a_unit_that_is_off_is_said(solver, mannequin, make_target):
    """A body in cm is too small, one in mm that was read as cm too large: what it may be stands with it."""
    target = make_target(mannequin, TRUTH)
    with pytest.raises(LabrigError) as error:
        solver.solve(Mesh(0.1 * target.vertices_mm, target.triangles), Pose(np.eye(3), np.full(3, 3000.0)))
    assert str(error.value).endswith("; read as cm (--unit cm) it would be about as large")
    found = solver.solve(Mesh(10.0 * target.vertices_mm, target.triangles), Pose.identity(), iterations=1)
    assert found.notes[0].endswith(": was something in mm read as cm?")


def test_limits_hold(mannequin, make_target):
    """Within narrower limits of a rig the best is at the limit, and the gap says which chamber stands against it."""
    high = np.full(9, 60.0)
    high[5] = 25.0
    found = Solver(mannequin, high_kpa=high).solve(make_target(mannequin, TRUTH))
    assert found.pressure_kpa[5] == pytest.approx(25.0)
    assert (found.pressure_kpa <= high + 1e-9).all()
    assert "c6" in found.limited
    assert found.gaps[0].depth_mm < -2.0
    assert found.gaps[0].chamber == "c6"
    assert found.gaps[0].limit == "highest"
    assert found.gaps[0].words.endswith("; c6 is at its highest pressure")


def test_unreachable_target_says_how_much_and_where(solver, mannequin, make_target):
    """A bump that no chamber can make is a gap of about its height at its place."""
    target = make_target(mannequin, TRUTH)
    x, _, z = target.vertices_mm.T
    bump = 15.0 * np.exp(-((x - 30) ** 2 + (z - 250) ** 2) / 400.0)
    found = solver.solve(
        Mesh(target.vertices_mm + bump[:, None] * [0, 1, 0], target.triangles), Pose.identity()
    )
    gap = found.gaps[0]
    assert -15.0 < gap.depth_mm < -6.0
    assert np.hypot(gap.middle_mm[0] - 30, gap.middle_mm[2] - 250) < 25


def test_a_chamber_that_sucks_is_at_the_other_limit():
    """Where more pressure moves the surface inwards, what stands out of the target wants more of it."""
    high = limits_of(np.array([60.0]), np.array([0.0]), np.array([60.0]))
    uv, _ = grid(5, 5)
    for inwards, limit in ((-1.0, "highest"), (1.0, "")):
        (gap,) = find_gaps(np.full(25, 5.0), uv, np.zeros((25, 3)), np.full((25, 1), inwards), ("c1",), high)
        assert gap.limit == limit


def test_a_chamber_without_a_range_is_at_its_limit(mannequin, make_target):
    """Limits that leave one pressure leave no doubt of it, and the chamber is named."""
    low, high = np.zeros(9), np.full(9, 60.0)
    low[5] = high[5] = 30.0
    found = Solver(mannequin, low, high).solve(make_target(mannequin, TRUTH))
    assert found.limited == ("c6",)
    assert found.sd_kpa[5] == 0.0
    assert (np.delete(found.sd_kpa, 5) > 0.0).all()


def test_what_is_not_there_is_an_error(solver, mannequin, make_target):
    """A target held far away from the surface, and limits that contradict, are errors in one line."""
    target = make_target(mannequin, TRUTH)
    uv, triangles = grid(5, 5)
    flake = Mesh(np.stack([uv[:, 0], np.zeros(25), uv[:, 1]], axis=1), triangles)
    with pytest.raises(LabrigError) as error:
        solver.solve(flake, Pose(np.eye(3), np.array([3000.0, 0.0, 0.0])))
    expected = "the target lies nowhere opposite the surface: is it the right one, and its unit right?"
    assert str(error.value) == expected
    with pytest.raises(LabrigError) as error:
        Solver(mannequin, low_kpa=np.full(9, 70.0)).solve(target)
    assert str(error.value) == "chamber c1: the rig's limits and the model's have nothing in common"
    with pytest.raises(LabrigError) as error:
        Solver(mannequin, high_kpa=np.full(3, 60.0))
    assert (
        str(error.value)
        == "limits of 3 chambers are given, the model's are c1, c2, c3, c4, c5, c6, c7, c8, c9"
    )


def test_plain_values(solver, mannequin, make_target):
    """A result becomes JSON without NaN."""
    import json

    values = solver.solve(make_target(mannequin, TRUTH)).to_dict()
    assert list(values["pressure_kpa"]) == [f"c{c + 1}" for c in range(9)]
    assert json.loads(json.dumps(values, allow_nan=False)) == values
