"""Shells: their files, what they refuse, and what a solve promises."""

import pickle
import re

import numpy as np
import pytest
import yaml

from labrig._errors import LabrigError
from labrig.physics import load_shell, shipped_shells


def test_two_shells_of_different_build_are_shipped():
    """A mannequin of two layers and nine chambers and a flat membrane of one layer and four."""
    assert {"mannequin", "membrane4"} <= set(shipped_shells())
    mannequin, membrane = load_shell("mannequin"), load_shell("membrane4")
    assert mannequin.chamber_names == tuple(f"c{i}" for i in range(1, 10))
    assert [c.name for c in mannequin.file.chambers if c.layer == 2] == ["c4"]
    assert (len(mannequin.file.layers), len(membrane.file.layers)) == (2, 1)
    assert membrane.chamber_names == ("c1", "c2", "c3", "c4")
    np.testing.assert_array_equal(mannequin.max_kpa, 60.0)
    assert mannequin.control_rest_mm.shape == (30, 30, 3)
    assert mannequin.marker_uv.shape == (34, 2)
    assert mannequin.parameters["modulus_1_kpa"].unit == "kPa"


@pytest.mark.parametrize("name", ["mannequin", "membrane4"])
def test_pressure_pushes_outwards_where_the_chamber_is(small, name):
    """Each chamber alone lifts its own middle along the outward normal, and more than anything far from it."""
    shell = small(name, (16, 16))
    vented = shell.solve(0 * shell.max_kpa)
    for k, chamber in enumerate(shell.file.chambers):
        blown = shell.solve(np.eye(len(shell.max_kpa))[k] * shell.max_kpa, vented)
        centre = [[0.5 * sum(chamber.u), 0.5 * sum(chamber.v)]]
        moved = shell.spline.evaluate(blown.control_mm - vented.control_mm, centre)[0]
        by_u, by_v = (shell.spline.evaluate(shell.control_rest_mm, centre, *d)[0] for d in ((1, 0), (0, 1)))
        outward = np.cross(by_v, by_u)
        rise = moved @ outward / np.linalg.norm(outward)
        assert rise > 8.0
        assert rise > 0.7 * np.linalg.norm(blown.control_mm - vented.control_mm, axis=-1).max()


def test_the_energy_falls_all_the_way(small):
    """Along a solve the energy never rises by more than rounding, and ends below where it began."""
    shell = small()
    for pressure in (shell.max_kpa, 0.3 * shell.max_kpa):
        energies = np.array(shell.solve(pressure).energies_mj)
        assert (np.diff(energies) <= 1e-3 * shell._system.rounding).all()
        assert energies[-1] < energies[0]


def test_a_solve_is_deterministic_and_needs_no_luck_with_its_start(small):
    """The same call gives the same bits, and other starts lead to the same shape."""
    shell = small()
    pressure = shell.max_kpa * np.linspace(1.0, 0.2, 9)
    first, again = shell.solve(pressure), shell.solve(pressure)
    assert np.array_equal(first.layers_mm, again.layers_mm)
    warm = shell.solve(pressure, shell.solve(shell.max_kpa))
    assert np.abs(warm.layers_mm - first.layers_mm).max() < 2e-3
    assert first.residual <= 1e-5


def test_layers_do_not_pass_through_each_other(small):
    """Layers and core sink into each other no deeper than 60 kPa press into a contact of 75 kPa/mm."""
    shell = small("mannequin", (20, 20))
    solution = shell.solve([60, 0, 60, 60, 0, 60, 0, 60, 0])
    q = shell.quadrature
    layers = [q.at_points(layer.reshape(-1, 3)) for layer in solution.layers_mm]
    core = q.at_points(q.control_mm)
    for below, above in ((core, layers[0]), layers):
        assert ((above - below) * q.normal).sum(1).min() > -1.25 * 60 / 75


def test_weight_pulls_down(small):
    """With gravity the sheets hang lower than without it."""
    heavy, light = small().changed(gravity_m_per_s2=20.0), small().changed(gravity_m_per_s2=0.0)
    pressure = 0.5 * heavy.max_kpa
    lower = heavy.solve(pressure).control_mm - light.solve(pressure).control_mm
    assert lower[..., 2].mean() < -1e-4


def test_a_core_that_stands_out_moves_the_sheets_out(small):
    """The core offset lifts the vented surface by about as much, away from the border."""
    shell = small()
    none = 0 * shell.max_kpa
    out = shell.changed(core_offset_mm=2.0).solve(none).control_mm - shell.solve(none).control_mm
    assert np.linalg.norm(out[6, 6]) == pytest.approx(2.0, abs=0.4)
    np.testing.assert_array_equal(out[0], 0.0)


def test_creep_grows_and_damage_softens_under_load(small):
    """A positive creep strain lets the surface rise further at the same pressure, and so does damage."""
    shell = small("membrane4")
    pressure = 0.6 * shell.max_kpa
    points = len(shell.quadrature.uv)
    creep = np.zeros((points, 1, 3))
    creep[..., :2] = 0.03
    new, crept, worn = (
        s.solve(pressure).control_mm[..., 1].mean()
        for s in (shell, shell.remembering(creep), shell.remembering(damage=np.full((points, 1), 0.2)))
    )
    assert crept > 1.03 * new
    assert worn > 1.03 * new


def test_a_shell_travels(small):
    """Its content makes the same shell again, through YAML and through pickle."""
    shell = small("membrane4").changed(modulus_1_kpa=333.0, core_offset_mm=0.25)
    pressure = 0.4 * shell.max_kpa
    expected = shell.solve(pressure).control_mm
    for other in (
        load_shell(yaml.safe_load(yaml.safe_dump(shell.content()))),
        pickle.loads(pickle.dumps(shell)),
    ):
        np.testing.assert_array_equal(other.solve(pressure).control_mm, expected)
    assert shell.content()["layers"][0]["modulus"] == "333.0 kPa"


def test_a_core_from_a_file(small, tmp_path):
    """Control points of any count in a file beside the YAML are a core, and are written into its content."""
    plane = small("membrane4")
    np.savez(tmp_path / "core.npz", control_points=plane.changed(count=(9, 8)).control_rest_mm)
    content = {**plane.content(), "core": {"control_points": "core.npz"}}
    (tmp_path / "own.yaml").write_text(yaml.safe_dump(content), encoding="utf-8")
    own = load_shell(tmp_path / "own.yaml")
    np.testing.assert_allclose(own.control_rest_mm, plane.control_rest_mm, atol=1e-9)
    assert own.content()["core"]["kind"] == "spline"
    np.testing.assert_allclose(load_shell(own.content()).control_rest_mm, own.control_rest_mm)


@pytest.mark.parametrize(
    ("size", "said"),
    [
        ("0 mm", "should be greater than 0, not 0.0"),
        (-5, "should be greater than 0, not -5.0"),
        ("nan mm", "should be a finite number, not nan"),
    ],
)
def test_a_core_without_a_size_is_refused(size, said):
    """A body that is not wide is said in its file's words, before anything is solved on it."""
    content = load_shell("membrane4").content()
    with pytest.raises(LabrigError) as caught:
        load_shell({**content, "core": {**content["core"], "width": size}})
    assert str(caught.value) == f"shell: core: width: {said}"


@pytest.mark.parametrize(
    ("pressure", "message"),
    [
        ([1, 2], "shell membrane4: pressures of shape (2,) given, (4,) needed"),
        (
            [1, np.nan, 0, 0],
            "shell membrane4: pressures must be finite and >= 0: c1 1, c2 nan, c3 0, c4 0 kPa",
        ),
        (
            [1, 0, -2, 0],
            "shell membrane4: pressures must be finite and >= 0: c1 1, c2 0, c3 -2, c4 0 kPa",
        ),
    ],
)
def test_pressures_that_make_no_sense_are_refused(small, pressure, message):
    """Wrong shapes, NaN and suction are refused by name."""
    with pytest.raises(LabrigError, match=f"^{re.escape(message)}$"):
        small("membrane4").solve(pressure)


def test_without_an_equilibrium_there_is_no_shape(sheet):
    """A sheet blown far beyond what it can bear is an error that says where, never a shape."""
    weak = sheet(12, modulus=0.5, thickness=0.5, stiffening=1e-3)
    with pytest.raises(
        LabrigError, match=r"^shell sheet: no equilibrium at air 1e\+05 kPa: after \d+ steps the unb"
    ):
        weak.solve([1e5])


def test_starts_of_another_mesh_are_refused(small):
    """A start that does not fit is named as such."""
    solution = small("membrane4").solve([1, 1, 1, 1])
    with pytest.raises(LabrigError, match="is it of another mesh"):
        small("membrane4", (14, 14)).solve([1, 1, 1, 1], solution)


@pytest.mark.parametrize(
    ("change", "message"),
    [
        (
            {"layers": [{"modulus": "3 mm", "thickness": 1}]},
            "layers: entry 1: modulus: unit 'mm' can't be converted to kPa",
        ),
        ({"layers": []}, "layers: should hold 1 or more entries, not 0"),
        ({"core": {"kind": "sphere"}}, "core: kind: there is no 'sphere'; there are '"),
        ({"elastic": 3}, "elastic: there is no such field; there are "),
        ({"chambers": [{"name": "a", "layer": 2, "u": [0, 1], "v": [0, 1]}]}, "chamber a lies under layer 2"),
        ({"chambers": [{"name": "a", "u": [1, 0], "v": [0, 1]}]}, "u and v are ranges, from low to high"),
        ({"control_points": [5, 30]}, "control_points: at least 6 in each direction are needed"),
        ({"markers": {"a": [0.5, 1.5]}}, "marker a lies outside the unit square"),
        (
            {"core": {"control_points": "none.npz"}},
            "core.control_points: none.npz holds no array 'control_points'",
        ),
        ({"adhesion": float("nan")}, "adhesion: should be a finite number, not nan"),
        ({"seam": "soft"}, "seam: 'soft' is not a number with a unit, such as '1 kPa/mm'"),
    ],
)
def test_bad_files_are_one_line(change, message):
    """What is wrong with a shell file is said with the field and the reason."""
    with pytest.raises(LabrigError) as caught:
        load_shell({**load_shell("membrane4").content(), **change})
    assert message in str(caught.value)
    assert "\n" not in str(caught.value)


def test_unknown_names_are_one_line(tmp_path):
    """Parameters, shells and files that do not exist are named, with those that do."""
    with pytest.raises(LabrigError, match="there is no parameter 'colour' \\(it has modulus_1_kpa, "):
        load_shell("membrane4").changed(colour=1.0)
    with pytest.raises(
        LabrigError, match=r"cannot read the shell nobody: .* \(shipped shells: .*mannequin, membrane4"
    ):
        load_shell("nobody")
    (tmp_path / "x.yaml").write_text("- 1", encoding="utf-8")
    with pytest.raises(LabrigError, match="is not a shell: it should begin with `name: "):
        load_shell(tmp_path / "x.yaml")
    with pytest.raises(LabrigError, match="bounds: there is no parameter 'colour'"):
        load_shell({**load_shell("membrane4").content(), "bounds": {"colour": [0, 1]}})


def test_bounds_of_a_parameter_can_be_given_with_units():
    """A file may narrow the bounds of a parameter."""
    shell = load_shell(
        {**load_shell("membrane4").content(), "bounds": {"modulus_1_kpa": ["0.3 MPa", "500 kPa"]}}
    )
    found = shell.parameters["modulus_1_kpa"]
    assert (found.low, found.value, found.high) == (300.0, 400.0, 500.0)
