"""One ball or two beside another sensor: an offset of one may be the frame's, and one of two may slip."""

import numpy as np
import pandas as pd
import pytest

import labrig
from labrig.model import Model
from tests.naming import calls_of, verdict_of


def neck(u: np.ndarray) -> np.ndarray:
    """Two bellows pitch a head that carries two balls, mm, side by side; an inclinometer tells its pitch, deg."""
    pitch = np.deg2rad(0.35 * (u[:, 0] - u[:, 1]))
    high = 80.0 + 0.05 * (u[:, 0] + u[:, 1])
    ball = [high * np.sin(pitch), 0.02 * u[:, 0], high * np.cos(pitch)]
    other = [0.6 * ball[0], ball[1] + 25.0, 0.6 * ball[2]]
    return np.stack([*ball, *other, np.rad2deg(pitch)], axis=1)


def one_ball(u: np.ndarray) -> np.ndarray:
    """The same with the first ball alone."""
    return neck(u)[:, [0, 1, 2, 6]]


def campaign(base, moved, seed: int):
    """60 set-points anywhere and ten of them again, two rows each, in which the first ball is `moved` (F, 3)."""
    random = np.random.default_rng(seed)
    u = random.uniform(0, 60, (60, 2))
    u = np.concatenate([u, u[20:30]])
    seen = base(u)
    seen[:, :3] += moved(len(u))
    rows = np.repeat(np.arange(len(u)), 2)
    seen = seen[rows] + random.normal(0, 0.1, (len(rows), seen.shape[1]))
    columns = {"t (s)": 8.0 * rows + np.tile([3, 6], len(u)), "p1 (kPa)": u[rows, 0], "p2 (kPa)": u[rows, 1]}
    balls = [f"{ball}_{axis} (mm)" for ball in ("ball", "second")[: seen.shape[1] // 3] for axis in "xyz"]
    return labrig.import_table(
        pd.DataFrame(columns | dict(zip([*balls, "pitch (deg)"], seen.T, strict=True))), "run"
    )


@pytest.fixture(autouse=True)
def _there(tmp_path, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.chdir(tmp_path)


def shifted(count: int) -> np.ndarray:
    """A camera whose place is off."""
    return np.tile([0.4, -0.3, 0.2], (count, 1))


def peeled(count: int) -> np.ndarray:
    """A ball on a thread of glue that gives way at capture 33, most of it at once, the rest as an exponential."""
    since = np.arange(count) - 33
    gone = np.where(since >= 0, 1 - 0.4 * np.exp(-np.maximum(since, 0) / 6.0), 0.0)
    return gone[:, None] * np.array([0.7, 0.3, -0.5])


def test_one_ball_that_is_off_may_be_the_frame() -> None:
    """Of a single marker any offset is a rigid motion's, too: that a body has another shape is not called sure."""
    calls = calls_of(campaign(one_ball, shifted, 1), Model.of(one_ball))
    assert calls["frame"] == "possible"
    assert calls["rest_shape"] == "possible"


def test_one_ball_of_two_that_slips_is_named() -> None:
    """The other one saw nothing at that moment, so no camera was moved."""
    assert verdict_of(campaign(neck, peeled, 2), Model.of(neck)).effects == ("marker_slip",)


def test_a_single_ball_that_jumps_has_no_name() -> None:
    """It may have slipped, or its camera was moved: nothing says which, so neither is sure."""
    told = verdict_of(campaign(one_ball, peeled, 2), Model.of(one_ball))
    assert not [c.effect for c in told.considered if c.call == "sure"]
