"""Angles that begin again after a whole turn, and quaternions with either sign: no jump where the body makes none."""

from pathlib import Path

import numpy as np
import pandas as pd
import pytest
import yaml
from hypothesis import given
from hypothesis import strategies as st

from labrig.log import import_table
from labrig.tables import opened


@pytest.mark.parametrize(("unit", "turn"), [("deg", 360.0), ("rad", 2 * np.pi)])
@pytest.mark.parametrize("ends_at", [0.5, 1.0])
def test_an_angle_goes_on_over_the_end_of_its_scale(unit: str, turn: float, ends_at: float) -> None:
    """Whether the scale ends at half a turn or at a whole one; rows that were not seen stay so."""
    true = turn * (ends_at + np.linspace(-0.1, 0.1, 40))
    seen = np.where(true > turn * ends_at, true - turn, true)
    seen[5] = np.nan
    out, said = opened(["yaw"], [unit], seen[:, None])
    known = np.arange(40) != 5
    assert out[known, 0] == pytest.approx(true[known])
    assert np.isnan(out[5, 0])
    assert said == [
        f"yaw begins again after a whole turn: here it goes on, from {true[0]:.4g} to {true[-1]:.4g} {unit}"
    ]


@pytest.mark.parametrize(
    "seen",
    [
        np.linspace(-170, 170, 50),  # all of a turn
        np.array([-100.0, 100.0] * 20),  # two states
        np.linspace(0, 1000, 50),  # counts turns itself
        np.linspace(-40, 40, 30),
        np.array([5.0]),
        np.full(4, np.nan),
    ],
)
def test_other_angles_stay(seen: np.ndarray) -> None:
    """What does not jump over the end of a scale is left as it is, and nothing is said."""
    out, said = opened(["yaw"], ["deg"], seen[:, None])
    assert np.array_equal(out[:, 0], seen, equal_nan=True)
    assert said == []


def test_a_length_is_no_angle() -> None:
    """Numbers that would be an angle's, in millimetres, stay."""
    seen = np.array([[179.0], [-179.0]] * 5)
    assert (opened(["x"], ["mm"], seen)[0] == seen).all()


@given(st.integers(0, 10_000), st.integers(0, 4))
def test_a_quaternion_keeps_one_sign(seed: int, before: int) -> None:
    """Turns of up to 100 degrees about any axes, each row with either sign, wherever the four columns stand."""
    random = np.random.default_rng(seed)
    half, axis = np.deg2rad(random.uniform(0, 50, 60)), random.normal(size=(60, 3))
    axis /= np.linalg.norm(axis, axis=1, keepdims=True)
    true = np.column_stack([np.cos(half), np.sin(half)[:, None] * axis])
    signs = np.where(np.arange(60) == 7, -1.0, random.choice([-1.0, 1.0], 60))
    others = random.normal(size=(60, before))
    names = [f"f{i}" for i in range(before)] + ["qw", "qx", "qy", "qz"]
    out, said = opened(names, ["N"] * before + ["1"] * 4, np.hstack([others, true * signs[:, None]]))
    assert out[:, before:] == pytest.approx(true)
    assert (out[:, :before] == others).all()
    assert said == [
        "qw, qx, qy and qz are a quaternion, the same turn with either sign: "
        f"{(signs < 0).sum()} of 60 rows have the other sign here"
    ]


def test_four_numbers_are_not_always_a_quaternion() -> None:
    """Numbers whose squares add up to something else, or that have a unit, keep their signs."""
    values = np.random.default_rng(0).normal(size=(30, 4))
    assert (opened(list("abcd"), ["1"] * 4, values)[0] == values).all()
    unit = values / np.linalg.norm(values, axis=1, keepdims=True)
    assert (opened(list("abcd"), ["N"] * 4, unit)[0] == unit).all()


def test_an_import_says_it(tmp_path, labrig) -> None:
    """A table with such an angle: the note says from where to where it goes, and the run goes on beyond half a turn."""
    import labrig as package

    rows = [f"{5 * i},{i % 10},{(170 + 2 * (i % 10) + 180) % 360 - 180}" for i in range(40)]
    (tmp_path / "t.csv").write_text("\n".join(["time_s,c1_kPa,yaw_deg", *rows]) + "\n")
    code, out, err = labrig("import", tmp_path / "t.csv", "-o", tmp_path / "run")
    assert code == 0
    assert "yaw begins again after a whole turn: here it goes on, from 170 to 188 deg" in out + err
    assert float(package.open_run(tmp_path / "run").observed.max()) == 188.0


@pytest.mark.parametrize("low", [-180.0, 0.0])
def test_between_the_rows_of_a_joined_file(tmp_path: Path, low: float) -> None:
    """Between 179 and -179 degrees lies 180 and not 0, and between a quaternion and its negative the same turn."""
    at, clock = np.arange(200) * 0.1 + 0.013, np.arange(700) * 0.03
    turned = (180.0 if low else 360.0) + 40 * np.sin(clock)
    half = np.radians(turned) / 2
    sign = np.where(np.arange(700) % 3, 1.0, -1.0)
    pd.DataFrame({"t": at, "p": np.repeat([0.0, 10, 30, 20], 50)}).to_csv(tmp_path / "p.csv", index=False)
    seen = {"t": clock, "yaw": (turned - low) % 360 + low}
    seen |= {"qx": 0 * half, "qy": 0 * half, "qz": sign * np.sin(half), "qw": sign * np.cos(half)}
    pd.DataFrame(seen).to_csv(tmp_path / "imu.csv", index=False)
    mapping = {
        "table": "p.csv",
        "time": {"column": "t", "unit": "s"},
        "join": [{"name": "imu", "file": "imu.csv", "time": {"column": "t", "unit": "s"}}],
        "actuation": [{"column": "p", "name": "p", "unit": "kPa"}],
        "observables": [{"column": "imu.yaw", "name": "yaw", "unit": "deg"}]
        + [{"column": f"imu.{q}", "name": q, "unit": "1"} for q in ("qx", "qy", "qz", "qw")],
    }
    (tmp_path / "m.yaml").write_text(yaml.safe_dump(mapping))
    values = import_table(tmp_path / "m.yaml", tmp_path / "run")["observed"].to_numpy().reshape(-1, 5)
    exact = (180.0 if low else 360.0) + 40 * np.sin(at)
    assert np.abs((values[:, 0] - exact + 180) % 360 - 180).max() < 0.1
    assert np.ptp(values[:, 0]) < 90
    assert np.abs(np.linalg.norm(values[:, 1:], axis=1) - 1).max() < 0.01
    other = np.radians(exact) / 2
    assert np.abs(values[:, 3] * np.cos(other) - values[:, 4] * np.sin(other)).max() < 0.01
