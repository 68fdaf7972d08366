"""Shape, asked as its page asks: what can be chosen, the search as a job, what it found, files that are sent."""

import os
import re
from pathlib import Path
from typing import Any

import numpy as np
import pytest
import yaml

from tests.shapes import CHAMBERS, FAR, NEAR, simulated, write_lab, write_target
from tests.waiting import wait_for
from tests.workbench.conftest import Asker, served

FIND = {"target": "bodies/far.ply", "model": "model.yaml", "rig": "", "unit": ""}


@pytest.fixture(scope="module")
def bench(tmp_path_factory):
    """A workbench of two targets, a model, and what is neither; not opened for a rig."""
    place = tmp_path_factory.mktemp("shape")
    folder = write_lab(place / "lab")
    (folder / "line.yaml").write_text("base: {kind: static, degree: 1}\n", encoding="utf-8")
    (folder / "lost.yaml").write_text("base: {kind: surrogate, file: gone.pt}\n", encoding="utf-8")
    (folder / "run").mkdir()
    (folder / "run" / "run.yaml").write_text("procedure: capture\n", encoding="utf-8")
    (folder / "-o").mkdir()
    for hidden in ("run/scan.ply", ".hidden.ply", "-o.ply", "-o/body.ply"):
        (folder / hidden).write_bytes(b"ply\n")
    with served(folder) as running:
        yield running


@pytest.fixture(scope="module")
def solved(bench):
    """The name of what was found for the target that is out of reach, and how that stands."""
    ask = Asker(bench)
    status, begun = ask("/api/shape/find", {**FIND, "rig": "rig.yaml", "out": "shapes/far"})
    assert status == 202, begun
    assert begun["command"] == ("labrig ik bodies/far.ply --model model.yaml --rig rig.yaml --out shapes/far")
    wait_for(lambda: ask("/api/shape/found?name=shapes/far")[1]["state"] != "running", "it goes on", 120.0)
    return "shapes/far", ask("/api/shape/found?name=shapes/far")[1]


def test_what_can_be_chosen(ask):
    """Targets of the folder and its sub-folders, but no scans of runs; models with a surface, and why one is not."""
    offered = ask("/api/shape")[1]
    assert offered["targets"] == ["near.ply", "bodies/far.ply"]
    assert [model["name"] for model in offered["models"]] == ["lost.yaml", "model.yaml"]
    assert offered["models"][0]["why"] == "lost.yaml names gone.pt, which is not there"
    assert (offered["rigs"], offered["rig"], offered["lacks"]) == (["rig.yaml"], "", "")


def test_the_limits_are_those_of_the_rig_that_is_chosen(ask, bench):
    """A rig's own limits are told beside the model's; a rig of other chambers is refused in one line."""
    own = simulated(high_kpa=40.0)
    (bench.desk.folder / "lower.yaml").write_text(yaml.safe_dump(own), encoding="utf-8")
    own["chambers"] = own["chambers"][:2]
    (bench.desk.folder / "few.yaml").write_text(yaml.safe_dump(own), encoding="utf-8")
    try:
        model, lower, few = (
            ask(f"/api/shape/limits?model=model.yaml&target=near.ply&rig={rig}")
            for rig in ("", "lower.yaml", "few.yaml")
        )
    finally:
        for name in ("lower.yaml", "few.yaml"):
            (bench.desk.folder / name).unlink()
    assert model[1] == {"chambers": [[name, 0, 60] for name in CHAMBERS], "out": "shapes/near"}
    assert lower[1]["chambers"] == [[name, 0, 40] for name in CHAMBERS]
    assert few == (
        400,
        {
            "error": f"few.yaml: its chambers (c1, c2) are not the model's ({', '.join(CHAMBERS)}); choose another "
            "model, or its own limits"
        },
    )


def test_what_is_found_is_what_the_command_says(solved, ask):
    """The numbers are those that `labrig ik` printed; pressures keep to the limits, and those at one are named."""
    name, told = solved
    found = told["found"]
    pressure = np.array([found["pressure_kpa"][chamber] for chamber in CHAMBERS])
    assert (pressure <= 60.0).all()
    np.testing.assert_allclose(pressure[:4], FAR[:4], atol=8.0)
    assert {"c8", "c9"} <= set(found["at_limit"]) <= set(CHAMBERS[4:])
    assert found["limits_kpa"]["c1"] == [0.0, 60.0]
    printed = ask(f"/api/jobs/{told['job']}")[1]["output"]
    cells = [cell.strip() for cell in re.split("[│┃]", printed[printed.index("far.ply") :].splitlines()[0])]
    assert cells[1:4] == [f"{found['measured_mm'][key]:.2f}" for key in ("mean", "p95", "max")]
    assert cells[4] == f"{found['measured_mm']['share']:.0%}"
    assert any(gap["words"] in printed for gap in found["gaps"])
    assert (told["state"], told["changed"], told["file"]) == ("done", "", f"{name}/ik.json")
    assert {row["name"]: row["mean_mm"] for row in ask("/api/shape")[1]["found"]} == {
        name: found["measured_mm"]["mean"]
    }


def test_target_and_surface_are_drawn_alike(solved, ask):
    """Both figures show the same part of space from the same side; the surface has its distances as colours."""
    drawn = ask(f"/api/shape/picture?name={solved[0]}")[1]
    scenes = [drawn[which]["layout"]["scene"] for which in ("target", "surface")]
    assert scenes[0] == scenes[1]
    values = [value for trace in drawn["surface"]["data"] for value in trace.get("customdata", [])]
    assert np.abs(values).mean() == pytest.approx(solved[1]["found"]["measured_mm"]["mean"], abs=0.02)
    assert len(drawn["target"]["data"][0]["x"]) == 31 * 41


def test_the_report_is_kept_apart(solved, ask):
    """It is served in a sandbox; another file of the folder is not served as one."""
    assert ask(f"/reports/{solved[1]['report']}")[0] == 200
    assert ask.headers["content-security-policy"].startswith("sandbox allow-scripts;")
    assert ask("/reports/shapes/far/ik.json")[0] == 400


@pytest.mark.parametrize("name", ["bodies/far.ply", "model.yaml", "rig.yaml"])
def test_what_was_changed_since_is_said(solved, ask, bench, name):
    """Pressures of another target, model or rig of the model than there is now are not shown without a word."""
    path = bench.desk.folder / name
    before = path.stat().st_mtime_ns
    os.utime(path, ns=(before, before + 10**12))
    try:
        assert ask(f"/api/shape/found?name={solved[0]}")[1]["changed"] == f"{name} was changed since"
    finally:
        os.utime(path, ns=(before, before))


def test_a_target_that_cannot_be_read_is_told_by_the_search(ask, bench):
    """The search fails with the line that the command prints, and leaves no pressures."""
    (bench.desk.folder / "broken.ply").write_bytes(b"ply\n")
    try:
        status, begun = ask("/api/shape/find", {**FIND, "target": "broken.ply", "out": "shapes/broken"})
        assert status == 202, begun
        wait_for(lambda: ask("/api/shape/found?name=shapes/broken")[1]["state"] != "running", "", 120.0)
    finally:
        (bench.desk.folder / "broken.ply").unlink()
    told = ask("/api/shape/found?name=shapes/broken")[1]
    assert (told["state"], told["why"]) == ("failed", "broken.ply has no complete PLY header")
    assert told["found"] is None


def test_two_searches_do_not_share_a_folder(ask, bench):
    """While one goes on, whose folder is not there yet, another has another name and is refused its own."""
    asked = {**FIND, "target": "near.ply", "out": "shapes/near"}
    status, begun = ask("/api/shape/find", asked)
    assert status == 202, begun
    assert ask("/api/shape/limits?model=model.yaml&target=near.ply")[1]["out"] == "shapes/near-2"
    assert ask("/api/shape/find", {**asked, "unit": "mm"}) == (
        400,
        {"error": "shapes/near: choose the name of a new folder"},
    )
    bench.desk.jobs.cancel(bench.desk.jobs.get(begun["job"]), harder=True)
    wait_for(lambda: ask("/api/shape/found?name=shapes/near")[1]["state"] == "cancelled", "it goes on")


@pytest.mark.parametrize(
    ("changes", "said"),
    [
        ({"target": ""}, "choose a target"),
        ({"target": "../other.ply"}, "../other.ply: is not there any more; choose a target of the list"),
        ({"target": "run/scan.ply"}, "run/scan.ply: is not there any more; choose a target of the list"),
        ({"model": "line.yaml"}, "line.yaml: is not there any more; choose a model of the list"),
        ({"model": "lost.yaml"}, "lost.yaml names gone.pt, which is not there; choose another model"),
        ({"unit": "feet"}, "unit 'feet': choose one of mm, cm, m, inch"),
        ({"out": "bodies"}, "bodies: choose the name of a new folder"),
        ({"out": ""}, "a name: choose the name of a new folder"),
        ({"out": "../out"}, "../out: lies outside the workbench's folder"),
    ],
)
def test_what_is_wrong_is_said_in_one_line(ask, bench, changes, said):
    """And no search begins."""
    before = len(bench.desk.jobs.all())
    status, answer = ask("/api/shape/find", {**FIND, "out": "shapes/new", **changes})
    assert status == 400
    assert answer["error"].startswith(said)
    assert len(bench.desk.jobs.all()) == before


def test_without_open3d_the_page_says_what_to_type(ask, monkeypatch):
    """Before anything is chosen, and once more to who asks for a search all the same."""
    monkeypatch.setattr("labrig._extras.find_spec", lambda name: None)
    offered = ask("/api/shape")[1]
    assert offered["lacks"].endswith("type: pip install '.[scan]'")
    assert offered["lacks_training"].endswith("type: pip install '.[learn]'")
    assert ask("/api/shape/find", {**FIND, "out": "shapes/new"}) == (400, {"error": offered["lacks"]})


def test_a_target_is_sent(ask, bench):
    """It is kept under a name that is free and can be chosen; what it holds is said."""
    data = (bench.desk.folder / "near.ply").read_bytes()
    names = []
    for _ in range(2):
        status, given = ask("/api/shape/target?name=my%20body.PLY", data)
        assert status == 200, given
        assert re.fullmatch(r"2400 triangles, \d+ mm across", given["about"])
        names.append(given["target"])
    assert names == ["targets/my-body.ply", "targets/my-body-2.ply"]
    assert set(names) <= set(ask("/api/shape")[1]["targets"])
    assert (bench.desk.folder / names[0]).read_bytes() == data
    for name in names:
        (bench.desk.folder / name).unlink()


@pytest.mark.parametrize(
    ("name", "said"),
    [
        ("half.ply", "half.ply has no complete PLY header"),
        ("body.step", "body.step: a target is a mesh (OBJ, PLY, STL) or points (XYZ)"),
    ],
)
def test_what_is_no_target_is_refused(ask, bench, name, said):
    """In one line, and it is not kept."""
    status, answer = ask(f"/api/shape/target?name={name}", b"ply\n")
    assert (status, answer["error"]) == (400, said)
    assert not list(bench.desk.folder.rglob(name))


def test_the_simulator_of_a_rig_becomes_a_model(ask, bench):
    """Who has trained none begins with that; it has the rig's chambers, and is not written over."""
    assert ask("/api/shape")[1]["simulators"] == ["rig.yaml"]
    assert ask("/api/shape/simulator", {"rig": "rig.yaml"})[1] == {"model": "rig-simulator.yaml"}
    assert ask("/api/shape")[1]["simulators"] == []
    chambers = ask("/api/shape/limits?model=rig-simulator.yaml")[1]["chambers"]
    assert [name for name, _, _ in chambers] == CHAMBERS
    assert ask("/api/shape/simulator", {"rig": "rig.yaml"})[0] == 400
    (bench.desk.folder / "rig-simulator.yaml").unlink()


def test_files_beside_a_rig_elsewhere_can_be_chosen(tmp_path: Path) -> None:
    """Of all files outside the folder these alone: a target and a model that lie with the rig's file."""
    elsewhere = write_lab(tmp_path / "elsewhere")
    write_target(tmp_path / "other.ply", NEAR)
    (tmp_path / "lab").mkdir()
    with served(tmp_path / "lab", elsewhere / "rig.yaml") as running:
        ask: Any = Asker(running)
        offered = ask("/api/shape")[1]
        target, model = str(elsewhere / "near.ply"), str(elsewhere / "model.yaml")
        assert offered["targets"] == [target]
        assert [each["name"] for each in offered["models"]] == [model]
        assert offered["rig"] == str(elsewhere / "rig.yaml")
        status, answer = ask(
            "/api/shape/find", {**FIND, "target": str(tmp_path / "other.ply"), "model": model}
        )
        assert (status, "is not there any more" in answer["error"]) == (400, True)
        told = ask(f"/api/shape/limits?model={model}&rig={offered['rig']}")[1]
        assert len(told["chambers"]) == 9
