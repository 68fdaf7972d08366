"""One camera sees a finger that bends in a plane, in pixels, and no longer looks square at it."""

from pathlib import Path

import numpy as np
import pandas as pd
import pytest
import xarray as xr

import labrig
from labrig.diagnosis import compare, diagnose
from labrig.model import Model

MARKERS, LENGTH_PX, AWAY_PX = 6, 300.0, 1500.0
SHARE = (np.arange(MARKERS) + 1) / MARKERS


def finger(u: np.ndarray) -> np.ndarray:
    """Markers along a finger whose two chambers bend it, the second its outer half alone; (F, 2 M)."""
    whole, outer = 0.01 * u[:, :1] * (1 - 0.004 * u[:, :1]), 0.015 * u[:, 1:]
    angle = whole * SHARE + outer * np.clip(SHARE - 0.5, 0, 1)
    along = LENGTH_PX * SHARE
    return np.stack([400 + along * np.cos(angle), 300 + along * np.sin(angle)], axis=2).reshape(len(u), -1)


def turned(places: np.ndarray, angle_deg: float, about: np.ndarray) -> np.ndarray:
    """What a pinhole sees of a plane that was turned about a line in it, by the pinhole's own formula."""
    plane = places.reshape(len(places), -1, 2)
    middle = plane.mean(axis=(0, 1))
    line = about / np.linalg.norm(about)
    across, angle = np.array([-line[1], line[0]]), np.deg2rad(angle_deg)
    far = (plane - middle) @ across
    flat = ((plane - middle) @ line)[..., None] * line + (far * np.cos(angle))[..., None] * across
    seen = flat * AWAY_PX / (AWAY_PX - far * np.sin(angle))[..., None]
    return (middle + seen).reshape(places.shape)


def bent(places: np.ndarray) -> np.ndarray:
    """The finger was cast bent, as a spiral is: the outer the more."""
    off = 1.5 * SHARE**3
    return places + np.stack([-0.3 * off, off], axis=1).ravel()


def campaign(folder: Path, seed: int, off: np.ndarray, noise: float) -> xr.Dataset:
    """Sixty set-points, ten of them again; `off` is what is seen more."""
    rng = np.random.default_rng(seed)
    values = finger(set_points(seed)) + off + noise * rng.normal(size=(70, 2 * MARKERS))
    names = [f"m{m}_{axis}_px" for m in range(MARKERS) for axis in "xy"]
    table = pd.DataFrame(np.column_stack([set_points(seed), values]), columns=["p1_kPa", "p2_kPa", *names])
    return labrig.import_table(table, folder / f"run{seed}")


def set_points(seed: int) -> np.ndarray:
    """Pressures, kPa, (70, 2)."""
    u = np.random.default_rng([seed, 1]).uniform(0, 60, (70, 2)).round(1)
    u[60:] = u[:10]
    return u


@pytest.mark.parametrize("about", [(0.0, 1.0), (1.0, -0.4)], ids=["up", "aslant"])
def test_a_camera_that_looks_aslant_is_the_frame(tmp_path: Path, about: tuple[float, float]) -> None:
    """It is named before all others, and its formula holds on another programme."""
    off = [turned(finger(set_points(s)), 6.0, np.array(about)) - finger(set_points(s)) for s in (1, 2)]
    noise = float(np.sqrt((off[0] ** 2).mean())) / 3
    found = diagnose(campaign(tmp_path, 1, off[0], noise), Model.of(finger))
    names = {e["effect"]: e["probability"] for e in found.summary["effects_considered"]}
    assert names.pop("frame") > 0.5
    assert max(names.values()) < 0.1
    assert found.improved is not None
    (effect,) = found.improved.file.effects
    assert effect.form == "seen aslant"
    later = compare(campaign(tmp_path, 2, off[1], noise), found.improved).summary["error"]
    assert later["model"] < 1.15 * later["floor"]


def test_a_finger_that_was_cast_bent_is_no_frame(tmp_path: Path) -> None:
    """No view of a plane bends what is straight."""
    off = bent(finger(set_points(3))) - finger(set_points(3))
    noise = float(np.sqrt((off**2).mean())) / 3
    found = diagnose(campaign(tmp_path, 3, off, noise), Model.of(finger)).summary
    names = {e["effect"]: e["probability"] for e in found["effects_considered"]}
    assert max(names, key=names.__getitem__) == "rest_shape"
    assert names["frame"] < 0.1
