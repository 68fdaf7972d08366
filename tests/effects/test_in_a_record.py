"""Leaks and sensors in a record without holds: what a slow refill lags behind, and one sensor that warms up."""

from pathlib import Path

import numpy as np
import pandas as pd
import pytest
from scipy.integrate import solve_ivp

import labrig
from labrig.diagnosis import diagnose
from labrig.effects import library, rows_of

STEP_S = 0.2
T = STEP_S * np.arange(900)


def pressures(seed: int) -> np.ndarray:
    """Two pressures that never rest, kPa, (900, 2): sums of slow sines of no common period."""
    random = np.random.default_rng(seed)
    rates, phases = random.uniform(0.02, 0.25, (5, 2)), random.uniform(0, 2 * np.pi, (5, 2))
    waves = np.sin(2 * np.pi * T[:, None, None] * rates + phases).sum(axis=1)
    return 40 * (waves - waves.min(axis=0)) / np.ptp(waves, axis=0)


def leaked(p: np.ndarray) -> np.ndarray:
    """Pressures whose first chamber leaks into the room, as p^1.5 / (p^0.5 + 2), and that a valve refills in 14 s."""

    def rate(t: float, lost: np.ndarray) -> np.ndarray:
        left = np.maximum(np.interp(t, T, p[:, 0]) - lost, 0.0)
        return 0.024 * left**1.5 / (left**0.5 + 2) - lost / 14.0

    lost = solve_ivp(rate, (0, T[-1]), [0.0], t_eval=T, max_step=0.5).y[0]
    return p - np.stack([lost, 0 * lost], axis=1)


def shape(p: np.ndarray) -> np.ndarray:
    """An angle, deg, and a force, N, (n, 2)."""
    return np.stack(
        [0.9 * p[:, 0] - 0.5 * p[:, 1], 0.2 * p[:, 0] + 0.3 * p[:, 1] + 0.002 * p[:, 0] ** 2], axis=1
    )


def record(folder: Path, p: np.ndarray, seen: np.ndarray, unit: str = "kPa"):
    """What a laboratory's file of it is read as."""
    columns = {"t (s)": T, f"p1 set ({unit})": p[:, 0].round(3), f"p2 set ({unit})": p[:, 1].round(3)}
    columns |= {"angle (deg)": seen[:, 0].round(3), "force (N)": seen[:, 1].round(3)}
    return labrig.import_table(pd.DataFrame(columns), folder / "run")


@pytest.mark.parametrize("hidden", ["leak", "creep"])
def test_a_leak_in_a_record_is_told_from_creep(tmp_path: Path, hidden: str) -> None:
    """A leak takes and a creeping wall gives: with the same lag behind the pressure each has its name, or is a doubt
    that has it, and never the other's.
    """
    p, noise = pressures(3), np.random.default_rng(4).normal(size=(900, 2)) * [0.3, 0.1]
    if hidden == "leak":
        seen = shape(leaked(p))
    else:
        late = solve_ivp(
            lambda t, x: (np.interp(t, T, p[:, 0]) - x) / 14.0, (0, T[-1]), [0.0], t_eval=T, max_step=0.5
        ).y[0]
        seen = shape(p + 0.06 * np.stack([late**1.2 / 40**0.2, 0 * late], axis=1))
    found = diagnose(record(tmp_path, p, seen + noise), labrig.Model.of(shape)).summary
    other = {"leak": "creep", "creep": "leak"}[hidden]
    assert hidden in (*found["effects"], *found["rivals"])
    assert other not in found["effects"]
    assert found["error"]["model"] < 0.6 * found["error"]["base"]


def test_only_pressures_leak_in_a_record(tmp_path: Path) -> None:
    """A motor that winds up a tendon has no air that could escape; a run with holds shows a leak along these."""
    p = pressures(5)
    spaces = {}
    for unit in ("kPa", "deg"):
        (tmp_path / unit).mkdir()
        run = record(tmp_path / unit, p, shape(p), unit)
        context = labrig.Model.of(shape).context(rows_of(run))
        spaces[unit] = [space.key for space in library()["leak"].family(context)]
    assert spaces == {"kPa": ["refilled"], "deg": []}


def test_one_sensor_that_warms_up_drifts(tmp_path: Path) -> None:
    """Its zero and its gain go together, and the other sensor stays as it is: no creep, which both would show."""
    p, noise = pressures(6), np.random.default_rng(7).normal(size=(900, 2)) * [0.3, 0.1]
    seen = shape(p)
    warm = 1 - 1 / (1 + T / 50) ** 1.3
    seen[:, 0] = (seen[:, 0] + 20) * (1 + 0.05 * warm) - 20
    found = diagnose(record(tmp_path, p, seen + noise), labrig.Model.of(shape)).summary
    assert found["effects"] == ["drift"]
