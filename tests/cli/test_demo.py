"""`labrig demo`: from a rig that hides something to its name, with everything that it leaves; the tutorial goes on."""

import io
import json
import shutil
import subprocess
import sys

import pytest
import yaml

from labrig import open_run
from labrig.effects import rows_of
from labrig.model import Model, read_model_file
from labrig.model._simulator import SimulatorModel
from tests.pages import follow

FIRST = "labrig demo --hide creep --seed 3 --out lab"
"""The tutorial's first command."""
CAMPAIGN = "labrig run capture --rig rig.yaml --captures 40 --seed 1 --out by-hand"
"""The first one by hand: as many captures of the same rig as the demo's."""
EVERYTHING = {
    "rig.yaml", "model.yaml", "sealed.json", "run", "compare.json", "diagnosis.json", "report.html", "demo.rrd",
}  # fmt: skip


def labrig_in(folder, *arguments):
    """Run a command in `folder`."""
    command = [sys.executable, "-c", "from labrig.cli import main; main()", *arguments]
    return subprocess.run(command, cwd=folder, capture_output=True, text=True, timeout=560, check=False)


@pytest.fixture(scope="module")
def demo(tmp_path_factory):
    """The demo that the tutorial begins with, where creep is hidden, and what it printed."""
    folder = tmp_path_factory.mktemp("demo")
    return folder, labrig_in(folder, *FIRST.split()[1:])


@pytest.mark.slow
def test_it_names_what_is_hidden(demo):
    """The hidden effect is named, the error falls towards the floor, and the model with it is written."""
    folder, ran = demo
    assert ran.returncode == 0, ran.stderr
    found = json.loads((folder / "lab" / "diagnosis.json").read_text())
    assert (found["verdict"], found["effects"]) == ("identified", ["creep"])
    assert found["error"]["model"] < 0.3 * found["error"]["base"]
    improved = yaml.safe_load((folder / "lab" / "model.improved.yaml").read_text())
    assert [effect["name"] for effect in improved["effects"]] == ["creep"]
    assert "Creep is missing from the model." in ran.stdout


@pytest.mark.slow
def test_it_leaves_everything(demo):
    """Run, rig, models, figures, report and recording are there, and nothing half-written."""
    folder, _ = demo
    assert {entry.name for entry in (folder / "lab").iterdir()} == EVERYTHING | {"model.improved.yaml"}


@pytest.mark.slow
def test_its_last_lines_work(demo):
    """The commands that it names at the end do what it says, in a shell, as they stand."""
    folder, ran = demo
    lines = [line.strip() for line in ran.stdout.splitlines()]
    first = next(number for number, line in enumerate(lines) if line.startswith("Done in "))
    report, view, reveal = lines[first + 1 : first + 4]
    assert report == str((folder / "lab" / "report.html").resolve())
    shell = {"cwd": folder, "shell": True, "capture_output": True, "text": True, "timeout": 60}
    assert subprocess.run(f"{view} --save saved.rrd", **shell, check=False).returncode == 0
    assert (folder / "saved.rrd").read_bytes() == (folder / "lab" / "demo.rrd").read_bytes()
    assert (
        subprocess.run(reveal, **shell, check=False).stdout
        == "creep: 1 mm rms over random set-points of the whole range; at others it is more or less\n"
    )


@pytest.mark.slow
def test_the_tutorial(demo, labrig, tmp_path, monkeypatch, few_effects):
    """Each command of the tutorial does what the page says that it does.

    Its first campaign is that of the demo, whose shapes are solved already, and which named creep among all effects.
    """
    few_effects("creep", "leak")
    folder, ran = demo
    shutil.copytree(folder / "lab", tmp_path / "lab")
    shutil.copytree(folder / "lab" / "run", tmp_path / "lab" / "by-hand")
    monkeypatch.chdir(tmp_path)
    done = {FIRST: ran.stdout, CAMPAIGN: ""}
    printed = follow("tutorial-hidden-effect.md", labrig, monkeypatch, done=done)
    assert CAMPAIGN in printed
    assert "identified: creep" in printed[FIRST]
    said = printed["labrig diagnose by-hand --model model.yaml"]
    assert said.startswith("verdict: identified (one effect is missing)\ncreep, sure (")
    assert (
        printed["labrig reveal by-hand"]
        == "creep: 1 mm rms over random set-points of the whole range; at others it is more or less\n"
    )
    after = printed["labrig diagnose fresh --model better.yaml --out diagnosis-after"]
    assert after.startswith("verdict: nothing_missing")
    assert [e.name for e in read_model_file(tmp_path / "lab" / "better.yaml").effects] == ["creep"]


@pytest.mark.slow
def test_nothing_is_nothing(labrig, tmp_path, monkeypatch):
    """A rig that hides nothing ends in nothing_missing, the model stays as it is, and an older demo too.

    Its run gives the moduli that the demo's model was calibrated to. Ten captures say so as forty do, and sooner.
    """
    monkeypatch.chdir(tmp_path)
    monkeypatch.setattr("labrig.cli._demo_steps.CAPTURES", 10)
    (tmp_path / "labrig-demo").mkdir()
    (tmp_path / "labrig-demo" / "mine.txt").write_text("keep")
    code, out, err = labrig("demo", "--hide", "nothing", "--seed", "3")
    assert (code, err) == (0, "")
    assert [entry.name for entry in (tmp_path / "labrig-demo").iterdir()] == ["mine.txt"]
    folder = tmp_path / "labrig-demo-2"
    assert json.loads((folder / "diagnosis.json").read_text())["verdict"] == "nothing_missing"
    assert {entry.name for entry in folder.iterdir()} == EVERYTHING
    assert "nothing is added: the model stays as it is" in out
    believed = yaml.safe_load((folder / "model.yaml").read_text())["base"]["parameters"]
    fresh = "base: {kind: simulator, rig: rig.yaml, calibrated: [modulus_1_kpa, modulus_2_kpa]}\n"
    (folder / "fresh.yaml").write_text(fresh)
    fitted = Model.load(folder / "fresh.yaml").predictor(rows_of(open_run(folder / "run"))).base
    assert isinstance(fitted, SimulatorModel)
    assert fitted.values == pytest.approx(believed, rel=0.01)


def test_an_unknown_effect(tmp_path):
    """A name that does not exist is one line with those that do, and nothing is made."""
    ran = labrig_in(tmp_path, "demo", "--hide", "gremlins")
    assert ran.returncode == 2
    assert ran.stdout == ""
    assert ran.stderr.startswith(
        "labrig: --hide: there is no effect 'gremlins'; choose nothing, hysteresis, creep,"
    )
    assert ran.stderr.count("\n") == 1
    assert list(tmp_path.iterdir()) == []


def test_a_folder_that_cannot_be_made(tmp_path):
    """Where the folder cannot be made, one line says so."""
    (tmp_path / "file").write_text("")
    ran = labrig_in(tmp_path, "demo", "--hide", "creep", "--out", "file/here")
    assert (ran.returncode, ran.stderr) == (
        2,
        "labrig: cannot make the folder file/here: Not a directory\n",
    )


def test_the_seed_chooses_and_says_nothing():
    """Without --hide the seed decides, always the same way, and different seeds differ."""
    from labrig.cli._demo_steps import _hidden

    chosen = [_hidden("", seed) for seed in range(12)]
    assert chosen == [_hidden("", seed) for seed in range(12)]
    assert len({json.dumps(setting["effects"]) for setting in chosen}) > 4


def test_its_words_and_its_table_say_one_error(tmp_path, monkeypatch):
    """The error with what was found is the improved model's, in the sentence and in the table, not the diagnosis's."""
    from types import SimpleNamespace

    from rich.console import Console

    import labrig.diagnosis
    import labrig.model
    from labrig.cli._demo_steps import _diagnosis, _waterfall

    error = {"base": 0.9, "model": 0.252, "floor": 0.1}
    added = {"effects": ["creep"], "units": "mm", "error": error, "where": [], "warnings": []}
    found = {**added, "verdict": "identified", "error": {**error, "model": 0.177}, "rivals": ["leak"]}
    found |= {"effects_considered": [], "unnamed": {}, "probability": 0.9}
    result = SimpleNamespace(
        summary=found, waterfall=[("base", 0.9), ("+ leak", 0.177)], write=lambda path: None
    )
    better = SimpleNamespace(summary=added, waterfall=[("base", 0.9), ("+ creep", 0.252)], improved=None)
    compared = SimpleNamespace(summary={**added, "effects": []})
    for name, given in (("compare", compared), ("diagnose", result), ("improve", better)):
        monkeypatch.setattr(labrig.diagnosis, name, lambda *_, given=given: given)
    monkeypatch.setattr(labrig.model.Model, "load", lambda path: None)
    monkeypatch.setattr("labrig.open_run", lambda path: None, raising=False)
    with Console(record=True, width=100, file=io.StringIO()) as console:
        _, final = _diagnosis(console, tmp_path)
        console.print(_waterfall(console, final))
    printed = console.export_text().replace("\u00a0", " ")
    assert "falls from 0.9 mm to 0.252 mm" in printed
    assert "0.252" in printed.splitlines()[-1]
    assert "0.177" not in printed
