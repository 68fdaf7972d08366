"""A camera that was shifted, before a straight arm: the frame, and no other shape of the arm."""

from pathlib import Path

import numpy as np
import pandas as pd
import pytest

import labrig
from labrig.diagnosis import diagnose
from labrig.model import Model
from tests.conftest import HIGH_KPA
from tests.naming import verdict_of

MARKERS, LENGTH_MM = 6, 140.0
REST = np.array([[0.0, 0.0, -LENGTH_MM * (m + 1) / MARKERS] for m in range(MARKERS)])


def arm(u: np.ndarray) -> np.ndarray:
    """Markers along an arm that bends with constant curvature, by two pressures in kPa, (F, 3 M)."""
    places = []
    for share in (np.arange(MARKERS) + 1) / MARKERS:
        angle = 0.015 * np.hypot(u[:, 0], u[:, 1]) * share + 1e-9
        way, length = np.arctan2(u[:, 1], u[:, 0]), LENGTH_MM * share
        out = length * (1 - np.cos(angle)) / angle
        places += [out * np.cos(way), out * np.sin(way), -length * np.sin(angle) / angle]
    return np.stack(places, axis=1)


def sagging() -> np.ndarray:
    """The arm was cast bent: a cantilever's deflection under its own weight, at each marker, (3 M,)."""
    x = -REST[:, 2] / LENGTH_MM
    down = 2.0 * x**2 * (x**2 - 4 * x + 6) / 3
    return np.column_stack([down, 0 * x, 0 * x]).ravel()


@pytest.mark.parametrize(
    ("off", "first"),
    [(np.tile([0.5, -0.3, 0.2], MARKERS), "frame"), (sagging(), "rest_shape")],
    ids=["shifted", "cast bent"],
)
def test_what_moves_all_markers_alike_is_no_shape(tmp_path: Path, off: np.ndarray, first: str) -> None:
    """Markers that all are off by the same are the camera's; a rest shape is what no rigid motion removes."""
    rng = np.random.default_rng(2)
    u = rng.uniform(0, 60, (60, 2)).round(1)
    u[50:] = u[:10]
    values = arm(u) + off + 0.12 * rng.normal(size=(60, 3 * MARKERS))
    names = [f"m{m}_{axis}_mm" for m in range(MARKERS) for axis in "xyz"]
    table = pd.DataFrame(np.column_stack([u, values]), columns=["p1_kPa", "p2_kPa", *names])
    run = labrig.import_table(table, tmp_path / "run")
    run["rest_mm"] = (("marker", "axis"), REST)
    effects = {c.effect: c.probability for c in verdict_of(run, Model.of(arm)).considered}
    other = {"frame": "rest_shape", "rest_shape": "frame"}[first]
    assert next(iter(effects)) == first
    assert effects[first] > 0.5
    assert effects[other] < 0.2


def test_what_a_lens_makes_has_no_name(make_lab, few_effects, monkeypatch) -> None:
    """A fisheye whose image is read as a pinhole's draws in what is far aside: no motion of the frame does that. Where
    a formula would explain nearly all of it, or half here, that is said.
    """
    few_effects("frame", "rest_shape", "gravity", "tension", "stiffening", "regulator")
    monkeypatch.setattr("labrig.diagnosis._notes._NEARLY", 0.5)
    lab = make_lab(chambers=3, markers=12, captures=60)
    places = lab.predict(lab.u).reshape(*lab.u.shape[:2], -1, 3)
    away = places - places.mean(axis=(0, 1, 2))
    far = np.linalg.norm(away[..., :2], axis=-1, keepdims=True) / 40.0
    drawn = np.where([True, True, False], away * np.arctan(far) / far, away)
    drawn *= (away * drawn).sum() / (drawn**2).sum()
    seen = lab.predict(lab.u) + 0.1 * (drawn - away).reshape(*lab.u.shape[:2], -1)
    size = float(np.sqrt(np.mean((seen - lab.predict(lab.u)) ** 2)))
    found = diagnose(lab.dataset(seen + size / 3 * lab.noise(0.5, 1.0) / 1.05), lab.model()).summary
    assert (found["verdict"], found["carried_by"]) == ("unknown", "place, as through a lens")
    (line,) = (w for w in found["warnings"] if w.startswith("the formula of"))
    assert line.endswith(f"labrig improve --add {found['ranking'][0]['effect']}")


def test_a_shape_of_many_markers_is_named(make_lab) -> None:
    """What is off at twenty markers, in humps between the chambers, and a tenth less where they are full, is the rest
    shape.
    """
    lab = make_lab(markers=20, captures=45)
    apart = lab.rest_mm[:, None] - lab.rest_mm[[5, 13]]
    off = 1 / (1 + (apart**2).sum(axis=2) / 120) @ np.array([[0.2, 0.1, 1.0], [0.3, 0.0, -0.8]])
    values = lab.predict(lab.u) + (1 - 0.1 * lab.u.mean(axis=-1, keepdims=True) / HIGH_KPA) * off.ravel()
    size = float(np.sqrt(np.mean(off**2)))
    found = verdict_of(lab.dataset(values + size / 3 * lab.noise(0.5, 1.0) / 1.05), lab.model())
    assert (found.verdict, found.effects) == ("identified", ("rest_shape",))
