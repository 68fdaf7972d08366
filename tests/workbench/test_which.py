"""What a card of Which says when it is looked at closer: bars and sentences of one unit that agree."""

import json
import math
import re
from pathlib import Path
from types import SimpleNamespace
from typing import Any

import numpy as np
import pytest

from labrig.log import import_table
from labrig.workbench import _held
from labrig.workbench._held import Key, trial
from labrig.workbench._which import closer, errors_in

MAPPING = """\
time: {column: t, unit: s}
capture: {column: capture}
actuation:
  - {column: p1, name: c1, unit: kPa, min: 0, max: 60}
observables:
  - {column: f, name: push, unit: N}
"""


WAYS = 9


@pytest.fixture
def slow_force(tmp_path: Path) -> Key:
    """A run of nine ways and a force, and a model of straight lines, which the ways are not; the force alone goes on as
    glass does that flows (a power of the time since each move), and all holds are alike long.
    """
    names = [f"x{k}" for k in range(WAYS)]
    random, lines, t = np.random.default_rng(3), [",".join(["t", "capture", "p1", "f", *names])], 0.0
    moves: list[tuple[float, float]] = []
    before = 0.0
    for capture in range(36):
        u = float(random.uniform(0, 60)) if capture % 6 not in (2, 3) else (45.0, 20.0)[capture % 6 - 2]
        moves.append((t, u - before))
        before = u
        for _ in range(4):
            t += 2.0
            left = sum(size * (1 + (t - since) / 3.0) ** -0.5 for since, size in moves)
            ways = np.linspace(0.1, 0.3, WAYS) * u * (1 + 0.0006 * u) + random.normal(0, 0.05, WAYS)
            cells = [0.1 * u - 0.06 * left + random.normal(0, 0.02), *ways]
            lines.append(f"{t:.1f},{capture},{u:.3f}," + ",".join(f"{cell:.4f}" for cell in cells))
    (tmp_path / "slow.csv").write_text("\n".join(lines) + "\n", encoding="utf-8")
    mapping = MAPPING + "".join(f"  - {{column: {name}, name: {name}, unit: mm}}\n" for name in names)
    (tmp_path / "map.yaml").write_text(mapping, encoding="utf-8")
    (tmp_path / "model.yaml").write_text("base: {kind: static, degree: 1}\n", encoding="utf-8")
    import_table(tmp_path / "map.yaml", tmp_path / "run", [tmp_path / "slow.csv"])
    return str(tmp_path / "run"), str(tmp_path / "model.yaml")


def test_bars_and_sentence_are_of_one_unit_and_agree(slow_force: Key) -> None:
    """The bars are of the sensors in which the effect acts most, and the sentence says by how much they differ."""
    said: dict[str, Any] = json.loads(closer(slow_force, "creep", ()))
    assert said["helps"]
    assert said["units"] == "N"
    by, unit = re.match(r"by ([\d.]+) (\w+), with a standard error of ", said["falls"]).groups()  # type: ignore[union-attr]
    assert unit == "N"
    assert math.isclose(float(by), said["base"] - said["alone"], rel_tol=0.06)
    assert said["floor"] < said["base"]


def test_beside_others_the_bars_are_of_that_unit_too(slow_force: Key) -> None:
    """With what was found before, and without: each is the error of the same sensors."""
    said = json.loads(closer(slow_force, "creep", ("regulator",)))
    alone = json.loads(closer(slow_force, "creep", ()))
    assert said["units"] == "N"
    assert said["beside"] < 0.8 * said["others"]
    assert math.isclose(said["alone"], alone["alone"])


def test_a_creep_that_is_looked_at_has_a_picture(slow_force: Key) -> None:
    """Also where all holds are alike long, the dots of its picture lie along an axis."""
    figure = json.loads(closer(slow_force, "creep", ()))["figure"]
    along = [x for trace in figure["data"] for x in trace["x"]]
    assert max(along) - min(along) > 1.0


def test_errors_are_told_in_the_unit_that_is_asked_for() -> None:
    """Where forces and ways are measured, an effect that acts on the forces has its bars in N, others theirs in mm."""
    by_unit = {"mm": {"base": 2.0, "model": 1.9}, "N": {"base": 0.5, "model": 0.1}}
    summary = {"units": "mm", "error": by_unit["mm"], "error_by_unit": by_unit}
    tried: Any = SimpleNamespace(result=SimpleNamespace(summary=summary))
    assert errors_in("N", tried) == {"base": 0.5, "model": 0.1}
    assert errors_in("mm", tried) == {"base": 2.0, "model": 1.9}


def test_what_was_looked_at_before_changes_no_bar(slow_force: Key) -> None:
    """An error is the same on every card, whichever effects were tried meanwhile, and the sentence of an effect beside
    others is the difference of the two bars above it.
    """
    asked = [("creep", ()), ("delay", ("creep",))]
    first = [json.loads(closer(slow_force, *each)) for each in asked]
    trial(slow_force, ("creep", "drift"), False)
    trial(slow_force, ("creep", "regulator"), True)
    for kept in [kept for kept in _held._trials if "drift" not in str(kept)]:
        del _held._trials[kept]
    assert [json.loads(closer(slow_force, *each)) for each in asked] == first
    beside = first[1]
    by = float(re.match(r"by (-?[\d.e-]+) ", beside["falls"])[1])  # type: ignore[index]
    assert math.isclose(by, beside["others"] - beside["beside"], rel_tol=0.06, abs_tol=1e-5)
