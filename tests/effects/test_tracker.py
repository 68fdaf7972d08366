"""A tracker at the tip, its place and its quaternion, whose frame was bumped during the run."""

from dataclasses import replace
from pathlib import Path
from typing import Any

import numpy as np
import pandas as pd
import pytest
import yaml
from scipy.spatial.transform import Rotation

import labrig
from labrig.diagnosis import Result, diagnose
from labrig.effects import rows_of
from labrig.model import Model

CAPTURES, BUMPED = 60, 34
TURN_RAD = np.array([0.004, 0.017, -0.006])
SHIFT_MM = np.array([0.6, -0.4, 0.3])
TIP = """
import numpy as np

def predict(u):
    bend = 0.9 * np.clip(np.hypot(u[:, 0], u[:, 1]) / 100, 1e-9, None)
    way = np.arctan2(u[:, 1], u[:, 0])
    along = 120 / bend
    x, y = (along * (1 - np.cos(bend)) * f for f in (np.cos(way), np.sin(way)))
    half = bend / 2
    turn = [np.cos(half), -np.sin(half) * np.sin(way), np.sin(half) * np.cos(way), 0 * half]
    return np.stack([x, y, along * np.sin(bend), *turn], axis=1)
"""
NAMES = ("x", "y", "z", "q0", "qx", "qy", "qz")


def bumped(places: np.ndarray, quaternions: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
    """Places (n, 3) and quaternions (n, 4; the real part first) as a frame sees them that was turned and shifted."""
    turn = Rotation.from_rotvec(TURN_RAD)
    seen = turn * Rotation.from_quat(quaternions[:, [1, 2, 3, 0]])
    return turn.apply(places) + SHIFT_MM, seen.as_quat()[:, [3, 0, 1, 2]]


@pytest.fixture
def found(tmp_path: Path) -> Result:
    """What is said of a bending arm whose tracker's frame was bumped at two thirds of the run."""
    random = np.random.default_rng(5)
    u = random.uniform(0, 100, (CAPTURES, 2)).round(1)
    (tmp_path / "tip.py").write_text(TIP)
    scope: dict[str, Any] = {}
    exec(TIP, scope)
    truth = scope["predict"](u)
    places, turns = bumped(truth[BUMPED:, :3], truth[BUMPED:, 3:])
    truth[BUMPED:] = np.concatenate([places, turns], axis=1)
    values = truth + random.normal(size=truth.shape) * ([0.15] * 3 + [0.001] * 4)
    columns = {
        "t": 10.0 * np.arange(CAPTURES),
        "a": u[:, 0],
        "b": u[:, 1],
        **dict(zip(NAMES, values.T, strict=True)),
    }
    pd.DataFrame(columns).to_csv(tmp_path / "t.csv", index=False)
    mapping = {
        "table": "t.csv",
        "time": {"column": "t", "unit": "s"},
        "settle_s": 5,
        "actuation": [{"column": c, "name": c, "unit": "kPa", "min": 0, "max": 100} for c in "ab"],
        "observables": [
            {"column": a, "name": f"tip.{a}", "unit": "mm", "marker": "tip", "axis": a} for a in NAMES[:3]
        ]
        + [{"column": q, "name": q, "unit": "1"} for q in NAMES[3:]],
    }
    (tmp_path / "map.yaml").write_text(yaml.safe_dump(mapping))
    (tmp_path / "model.yaml").write_text("base: {kind: python, file: tip.py}\n")
    run = labrig.import_table(tmp_path / "map.yaml", tmp_path / "run")
    return diagnose(run, Model.load(tmp_path / "model.yaml"))


def test_the_frame_of_one_tracker_that_was_bumped_is_told(found: Result) -> None:
    """Frame is the one name that fits, from the capture on at which it was bumped; it turns the quaternion by as much
    as the places, and the error falls to the noise.
    """
    said = found.summary
    assert [c["effect"] for c in said["effects_considered"] if c["call"] != "not it"] == ["frame"]
    assert said["error"]["model"] < 2 * said["error"]["floor"] < 0.5 * said["error"]["base"]
    assert found.improved is not None
    (entry,) = found.improved.file.effects
    assert entry.form == "rigid, since a moment, quaternions too"
    assert entry.parameters["since_s"].value == pytest.approx(10.0 * BUMPED, abs=10.0)
    turn = np.array(entry.parameters["shift_since"].value)[3:]
    assert turn == pytest.approx(TURN_RAD, abs=0.004)  # the tip's height hardly changes
    assert np.array(entry.parameters["turn"].value) == pytest.approx(TURN_RAD, abs=0.001)


def test_a_frame_that_an_older_labrig_fitted_stays_as_it_is(found: Result, tmp_path: Path) -> None:
    """A model whose frame moves the places alone is read on a run with a quaternion, and changes no quaternion."""
    assert found.improved is not None
    (entry,) = found.improved.file.effects
    older = entry.model_copy(update={"form": entry.form.removesuffix(", quaternions too")})
    older.parameters.pop("turn")
    file = found.improved.file.model_copy(update={"effects": [older]})
    context = replace(found.improved, file=file).context(rows_of(labrig.open_run(tmp_path / "run")))
    base = Model.load(tmp_path / "model.yaml").context(rows_of(labrig.open_run(tmp_path / "run"))).base
    assert np.abs(context.base - base)[:, :3].max() > 0.3
    assert context.base[:, 3:] == pytest.approx(base[:, 3:])
