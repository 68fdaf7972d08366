"""Which models are offered for a run: those of its rig."""

import shutil
from pathlib import Path
from typing import Any

import pytest
import yaml

from labrig.workbench import open_desk
from labrig.workbench._fits import Names, misfit
from labrig.workbench._models import models_of, near_models
from labrig.workbench._run import pair_of

CREEP = """
base: {kind: static, degree: 1}
effects:
- name: creep
  fitted_on: {chambers: [%s], low: [0.0], high: [2.4]}
"""
RUN = Names(("c1", "c2"), ("m0",), ("m0.x", "m0.y", "m0.z"))


def _model(folder: Path, text: str, name: str = "model.yaml") -> Path:
    path = folder / name
    path.write_text(text, encoding="utf-8")
    return path


def test_a_model_of_other_chambers_is_not_offered(bench: Any, make_run: Any) -> None:
    """A model whose effects were fitted to other chambers is not in a run's list; the one of its own rig is."""
    run = make_run(captures=4)
    folder = bench.desk.folder
    _model(folder, CREEP % "Solldruck", "a.yaml")
    own = folder / "model.yaml"
    assert models_of(bench.desk, folder / run) == [own]


def test_where_none_fits_a_line_is_offered(ask: Any, bench: Any, make_run: Any) -> None:
    """With models of other rigs alone a run has no model, and so the page offers to begin with a straight line."""
    run = make_run(captures=4)
    _model(bench.desk.folder, CREEP % "Solldruck")
    found = ask(f"/api/run?run={run}")[1]
    assert found["models"] == []
    assert found["model"] == ""


def test_a_line_that_was_made_for_another_rigs_run_is_not_offered(bench: Any, make_run: Any) -> None:
    """What the workbench made for a run of other chambers says so by its name; of the same chambers it is offered."""
    run, other = make_run("one", captures=4), make_run("two", captures=4)
    folder = bench.desk.folder
    (folder / "model.yaml").unlink()
    line = _model(folder, "base: {kind: static, degree: 1}\n", "two-model.yaml")
    assert models_of(bench.desk, folder / run) == [line]
    about = (folder / other / "run.yaml").read_text(encoding="utf-8")
    (folder / other / "run.yaml").write_text(about.replace("name: c1", "name: p9"), encoding="utf-8")
    assert models_of(bench.desk, folder / run) == []


@pytest.mark.parametrize(
    ("text", "why"),
    [
        ("base: {kind: static, degree: 1\neffects: []\n", "a.yaml, line 2: is not YAML"),
        ("base: static\n", "a.yaml does not say which kind of base it has"),
        ("base: {degree: 1}\n", "a.yaml does not say which kind of base it has"),
        ("base: {kind: python, file: gone.py}\n", "a.yaml names gone.py, which is not there"),
    ],
)
def test_a_model_that_cannot_be_read_is_named_with_why(
    ask: Any, bench: Any, make_run: Any, text: str, why: str
) -> None:
    """It is none that is offered, though it is the nearest, and the page has the words that say what is wrong."""
    run = make_run(captures=4)
    _model(bench.desk.folder, text, "a.yaml")
    found = ask(f"/api/run?run={run}")[1]
    assert (found["models"], found["model"]) == (["model.yaml"], "model.yaml")
    assert found["unread"]["a.yaml"].startswith(why)


@pytest.mark.parametrize(
    ("text", "why"),
    [
        ("base: {kind: static, degree: 1}\n", ""),
        ("base: {kind: python, file: mine.py}\n", ""),
        (CREEP % "c3", "model.yaml is for chamber c3; the rig has chambers c1, c2"),
        (
            "base: {kind: simulator, rig: rig.yaml}\n",
            "model.yaml is for chambers a, b; the rig has chambers c1, c2",
        ),
        ("base: {kind: fmu, file: x.fmu, inputs: {a: u}, outputs: {}}\n", "is for chamber a"),
        (
            "base: {kind: static, degree: 1}\neffects:\n- {name: tilt, parameters: {at: {value: [1.0], per: [k.x]}}}\n",
            "model.yaml is for observable k.x, which the rig does not have",
        ),
        ("base: {kind: nonsense}\n", ""),
    ],
)
def test_what_a_file_says_is_held_against_the_run(tmp_path: Path, text: str, why: str) -> None:
    """Chambers and observables by name, of effects, of a simulator's rig, of another tool's inputs; else nothing."""
    rig = {"name": "other", "chambers": [{"name": "a"}, {"name": "b"}]}
    (tmp_path / "rig.yaml").write_text(yaml.safe_dump(rig), encoding="utf-8")
    found = misfit(_model(tmp_path, text), RUN)
    assert why in found
    assert bool(found) == bool(why)


def test_the_model_that_a_run_was_planned_for_is_first(bench: Any, make_run: Any, tmp_path: Path) -> None:
    """A run of the set-points of RUN/MODEL/next.yaml is offered that model, wherever it lies, before all others."""
    run, folder = make_run("runs-of-today", captures=4), bench.desk.folder
    points = [{"pressure_kpa": {"c1": 10.0}, "hold_s": 4.0, "label": "steps"}, {"pressure_kpa": {}}]
    results = folder / "demo" / "run" / "simulated"
    results.mkdir(parents=True)
    content = {"procedure": "programme", "points": points}
    (results / "next.yaml").write_text(yaml.safe_dump(content), encoding="utf-8")
    planned = _model(folder / "demo", "base: {kind: static, degree: 1}\n", "simulated.yaml")
    beside = _model(folder / "demo", "base: {kind: static, degree: 2}\n", "other.yaml")
    assert models_of(bench.desk, folder / run) == [folder / "model.yaml"]
    full = [{"settle_s": 1.0, "hold_s": 4.0, "label": "", **point} for point in points]
    about = yaml.safe_load((folder / run / "run.yaml").read_text(encoding="utf-8"))
    about |= {"procedure": "programme", "parameters": {"points": full}}
    (folder / run / "run.yaml").write_text(yaml.safe_dump(about), encoding="utf-8")
    assert models_of(bench.desk, folder / run) == [planned, folder / "model.yaml", beside]
    shutil.rmtree(results)
    assert models_of(bench.desk, folder / run) == [folder / "model.yaml"]


def test_models_of_other_folders_are_offered_where_they_fit(ask: Any, bench: Any, make_run: Any) -> None:
    """What an investigation left in a folder of its own can be chosen, after those near the run, and is not begun with;
    one that names no chambers, one of other chambers, and what lies in a run or deeper are not in the list.
    """
    run, folder = make_run(captures=4), bench.desk.folder
    for place, chambers in (("inv1", "c1, c2"), ("a/b", "c1, c2"), ("other", "p9"), ("a/b/c", "c1, c2")):
        (folder / place).mkdir(parents=True, exist_ok=True)
        _model(folder / place, CREEP % chambers, "model.new.yaml")
    _model(folder / "other", "base: {kind: static, degree: 1}\n", "line.yaml")
    other = folder / make_run("other-run", captures=4)
    (other / "model").mkdir()
    _model(other / "model", CREEP % "c1, c2")
    found = ask(f"/api/run?run={run}")[1]
    assert found["models"] == ["model.yaml", "a/b/model.new.yaml", "inv1/model.new.yaml"]
    (folder / "model.yaml").unlink()
    found = ask(f"/api/run?run={run}")[1]
    assert (found["models"], found["model"]) == (["a/b/model.new.yaml", "inv1/model.new.yaml"], "")


def test_results_of_two_models_of_one_name_lie_apart(bench: Any, make_run: Any) -> None:
    """A model of another folder has its results in a folder with that one's name; the near one keeps its own."""
    run, folder = make_run(captures=4), bench.desk.folder
    (folder / "demo").mkdir()
    _model(folder / "demo", CREEP % "c1, c2")
    near, far = ({"run": run, "model": name} for name in ("model.yaml", "demo/model.yaml"))
    assert pair_of(bench.desk, near).results == folder / run / "model"
    assert pair_of(bench.desk, far).results == folder / run / "demo-model"


def test_models_beside_the_rig_file_are_offered(tmp_path: Path) -> None:
    """A rig whose file lies in a folder below has its models there: the first is begun with, also before any run."""
    demo = tmp_path / "demo"
    demo.mkdir()
    rig = {"name": "r", "chambers": [{"name": c, "max_kpa": 60} for c in ("c1", "c2")]}
    rig |= {"pressure": {"kind": "simulated"}, "simulated": {"surface": "membrane"}}
    (demo / "rig.yaml").write_text(yaml.safe_dump(rig), encoding="utf-8")
    own = _model(demo, "base: {kind: python, file: mine.py}\n", "mine-own.yaml")
    (demo / "mine.py").touch()
    run = tmp_path / "run"
    run.mkdir()
    (run / "run.yaml").write_text(yaml.safe_dump({"rig": rig | {"markers": ["m0"]}}), encoding="utf-8")
    desk = open_desk(tmp_path, demo / "rig.yaml")
    assert near_models(desk, run) == models_of(desk, tmp_path / "none") == [own]
    about = (run / "run.yaml").read_text(encoding="utf-8")
    (run / "run.yaml").write_text(about.replace("name: c1", "name: p9"), encoding="utf-8")
    assert models_of(desk, run) == []
