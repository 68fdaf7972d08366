"""The examples in the docstrings of the public names run as they stand."""

import contextlib
import doctest
import inspect
import io
import shutil
from pathlib import Path
from typing import Any

import numpy as np
import pandas as pd
import pytest
import yaml

import labrig
from tests.rigs import RIG

SHAPES = {"solve_ik", "train_forward", "train_sim2real", "validate"}
"""What needs a surface that can be solved for; the others are shown on a campaign of markers."""


SLOW = {"investigate", "solve_ik"}
FUNCTIONS = [name for name in labrig.__all__ if inspect.isfunction(getattr(labrig, name))]
SHOWN = [name for name in labrig.__all__ if ">>>" in (getattr(labrig, name).__doc__ or "")]


@pytest.fixture(scope="session")
def campaign(tmp_path_factory: pytest.TempPathFactory) -> Path:
    """A rig that hides hysteresis: rig.yaml, two models, runs/first, runs/later, runs/on_off; a table, its mapping."""
    from labrig_drivers.simulated import hide, seal

    folder = tmp_path_factory.mktemp("campaign")
    (folder / "rig.yaml").write_text(yaml.safe_dump(RIG), encoding="utf-8")
    (folder / "model.yaml").write_text(
        "base: {kind: simulator, rig: rig.yaml}\neffects: []\n", encoding="utf-8"
    )
    seal(folder, hide("hysteresis", seed=1))
    labrig.run("capture", folder / "rig.yaml", out=folder / "runs" / "first", captures=40)
    labrig.run("capture", folder / "rig.yaml", out=folder / "runs" / "later", captures=20, seed=2)
    better = labrig.improve(folder / "runs" / "first", folder / "model.yaml", "hysteresis")
    better.model.save(folder / "improved.yaml")
    on = {"pressure_kpa": {"c1": 42, "c2": 36, "c3": 30, "c4": 45}, "hold_s": 4.0, "repeat": "on"}
    on_off = [on, {"repeat": "off"}]
    labrig.run("programme", folder / "rig.yaml", out=folder / "runs" / "on_off", points=on_off, rounds=10)
    pressure = np.linspace(0.0, 50.0, 30)
    pd.DataFrame({"p": pressure, "x": 0.1 * pressure}).to_csv(folder / "campaign.csv", index=False)
    mapping = {
        "table": "campaign.csv",
        "actuation": [{"column": "p", "name": "c1", "unit": "kPa", "min": 0, "max": 60}],
        "observables": [{"column": "x", "name": "tip", "unit": "mm"}],
    }
    (folder / "map.yaml").write_text(yaml.safe_dump(mapping), encoding="utf-8")
    return folder


@pytest.fixture(scope="session")
def shapes(tmp_path_factory: pytest.TempPathFactory) -> Path:
    """A sheet over four chambers with a scanner: rig.yaml, simulations, forward.pt, runs/first, and body.ply."""
    from labrig.campaign._scans import keep_scan
    from labrig.physics import load_shell, simulate
    from labrig.surface import grid
    from labrig.surrogate import save_model
    from labrig_drivers import Scan

    folder = tmp_path_factory.mktemp("shapes")
    rig = {
        "name": "sheet",
        "chambers": [{"name": f"c{i}", "min_kpa": 0, "max_kpa": 60, "slew_kpa_s": 100} for i in (1, 2, 3, 4)],
        "pressure": {"kind": "simulated"},
        "mocap": {"kind": "simulated", "rate_hz": 20},
        "scanner": {"kind": "simulated"},
        "simulated": {"shell": "membrane4", "plant": {"count": [10, 10], "shapes": 20}, "noise_mm": 0.05},
    }
    (folder / "rig.yaml").write_text(yaml.safe_dump(rig), encoding="utf-8")
    simulate(load_shell("membrane4").changed(count=(10, 10)), folder / "simulations", 40, workers=1)
    forward = labrig.train_forward(folder / "simulations").model
    save_model(forward, folder / "forward.pt")
    labrig.run("capture", folder / "rig.yaml", out=folder / "runs" / "first", captures=8, repeated=0)
    uv, triangles = grid(31, 31)
    points = forward.points(np.array([20.0, 35.0, 10.0, 40.0]), uv)[0]
    kept = keep_scan(Scan(0.0, points, triangles, (), ""), folder)[0]
    (folder / kept).rename(folder / "body.ply")
    return folder


def test_every_function_has_an_example() -> None:
    """Whoever asks for help on a function sees it used."""
    assert [name for name in FUNCTIONS if ">>>" not in (getattr(labrig, name).__doc__ or "")] == []


@pytest.mark.parametrize(
    "name", [pytest.param(name, marks=pytest.mark.slow if name in SLOW else ()) for name in SHOWN]
)
def test_an_example_runs(
    name: str,
    request: pytest.FixtureRequest,
    tmp_path: Path,
    monkeypatch: pytest.MonkeyPatch,
    few_effects: Any,
) -> None:
    """In a folder with the files that it names it prints what it says; what is diagnosed is told from a few effects."""
    files: Any = request.getfixturevalue("shapes" if name in SHAPES else "campaign")
    shutil.copytree(files, tmp_path / "here")
    monkeypatch.chdir(tmp_path / "here")
    few_effects("hysteresis", "friction", "creep")
    thing = getattr(labrig, name)
    (example,) = doctest.DocTestFinder(recurse=False).find(
        thing, name, globs={"labrig": labrig, "pandas": pd}
    )
    assert example.examples
    said = io.StringIO()
    with contextlib.redirect_stderr(io.StringIO()):
        failed = doctest.DocTestRunner(verbose=False).run(example, out=said.write).failed
    assert failed == 0, said.getvalue()
