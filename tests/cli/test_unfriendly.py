"""What a newcomer gets wrong, one command each: a line that helps, and nothing left behind."""

import os
import shutil
from collections.abc import Callable
from pathlib import Path

import pytest

Run = Callable[..., tuple[int, str, str]]

RIG = """\
name: bench
chambers: [{name: c1, max_kpa: 60}, {name: c2, max_kpa: 60}, {name: c3, max_kpa: 60}, {name: c4, max_kpa: 60}]
pressure: {kind: simulated}
mocap: {kind: simulated}
simulated: {surface: membrane}
"""
OWN = """\
name: own
chambers: [{name: c1, max_kpa: 60}]
pressure: {kind: python, file: bench.py, class: Bench}
"""


@pytest.fixture
def desk(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> Path:
    """A folder with a rig, its model, an empty folder and a target that is none."""
    monkeypatch.chdir(tmp_path)
    (tmp_path / "rig.yaml").write_text(RIG)
    (tmp_path / "model.yaml").write_text("base: {kind: simulator, rig: rig.yaml}\n")
    (tmp_path / "own.yaml").write_text(OWN)
    (tmp_path / "empty").mkdir()
    (tmp_path / "target.ply").write_bytes(b"\x89\xff")
    return tmp_path


@pytest.mark.parametrize(
    ("words", "said"),
    [
        (("effects", "show", "crep"), "; did you mean creep?"),
        (("effects", "show"), "Missing argument 'NAME'. (see labrig effects show --help)"),
        (("demo", "--hide", "hysterisis"), "; did you mean hysteresis?"),
        (("run", "--rig", "rig.yaml", "captur"), "; did you mean capture?"),
        (("run", "--rig", "rig.yaml", "capture", "--caputres", "3"), "; did you mean --captures?"),
        (("rig", "replay", "empty"), "empty holds no recording: `labrig rig record` makes one"),
        (
            ("rig", "record", "rig.yaml", "-o", "new"),
            "rig bench: of its devices (simulated) no bytes can be recorded, only of openpneu, modbus, vicon",
        ),
        (
            ("rig", "record", "own.yaml", "-o", "new"),
            "rig own: of its devices (python) no bytes can be recorded, only of openpneu, modbus, vicon",
        ),
        (
            ("investigate", "--rig", "rig.yaml", "--model", "model.yaml", "--budget", "1", "--out", "new"),
            "a budget of 1 min is too little to begin with; give it ",
        ),
        (
            ("compare", "model.yaml", "--model", "empty"),
            "model.yaml is no run: name the run's folder first, then the model",
        ),
        (("ik", "target.ply", "--model", "model.yaml"), "target.ply has no complete PLY header"),
        (("ik", "none.ply", "none.ply", "--model", "model.yaml"), " (and 1 more)"),
        (("validate", "--resume", "none"), "none is no run folder; `labrig runs` lists those in ./runs"),
        (("run", "--seed", "x"), " (see labrig run --help)"),
        (
            ("bench", "learn", "--out", "spectra.json", "--portion", "thrid=180"),
            "bench: --portion thrid=180: NAME=N, where NAME is one of third, ",
        ),
    ],
    ids=lambda value: " ".join(value[:3]) if isinstance(value, tuple) else "",
)
def test_a_mistake_is_one_helpful_line(desk: Path, labrig: Run, words: tuple[str, ...], said: str) -> None:
    """Exit code 2, one line on the error stream, nothing on the other, and no new file or folder."""
    before = sorted(desk.rglob("*"))
    code, out, err = labrig(*words)
    assert (code, out) == (2, "")
    assert err.startswith("labrig: ")
    assert said in err
    assert err.count("\n") == 1
    assert sorted(desk.rglob("*")) == before


@pytest.mark.parametrize(
    ("base", "said"),
    [
        ("{kind: python, file: none.py}", "model.yaml: base: file: there is no file none.py"),
        ("{kind: simulator, rig: none.yaml}", "model.yaml: base: rig: there is no file none.yaml"),
        ("{kind: python, file: own.py}", "own.py: has no function 'predict'"),
        ("{kind: ode, file: own.py, state: [0]}", "own.py: has no function 'output'"),
        ("simulator", "model.yaml, line 1: base: should hold fields (name: value), not 'simulator'"),
    ],
)
@pytest.mark.parametrize(
    "words",
    [("investigate", "--model", "model.yaml"), ("run", "capture", "--diagnose", "model.yaml")],
    ids=["investigate", "run"],
)
def test_nothing_is_measured_for_a_model_that_cannot_be(
    desk: Path, labrig: Run, words: tuple[str, ...], base: str, said: str
) -> None:
    """An investigation, and a run that is diagnosed, look at the model before the rig moves, and leave nothing."""
    (desk / "model.yaml").write_text(f"base: {base}\n")
    (desk / "own.py").write_text("def rate(t, x, u):\n    return -x\n")
    code, out, err = labrig(*words, "--rig", "rig.yaml", "--out", "new")
    assert (code, out, err.replace(f"{desk}{os.sep}", "")) == (2, "", f"labrig: {said}\n")
    assert not (desk / "new").exists()


def test_the_folder_above_a_run_is_not_the_run(desk: Path, labrig: Run) -> None:
    """Where a folder holds a run in a folder of its own, as a demo's does, that one is suggested."""
    run = ("run", "capture", "--rig", "rig.yaml", "--captures", "2", "--repeated", "0", "--out", "lab/run")
    assert labrig(*run)[0] == 0
    code, _, err = labrig("show", "lab")
    suggested = Path("lab/run")
    assert (code, err) == (
        2,
        f"labrig: lab is not a run: it holds no log.000.mcap; did you mean {suggested}?\n",
    )
    shutil.rmtree(suggested)
    assert labrig("show", "lab")[2] == "labrig: lab is not a run: it holds no log.000.mcap\n"


@pytest.mark.parametrize("command", ["run", "runs", "import", "validate"])
def test_usage_has_single_brackets(labrig: Run, command: str) -> None:
    """An argument that may be left out stands in one pair of brackets."""
    assert "[[" not in labrig(command, "--help")[1]


@pytest.mark.parametrize(
    ("old", "new", "said"),
    [
        (
            "chambers: [{name: c1, max_kpa: 60}, ",
            "chambers: [",
            "{named}: chambers: surface 'membrane' has 4, the rig names 3",
        ),
        (
            "surface: membrane",
            "surface: moon",
            "{named}: simulated.surface: there is no surface 'moon' (known: mannequin, membrane)",
        ),
    ],
)
@pytest.mark.parametrize(
    ("words", "named"),
    [
        (("run", "idle", "--rig", "rig.yaml", "--out", "new"), "rig bench"),
        (("ik", "target.xyz", "--model", "model.yaml"), "rig.yaml"),
    ],
)
def test_a_rig_that_its_simulator_cannot_be(
    desk: Path, labrig: Run, words: tuple[str, ...], named: str, old: str, new: str, said: str
) -> None:
    """The rig is named, whether a run or a model asks for its simulator."""
    assert old in RIG
    (desk / "rig.yaml").write_text(RIG.replace(old, new))
    assert labrig(*words) == (2, "", f"labrig: {said.format(named=named)}\n")


@pytest.mark.parametrize(
    ("old", "new", "said"),
    [
        ("chambers: [{", "chambers: 3 #", "rig.yaml, line 2: chambers: should be a list, not 3"),
        (
            "simulated: {surface: membrane}",
            "simulated: [1]",
            "rig.yaml, line 5: simulated: should hold fields (name: value), not a list",
        ),
    ],
)
@pytest.mark.parametrize(
    "words", [("run", "idle", "--rig", "rig.yaml"), ("ik", "target.xyz", "--model", "model.yaml")]
)
def test_a_rig_of_wrong_types(
    desk: Path, labrig: Run, words: tuple[str, ...], old: str, new: str, said: str
) -> None:
    """A number or a list in place of something else is said with its line, whoever reads the file."""
    (desk / "rig.yaml").write_text(RIG.replace(old, new))
    assert labrig(*words) == (2, "", f"labrig: {said}\n")


@pytest.mark.parametrize(
    ("old", "new", "said"),
    [
        (
            "surface: membrane",
            "surface: membrane, noise_mm: much",
            "rig.yaml: simulated.noise_mm: should be a number from 0 to 1000, not 'much'",
        ),
        (
            "mocap: {kind: simulated}",
            "mocap: {kind: simulated, rate_hz: fast}",
            "rig bench: mocap (simulated): could not convert string to float",
        ),
    ],
)
def test_a_simulated_device_of_wrong_values(desk: Path, labrig: Run, old: str, new: str, said: str) -> None:
    """A word where a simulated device wants a number is said with the rig and the device, not as unexpected."""
    (desk / "rig.yaml").write_text(RIG.replace(old, new))
    code, out, err = labrig("run", "idle", "--rig", "rig.yaml", "--out", "new")
    assert (code, out) == (2, "")
    assert err.startswith(f"labrig: {said}")
