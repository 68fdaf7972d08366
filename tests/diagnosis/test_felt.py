"""What sensors beside the markers feel of a wall that these run against."""

from pathlib import Path

import numpy as np
import pandas as pd
import pytest

import labrig
from labrig.log import import_guessed

BASE = """
import numpy as np


def predict(p):
    a, b = 0.011 * p[:, 0], 0.009 * p[:, 1]
    turn, way = np.hypot(a, b) + 1e-9, np.arctan2(b, a)
    long = 1 + 0.0006 * (p[:, 0] + p[:, 1])
    out = []
    for s in (0.4, 0.7, 1.0):
        r, z = (100 * s * long * f / (s * turn) for f in (1 - np.cos(s * turn), np.sin(s * turn)))
        out += [r * np.cos(way), r * np.sin(way), z]
    return np.stack([*out, 0.03 * p[:, 0] + 0.012 * p[:, 1]], axis=1)
"""


@pytest.fixture
def finger(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> Path:
    """A finger of constant curvature, two chambers, three markers and a force at the tip, which a wall at x = 42 mm
    gives way to by a seventh, and pushes back on; measured once at each set-point, in a table.
    """
    monkeypatch.chdir(tmp_path)
    rng, space = np.random.default_rng(4), {}
    exec(BASE, space)
    p = np.vstack([np.zeros(2), rng.uniform(0, 90, (80, 2))])
    p = np.vstack([p, *(p[j - 1 : j + 1] for j in rng.integers(2, 80, 4))])
    values = space["predict"](p)
    beyond = np.maximum(values[:, 6] - 42.0, 0.0)
    assert 10 <= (beyond > 0.3).sum() <= 25
    values[:, [0, 3, 6]] -= np.outer(beyond, [0.12, 0.5, 0.85])
    values[:, 9] += 0.15 * beyond
    values += rng.normal(size=values.shape) * np.r_[np.full(9, 0.15), 0.01]
    names = [f"M{i}_{a} [mm]" for i in (1, 2, 3) for a in "xyz"]
    table = pd.DataFrame(np.column_stack([6.0 * np.arange(len(p)), p, values]))
    table.columns = ["t_s", "p1 [kPa]", "p2 [kPa]", *names, "F_tip [N]"]
    table.to_csv("finger.csv", index=False)
    import_guessed([Path("finger.csv")], Path("run"))
    Path("base.py").write_text(BASE)
    Path("model.yaml").write_text("base: {kind: python, file: base.py, function: predict}\n")
    return tmp_path


def test_a_wall_that_a_force_feels_is_contact(finger: Path, few_effects) -> None:
    """Not a loop of the force: contact is the only likely name, with what the force has of each millimetre."""
    few_effects("contact", "hysteresis", "friction", "tension", "stiffening", "frame", "gravity")
    found = labrig.diagnose("run", "model.yaml")
    assert found.effects["effect"][0] == "contact"
    assert found.effects["probability"][0] > 0.5
    assert found.effects["probability"][1] < 0.2
    assert found.improved is not None
    entry = next(e for e in found.improved.file.effects if e.name == "contact")
    assert entry.form == "plane, felt"
    felt = entry.parameters["felt"]
    assert felt.unit == "N/mm"
    assert float(np.ravel(felt.value)[0]) > 0.05
    assert entry.parameters["distance"].unit == "mm"
    error = found.summary["error"]
    assert error["model"] < 0.75 * error["base"]
