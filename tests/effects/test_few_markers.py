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


def test_a_ball_that_goes_up_always_as_far_meets_no_plane(few_effects) -> None:
    """Where a model's ball goes up at one set-point only, to the last digit, no plane stands before it, and nothing
    fails.
    """

    def lifted(u: np.ndarray) -> np.ndarray:
        up = np.where(u[:, 1] % 2 == 1, np.nextafter(37.1, 40), 37.1) * (u[:, 0] > 50)
        return np.stack([0.5 * u[:, 0], 0.5 * u[:, 1], up, 0.3 * u[:, 0]], axis=1)

    few_effects("contact")

    u = np.tile([[60.0, 41.0], [0.0, 40.0], [30.0, 0.0], [45.0, 20.0], [10.0, 10.0]], (20, 1))
    u[:10:5, 1] = 40.0
    seen = lifted(u) + np.random.default_rng(3).normal(0, 0.1, (len(u), 4))
    seen[:, 2] -= 2.0 * (u[:, 0] > 50)
    columns = {"t (s)": 5.0 * np.arange(len(u)), "p1 (kPa)": u[:, 0], "p2 (kPa)": u[:, 1]}
    names = ["ball_x (mm)", "ball_y (mm)", "ball_z (mm)", "pitch (deg)"]
    run = labrig.import_table(pd.DataFrame(columns | dict(zip(names, seen.T, strict=True))), "run")
    assert labrig.diagnose(run, lifted).summary["verdict"]
