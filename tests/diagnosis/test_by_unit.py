"""Errors in every unit that was measured in, and which unit is quoted."""

from pathlib import Path
from typing import Any

import numpy as np
import pandas as pd
import pytest

import labrig
from labrig._turns import commonest_unit
from labrig.view._naming import unnamed_words

NOISE = {"force_N": 0.05, "tip_deg": 0.2, "base_deg": 0.2}


def rig(u: np.ndarray) -> np.ndarray:
    """A finger: the force at its tip and two angles, of two pressures, (F, 3)."""
    return np.column_stack([0.02 * u[:, 0] + 0.01 * u[:, 1], 0.9 * u[:, 0], 0.5 * u[:, 1]])


def measured(folder: Path, wall_deg: float = np.inf, mistake_n: float = 0.0) -> Any:
    """A run of 60 set-points; the tip meets a wall there, and one force was misread by so much."""
    rng = np.random.default_rng(3)
    u = rng.uniform(0, 60, (60, 2)).round(1)
    u[50:] = u[:10]
    values = rig(u) + rng.normal(size=(60, 3)) * list(NOISE.values())
    values[:, 1] = np.minimum(values[:, 1], wall_deg + 0.2 * rng.normal(size=60))
    values[20, 0] += mistake_n
    table = pd.DataFrame(np.column_stack([u, values]), columns=["p1_kPa", "p2_kPa", *NOISE])
    return labrig.import_table(table, folder)


@pytest.mark.parametrize("mistake_n", [0.0, 40.0])
def test_what_is_off_is_quoted_whatever_was_misread(tmp_path: Path, mistake_n: float) -> None:
    """An angle that meets a wall is what the error is about; a single wild force, which is left out, is not."""
    run = measured(tmp_path / "run", wall_deg=30.0, mistake_n=mistake_n)
    found = labrig.compare(run, rig)
    assert found.units == "deg"
    assert list(found.errors.index) == ["deg", "N"]
    assert found.errors.loc["deg", "model"] == pytest.approx(found.error["model"])
    assert found.errors.loc["N", "model"] == pytest.approx(NOISE["force_N"], rel=0.3)
    assert "error, N rms: model 0.0" in repr(found)


def test_two_models_are_compared_in_each_unit(tmp_path: Path) -> None:
    """Whichever unit is quoted, a model that is nearer in the force and no worse in the angles is seen to be."""
    run = measured(tmp_path / "run")

    def weak(u: np.ndarray) -> np.ndarray:
        return rig(u) * [0.5, 1.0, 1.0]

    alone = [labrig.compare(run, model) for model in (weak, rig)]
    assert alone[0].units == "N"
    before, after = (each.errors for each in alone)
    assert before.loc["N", "model"] > 5 * after.loc["N", "model"]
    assert before.loc["deg", "model"] == pytest.approx(after.loc["deg", "model"])
    both = labrig.compare(run, [weak, rig])
    assert both.errors.loc["N", both.errors.columns[1]] == pytest.approx(after.loc["N", "model"], rel=0.05)


def test_one_sensor_alone_is_said_in_its_own_unit() -> None:
    """What only the force is wrong in is newtons, though the angles are more."""
    summary: Any = {"units": "deg", "error": {"floor": 0.2}, "verdict": "unknown"}
    summary |= {"unnamed": {"force alone": 0.004, "place": 0.01}, "unnamed_units": {"force alone": "N"}}
    said = unnamed_words(summary).replace("\u00a0", " ")
    assert said.startswith("Unexplained by any effect: 0.004 N is in force alone:")
    assert "0.01" not in said


def tracked(u: np.ndarray, curl: float = 0.0) -> np.ndarray:
    """Where one tracker is, in mm, and its quaternion, of two pressures, (F, 7); it turns by more where it curls."""
    half = np.deg2rad(0.3 + curl) * u / 2
    turn = np.column_stack([np.cos(half).prod(axis=1), np.sin(half), np.zeros(len(u))])
    turn[:, 3] = np.sqrt(np.maximum(1 - (turn[:, :3] ** 2).sum(axis=1), 0.0))
    return np.column_stack([0.6 * u[:, 0], 0.5 * u[:, 1], 90 - 0.1 * u.sum(axis=1), turn])


@pytest.mark.parametrize("more", [[], ["strain"]])
@pytest.mark.parametrize("curl", [0.0, 0.05])
def test_a_place_with_its_quaternion_is_quoted_in_mm(tmp_path: Path, curl: float, more: list[str]) -> None:
    """Four parts of a quaternion are more than three coordinates, and nobody thinks in them: however far they are off,
    and whatever else has no unit, errors are those of the place.
    """
    rng = np.random.default_rng(3)
    u = rng.uniform(0, 60, (60, 2)).round(1)
    values = tracked(u, curl) + rng.normal(size=(60, 7)) * [0.1, 0.1, 0.1, *[0.0005] * 4]
    names = ["tip_x_mm", "tip_y_mm", "tip_z_mm", "q0", "qx", "qy", "qz"]
    table = pd.DataFrame(np.column_stack([u, values]), columns=["p1_kPa", "p2_kPa", *names])
    table = table.assign(**{name: 0.01 * u[:, 0] + 0.0005 * rng.normal(size=60) for name in more})

    def model(u: np.ndarray) -> np.ndarray:
        return np.column_stack([tracked(u), *(0.01 * u[:, 0] for _ in more)])

    found = labrig.compare(labrig.import_table(table, tmp_path / "run"), model)
    assert found.units == "mm"
    assert {*found.errors.index} == {"mm", "1"}
    assert found.error["model"] == pytest.approx(0.1, rel=0.3)


def test_a_quaternion_alone_is_quoted_as_it_is() -> None:
    """Where nothing else is there the parts of the quaternion count."""
    turn = np.tile([0.6, 0.0, 0.8, 0.0], (5, 1))
    places = np.arange(15.0).reshape(5, 3)
    assert commonest_unit(["1"] * 4, turn).tolist() == [0, 1, 2, 3]
    assert commonest_unit(["mm"] * 3 + ["1"] * 4, np.hstack([places, turn])).tolist() == [0, 1, 2]
    assert commonest_unit(["mm"] * 3 + ["1"] * 4, np.hstack([places, 2 * turn])).tolist() == [3, 4, 5, 6]
