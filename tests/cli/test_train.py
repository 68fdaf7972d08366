"""labrig train: from simulations and a run to model files and reports, and what it says when something is wrong."""

import json
import shutil
from pathlib import Path

import numpy as np
import pytest
import yaml

from labrig.physics import load_shell
from labrig.surrogate import load_model


@pytest.fixture(scope="module")
def simulations(tmp_path_factory) -> Path:
    """A folder of forty simulations of the flat membrane, solved coarsely."""
    from labrig.physics import simulate

    folder = tmp_path_factory.mktemp("train") / "sims"
    simulate(load_shell("membrane4").changed(count=(10, 10)), folder, 40, workers=1)
    return folder


@pytest.fixture(scope="module")
def forward(simulations) -> Path:
    """The forward model of them, which the fixes begin with."""
    import labrig

    path = simulations.parent / "forward.pt"
    labrig.train_forward(simulations).save(path)
    return path


def test_forward(labrig, simulations, tmp_path):
    """A forward model is trained, compared with the paper's, written and reported."""
    out = tmp_path / "report"
    code, printed, error = labrig(
        "train", "forward", str(simulations), "-o", str(tmp_path / "f.pt"), "--out", str(out), "--paper"
    )
    assert code == 0, error
    assert "gaussian process" in printed
    assert "paper's network" in printed
    model = load_model(tmp_path / "f.pt")
    assert model.chamber_names == ("c1", "c2", "c3", "c4")
    assert model.provenance["source"]["simulations"] == "sims"
    assert json.loads((out / "forward.json").read_text())["gaussian"]["mean_mm"] > 0
    assert {p.name for p in out.iterdir()} == {
        "forward.json",
        "report.html",
        "error_map.png",
        "calibration.png",
    }


def test_sim2real(labrig, forward, tmp_path, monkeypatch):
    """A run of a simulated rig, or several, fix the model; the report says what was left out."""
    monkeypatch.chdir(tmp_path)
    rig = {
        "name": "sheet",
        "chambers": [{"name": f"c{i}", "min_kpa": 0, "max_kpa": 60, "slew_kpa_s": 100} for i in (1, 2, 3, 4)],
        "pressure": {"kind": "simulated"},
        "mocap": {"kind": "simulated"},
        "simulated": {"shell": "membrane4", "plant": {"count": [10, 10], "shapes": 20}, "noise_mm": 0.05},
    }
    Path("rig.yaml").write_text(yaml.safe_dump(rig))
    shutil.copy(forward, "f.pt")
    code, _, error = labrig(
        "run", "capture", "--rig", "rig.yaml", "--captures", "8", "--repeated", "0", "--out", "run"
    )
    assert code == 0, error
    code, printed, error = labrig(
        "train", "sim2real", "run", "--forward", "f.pt", "-o", "s.pt", "--out", "fix"
    )
    assert code == 0, error
    assert "as simulated" in printed
    facts = json.loads(Path("fix/sim2real.json").read_text())
    assert facts["frames"] == 8
    fixed = load_model("s.pt")
    assert np.isfinite(fixed.points(np.full(4, 20.0), np.array([[0.5, 0.5]]))).all()
    Path("run").rename("monday")
    again = ("run", "capture", "--rig", "rig.yaml", "--captures", "3", "--repeated", "0", "--out", "tuesday")
    assert labrig(*again, "--seed", "7")[0] == 0
    two = ("train", "sim2real", "monday", "tuesday", "--forward", "f.pt", "-o", "two.pt", "--out", "both")
    code, printed, error = labrig(*two)
    assert (code, error) == (0, "")
    assert "monday, tuesday, method ours" in printed
    assert json.loads(Path("both/sim2real.json").read_text())["frames"] == 11
    code, _, error = labrig(
        "train", "sim2real", "monday", "--forward", "f.pt", "-o", "t.pt", "--method", "scans"
    )
    assert (code, error) == (2, "labrig: sim2real: the method scans needs scans; the run has none\n")


def test_a_survey_has_what_both_needs(labrig, forward, tmp_path, monkeypatch):
    """`labrig run survey` records markers and scans, and the fix is learned from both."""
    monkeypatch.chdir(tmp_path)
    rig = {
        "name": "sheet",
        "chambers": [{"name": f"c{i}", "min_kpa": 0, "max_kpa": 60, "slew_kpa_s": 100} for i in (1, 2, 3, 4)],
        "pressure": {"kind": "simulated"},
        "mocap": {"kind": "simulated", "rate_hz": 20},
        "scanner": {"kind": "simulated"},
        "simulated": {"shell": "membrane4", "plant": {"count": [10, 10], "shapes": 20}, "noise_mm": 0.05},
    }
    Path("rig.yaml").write_text(yaml.safe_dump(rig))
    shutil.copy(forward, "f.pt")
    survey = ("run", "survey", "--rig", "rig.yaml", "--captures", "8", "--repeated", "0", "--scans", "3")
    code, _, error = labrig(*survey, "--out", "run")
    assert code == 0, error
    arguments = ("sim2real", "run", "--forward", "f.pt", "-o", "both.pt", "--method", "both")
    code, _, error = labrig("train", *arguments, "--out", "both")
    assert code == 0, error
    facts = json.loads(Path("both/sim2real.json").read_text())
    assert (facts["frames"], facts["scans"]) == (8, 3)


@pytest.mark.parametrize(
    ("arguments", "complaint"),
    [
        (
            ("forward", "nowhere", "-o", "f.pt"),
            "nowhere: holds no simulations.npz (make it: labrig simulate)",
        ),
        (("forward", "nowhere", "-o", "no/f.pt"), "no/f.pt: the folder no does not exist"),
        (
            ("forward", "nowhere", "-o", "f.pt", "--method", "magic"),
            "method 'magic': choose one of gaussian, network, paper",
        ),
        (
            ("sim2real", "run", "--forward", "f.pt", "-o", "s.pt"),
            "f.pt: does not exist; make it with: labrig train",
        ),
        (
            ("sim2real", "run", "--forward", "f.pt", "-o", "s.pt", "--method", "magic"),
            "method 'magic': choose one of ours, scans, both, function, marker",
        ),
    ],
)
def test_what_is_wrong_is_said(labrig, arguments, complaint, tmp_path, monkeypatch):
    """What is missing is said in one line."""
    monkeypatch.chdir(tmp_path)
    code, _, error = labrig("train", *arguments)
    assert (code, error) == (2, f"labrig: {complaint}\n")
