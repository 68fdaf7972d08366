"""labrig ik: a table, JSON, a report, and errors for people; the torso and the bodies that come with labrig."""

import json
from dataclasses import replace
from pathlib import Path

import numpy as np
import pytest
import typer
import yaml

import labrig
from labrig import LabrigError
from labrig._executor import Executor
from labrig.api._as_file import as_file
from labrig.campaign._scans import keep_scan
from labrig.cli._ik import ik
from labrig.ik import load_shape_model, solve_files
from labrig.ik._load import state_of
from labrig.physics import load_shell
from labrig.surface import distances, grid, read_mesh
from labrig.view._ik_report import ik_page
from labrig_drivers import Scan
from labrig_drivers.simulated._artec_twin import ply_bytes

BODIES = sorted((Path(__file__).parents[2] / "examples" / "bodies").glob("*.ply"))
PRESSURES = {"a.ply": np.linspace(10, 50, 9), "b.ply": np.full(9, 25.0)}


@pytest.fixture
def desk(tmp_path, mannequin, monkeypatch):
    """A model of the quick surface, two targets that it can be, and a file that is none."""
    chambers = [{"name": f"c{c + 1}", "min_kpa": 0, "max_kpa": 60} for c in range(9)]
    rig = {
        "name": "r",
        "chambers": chambers,
        "pressure": {"kind": "simulated"},
        "simulated": {"surface": "mannequin"},
    }
    (tmp_path / "rig.yaml").write_text(yaml.safe_dump(rig))
    (tmp_path / "model.yaml").write_text(yaml.safe_dump({"base": {"kind": "simulator", "rig": "rig.yaml"}}))
    uv, triangles = grid(31, 41)
    for name, pressure in PRESSURES.items():
        scan = Scan(0.0, mannequin.points(pressure[None], uv)[0], triangles, (), "")
        (tmp_path / keep_scan(scan, tmp_path)[0]).rename(tmp_path / name)
    (tmp_path / "c.ply").write_bytes(b"ply\n")
    monkeypatch.chdir(tmp_path)
    return tmp_path


def ask(*targets, model="model.yaml", rig=None, unit=None):
    ik([Path(target) for target in targets], Path(model), Path("out"), rig, unit, 1, None)


def test_results_for_people_and_for_programs(desk, capsys):
    """The table names every target; ik.json holds pressures that make it; the report is there, whole."""
    ask("a.ply", "b.ply")
    printed = capsys.readouterr().out
    assert "a.ply" in printed
    assert printed.rstrip().endswith("report: out/report.html")
    content = json.loads((desk / "out" / "ik.json").read_text())
    assert content["model"] == "model.yaml"
    for entry in content["targets"]:
        found = list(entry["pressure_kpa"].values())
        np.testing.assert_allclose(found, PRESSURES[entry["target"]], atol=0.5)
        assert entry["measured_mm"]["mean"] < 0.25
    html = (desk / "out" / "report.html").read_text()
    assert html.count('<div class="drawn"') == 4
    assert sorted(path.name for path in (desk / "out").iterdir()) == ["ik.json", "report.html"]


def test_one_bad_target_spoils_nothing(desk, capsys):
    """The others are solved and written; the bad one is said, and the exit code is not 0."""
    with pytest.raises(typer.Exit) as ended:
        ask("a.ply", "c.ply")
    assert ended.value.exit_code == 2
    assert capsys.readouterr().err.splitlines()[-1] == "labrig: c.ply has no complete PLY header"
    assert (
        json.loads((desk / "out" / "ik.json").read_text())["targets"][1]["error"]
        == "c.ply has no complete PLY header"
    )


def test_a_target_that_lies_elsewhere_is_named(desk, capsys):
    """Among several nobody knows otherwise which one is meant."""
    mesh = read_mesh(desk / "a.ply")
    small = Scan(0.0, 0.1 * mesh.vertices_mm, mesh.triangles, (), "")
    (desk / keep_scan(small, desk)[0]).rename(desk / "small.ply")
    with pytest.raises(typer.Exit):
        ask("a.ply", "small.ply", unit="mm")
    said = capsys.readouterr().err.splitlines()[-1]
    assert said.startswith("labrig: small.ply: the target lies opposite ")
    assert said.endswith("; read as cm (--unit cm) it would be about as large")


def test_errors_for_people(desk):
    """No target of use, no model of use, a rig of other chambers: one line each, nothing written."""
    with pytest.raises(LabrigError) as error:
        ask("c.ply")
    assert str(error.value) == "c.ply has no complete PLY header"
    (desk / "static.yaml").write_text("base: {kind: static, degree: 1}\n")
    with pytest.raises(LabrigError) as error:
        ask("a.ply", model="static.yaml")
    expected = (
        "static.yaml: a base of kind static predicts markers, no surface: use a simulator or a surrogate"
    )
    assert str(error.value) == expected
    other = yaml.safe_load((desk / "rig.yaml").read_text())
    other["chambers"] = other["chambers"][:2]
    other["simulated"] = {"surface": "membrane"}
    (desk / "other.yaml").write_text(yaml.safe_dump(other))
    with pytest.raises(LabrigError) as error:
        ask("a.ply", rig=Path("other.yaml"))
    names = ", ".join(f"c{c + 1}" for c in range(9))
    assert str(error.value) == f"other.yaml: its chambers (c1, c2) are not the model's ({names})"
    assert not (desk / "out").exists()


def test_what_was_guessed_and_cleaned_is_said(desk, capsys):
    """A target in metres, with a loose bit, is solved as the one in mm, and two lines say what was done to it."""
    target = read_mesh("a.ply", "mm")
    bit = target.vertices_mm.max(axis=0) + np.array([[50.0, 0, 0], [55, 0, 0], [50, 5, 0]])
    points = np.concatenate([target.vertices_mm, bit])
    triangles = np.concatenate([target.triangles, [[len(points) - 3, len(points) - 2, len(points) - 1]]])
    Path("metres.ply").write_bytes(ply_bytes(0.001 * points, triangles))
    ask("metres.ply")
    (entry,) = json.loads((desk / "out" / "ik.json").read_text())["targets"]
    np.testing.assert_allclose(list(entry["pressure_kpa"].values()), PRESSURES["a.ply"], atol=0.5)
    assert entry["notes"][0].endswith("does not say its unit: taken for m")
    assert entry["notes"][1] == "loose fragments dropped: 1"
    assert "loose fragments dropped: 1" in capsys.readouterr().out


def test_limits_of_a_rig(desk):
    """With --rig no pressure is above the rig's own limit."""
    rig = yaml.safe_load((desk / "rig.yaml").read_text())
    rig["chambers"][8]["max_kpa"] = 30
    (desk / "weak.yaml").write_text(yaml.safe_dump(rig))
    ask("a.ply", rig=Path("weak.yaml"))
    (entry,) = json.loads((desk / "out" / "ik.json").read_text())["targets"]
    assert entry["pressure_kpa"]["c9"] == 30.0
    assert "c9" in entry["at_limit"]
    assert entry["gaps"][0]["chamber"] == "c9"
    assert "stays inside the target" in (desk / "out" / "report.html").read_text()


def test_a_model_that_remembers_gives_a_path(desk):
    """The path stands beside the pressures, and its end makes up for the play."""
    play = {
        "name": "hysteresis",
        "form": "play",
        "parameters": {"weight": {"value": 0.3}, "width": {"value": 0.1}},
    }
    model = {"base": {"kind": "simulator", "rig": "rig.yaml"}, "effects": [play]}
    (desk / "model.yaml").write_text(yaml.safe_dump(model))
    ask("b.ply")
    (entry,) = json.loads((desk / "out" / "ik.json").read_text())["targets"]
    np.testing.assert_allclose(entry["path"]["setpoints_kpa"][-1], 26.8, atol=0.5)
    assert entry["path"]["name"] == "straight"
    assert entry["measured_mm"]["mean"] < 0.25
    (solved,) = labrig.solve_ik("b.ply", replace(labrig.Model.load("model.yaml"), path=None))
    assert solved.path is not None
    np.testing.assert_allclose(solved.path.setpoints_kpa, entry["path"]["setpoints_kpa"], atol=1e-3)


def test_a_page_of_failures():
    """Nothing but failures makes a page that says so."""
    from labrig.ik import Job, Solved

    html = ik_page([Solved(Job("a.ply", "m.pt"), error="a.ply is empty")], "m.pt").html()
    assert "<h1>No target could be solved</h1>" in html
    assert "a.ply is empty" in html


def test_a_learned_model_is_read(tmp_path, net):
    """forward.pt is a model, and the one that was learnt is such a file; what is none is said by what reads it."""
    from labrig.surrogate import ForwardModel, Measured, Trained, save_forward
    from labrig.surrogate._gaussian import fit_gaussian

    x = np.random.default_rng(3).uniform(0, 1, (30, 4))
    head, _ = fit_gaussian(x, np.array([net.latent(60.0 * row)[0] for row in x]), iterations=2)
    model = ForwardModel(
        net.chamber_names, net.low_kpa, net.high_kpa, net.spline, net.mean_mm, net.modes_mm, head, np.zeros((6, 1)), 1.0
    )  # fmt: skip
    save_forward(model, tmp_path / "forward.pt")
    for given in (model, Trained(model, 0.0, 0.0, Measured({}, *np.zeros((3, 1))))):
        with as_file(given) as path:
            assert path.read_bytes() == (tmp_path / "forward.pt").read_bytes()
        assert not path.exists()
    shape, memory = load_shape_model(tmp_path / "forward.pt")
    assert shape.chamber_names == net.chamber_names
    assert memory is None
    (tmp_path / "broken.pt").write_bytes(b"nothing")
    with pytest.raises(LabrigError):
        load_shape_model(tmp_path / "broken.pt")


def test_a_base_that_is_calibrated_to_each_run_is_refused(tmp_path):
    """Inverse kinematics has no run: it does not take the moduli of the shell's file for the calibrated ones."""
    rig = {"name": "sheet", "chambers": [{"name": f"c{c}", "max_kpa": 60} for c in range(1, 5)]}
    rig |= {"pressure": {"kind": "simulated"}, "simulated": {"shell": "membrane4"}}
    (tmp_path / "rig.yaml").write_text(yaml.safe_dump(rig))
    base = {"kind": "simulator", "rig": "rig.yaml", "calibrated": ["modulus_1_kpa"]}
    (tmp_path / "model.yaml").write_text(yaml.safe_dump({"base": base}))
    with pytest.raises(LabrigError, match=r"modulus_1_kpa is fitted to each run anew.*`parameters`"):
        load_shape_model(tmp_path / "model.yaml")


def test_the_torsos_core_fits_into_the_bodies():
    """The resting torso lies inside every body that comes with labrig, where it lies opposite one."""
    torso = load_shell("torso")
    assert len(torso.chamber_names) == 9
    uv, _ = grid(45, 45)
    core = torso.spline.evaluate(torso.control_rest_mm, uv)
    assert len(BODIES) == 8
    for path in BODIES:
        found = distances(core, read_mesh(path))
        assert found.summary()["share"] > 0.4
        assert np.quantile(found.within, 0.99) < 0.5
        assert np.median(found.within) < -8.0


def test_what_a_model_is_made_of_may_change(desk):
    """In one session a model whose rig was changed is another one, though its own file is as it was."""
    (before,) = solve_files(["a.ply"], "model.yaml")
    rig = yaml.safe_load((desk / "rig.yaml").read_text())
    rig["chambers"][8]["max_kpa"] = 30
    (desk / "rig.yaml").write_text(yaml.safe_dump(rig))
    (now,) = solve_files(["a.ply"], "model.yaml")
    assert before.result.pressure_kpa[8] == pytest.approx(50.0, abs=0.5)
    assert now.result.pressure_kpa[8] == pytest.approx(30.0)


@pytest.mark.parametrize("changed", ["model.yaml", "rig.yaml", "shell.yaml", "core.npz", "effects/own.py"])
def test_the_files_of_a_model_are_known(tmp_path, changed):
    """Base, rig, shell, the shell's points and the user's effects are all part of the state of a model file."""
    (tmp_path / "effects").mkdir()
    (tmp_path / "model.yaml").write_text("base: {kind: simulator, rig: rig.yaml}\n")
    (tmp_path / "rig.yaml").write_text("simulated: {shell: shell.yaml}\nmarkers: [m01]\n")
    (tmp_path / "shell.yaml").write_text("core: {kind: spline, control_points: core.npz}\n")
    (tmp_path / "core.npz").write_bytes(b"")
    (tmp_path / "effects" / "own.py").write_text("")
    before = state_of(tmp_path / "model.yaml")
    assert len(before) == 5
    assert state_of(tmp_path / "model.yaml") == before
    with (tmp_path / changed).open("a") as file:
        file.write("\n")
    assert state_of(tmp_path / "model.yaml") != before


def test_workers_stay_for_the_next_files(desk, monkeypatch):
    """An executor that is handed in is not closed, so that its processes need not start again."""
    closed = []
    monkeypatch.setattr(Executor, "close", lambda self: closed.append(self))
    executor = Executor(1)
    for _ in range(2):
        (solved,) = solve_files(["a.ply"], "model.yaml", executor=executor)
        assert solved.result is not None
    assert not closed
    solve_files(["a.ply"], "model.yaml")
    assert len(closed) == 1
