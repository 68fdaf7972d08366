"""Sensors that see one coordinate of a place each, such as lasers that look down: where they look is known."""

from collections.abc import Callable
from pathlib import Path
from typing import TYPE_CHECKING, Any

import numpy as np
import pandas as pd
import pytest
import yaml

import labrig
from labrig.diagnosis import rows_from
from labrig.effects._fields import frame_modes
from labrig.log import write_dataset
from labrig.model import Model
from tests.naming import verdict_of

if TYPE_CHECKING:
    import xarray as xr

Law = Callable[[np.ndarray], np.ndarray]
LASERS = [f"L{k}" for k in range(12)]
PLACES_MM = np.array([[x, y, 0.0] for y in (0.0, 25.0, 50.0) for x in (0.0, 35.0, 70.0, 105.0)])
BASE = """
import numpy as np

PLACES = np.array({places})


def predict(actuation):
    apart = np.abs(PLACES[:, None, 0] - np.array([15.0, 55.0, 90.0])) + 0.5 * np.abs(PLACES[:, None, 1] - 25.0)
    return (actuation * (1 - actuation / 150.0)) @ (0.08 * np.exp(-apart / 30.0)).T
"""


def sheet(u: np.ndarray) -> np.ndarray:
    """Heights, mm, over three chambers, (n, 12)."""
    apart = np.abs(PLACES_MM[:, None, 0] - np.array([15.0, 55.0, 90.0]))
    apart = apart + 0.5 * np.abs(PLACES_MM[:, None, 1] - 25.0)
    return (u * (1 - u / 150.0)) @ (0.08 * np.exp(-apart / 30.0)).T


def tipped(heights: np.ndarray, about_x_rad: float, about_y_rad: float, up_mm: float) -> np.ndarray:
    """What a gantry reads that was set down tipped: the points themselves are turned, exactly, about a corner of it."""
    cx, sx, cy, sy = np.cos(about_x_rad), np.sin(about_x_rad), np.cos(about_y_rad), np.sin(about_y_rad)
    turn = np.array([[cy, 0, sy], [0, 1, 0], [-sy, 0, cy]]) @ np.array([[1, 0, 0], [0, cx, -sx], [0, sx, cx]])
    points = np.concatenate(
        [np.broadcast_to(PLACES_MM[:, :2], (len(heights), 12, 2)), heights[..., None]], axis=2
    )
    return (points @ turn.T)[..., 2] + up_mm


def warped(heights: np.ndarray) -> np.ndarray:
    """A sheet that was moulded with a dome between two of its chambers."""
    x, y = PLACES_MM[:, 0], PLACES_MM[:, 1]
    return heights + 0.4 * np.exp(-((x - 35.0) ** 2 + (y - 30.0) ** 2) / 600.0)


def campaign(law: Law, folder: Path, rest: bool = True) -> "xr.Dataset":
    """60 set-points anywhere, ten of them again, one reading a hold; with where the lasers look, or without."""
    random = np.random.default_rng(5)
    u = random.uniform(0, 30, (60, 3)).round(1)
    u = np.concatenate([u, u[20:30]])
    z = law(sheet(u)) + random.normal(0, 0.05, (len(u), 12))
    table = pd.DataFrame({"t": 20.0 * np.arange(len(u))})
    table = table.join(pd.DataFrame(u, columns=[f"p{c}" for c in range(3)]))
    table.join(pd.DataFrame(z, columns=LASERS)).to_csv(folder / "t.csv", index=False)
    mapping: dict[str, Any] = {
        "table": "t.csv",
        "time": {"column": "t", "unit": "s"},
        "settle_s": 15,
        "actuation": [
            {"column": f"p{c}", "name": f"p{c}", "unit": "kPa", "min": 0, "max": 30} for c in range(3)
        ],
        "observables": [
            {"column": name, "name": name, "unit": "mm", "marker": name, "axis": "z"} for name in LASERS
        ],
    }
    if rest:
        places = zip(LASERS, PLACES_MM.tolist(), strict=True)
        mapping["markers"] = {name: {"rest": place} for name, place in places}
    (folder / "map.yaml").write_text(yaml.safe_dump(mapping))
    return labrig.import_table(folder / "map.yaml", folder / "run")


def model(folder: Path) -> Model:
    """The sheet, rightly."""
    (folder / "base.py").write_text(BASE.format(places=PLACES_MM.tolist()))
    (folder / "model.yaml").write_text("base: {kind: python, file: base.py, function: predict}\n")
    return Model.load(folder / "model.yaml")


def test_where_they_look_is_kept(tmp_path: Path) -> None:
    """What a mapping says of places at rest is in the run, also of markers of which one coordinate is measured."""
    run = campaign(lambda z: z, tmp_path)
    assert run["rest_x_mm"].values == pytest.approx(PLACES_MM[:, 0])
    assert (run["rest_y_mm"].attrs["units"], run["rest_y_mm"].dims) == ("mm", ("observable",))
    assert rows_from(run).rest_mm == pytest.approx(PLACES_MM)
    kept = labrig.open_run(write_dataset(run, tmp_path / "again", run_yaml={}))
    assert rows_from(kept).rest_mm == pytest.approx(PLACES_MM)
    some = rows_from(run.isel(observable=[3, 7]))
    assert some.rest_mm == pytest.approx(PLACES_MM[[3, 7]])


def test_without_places_there_are_none(tmp_path: Path) -> None:
    """A mapping that says nothing of places leaves none in the run."""
    run = campaign(lambda z: z, tmp_path, rest=False)
    assert "rest_x_mm" not in run.coords
    assert rows_from(run).rest_mm is None


def test_a_turn_moves_heights_by_where_they_are(tmp_path: Path) -> None:
    """To first order a turn about x lifts each height by its y, and one about y lowers it by its x."""
    rows = rows_from(campaign(lambda z: z, tmp_path))
    modes = frame_modes(model(tmp_path).predictor(rows).context(rows))
    around = PLACES_MM - PLACES_MM.mean(axis=0)
    assert modes[0, :, 2] == pytest.approx(1.0)
    assert modes[0, :, 3] == pytest.approx(around[:, 1])
    assert modes[0, :, 4] == pytest.approx(-around[:, 0])
    assert not modes[:, :, [0, 1, 5]].any()


def test_a_gantry_that_was_set_down_tipped_is_a_frame(tmp_path: Path) -> None:
    """Heights that lie on a tilted plane are what one motion of the measuring frame makes, and no other rest shape."""
    found = verdict_of(campaign(lambda z: tipped(z, 0.002, -0.0015, 0.08), tmp_path), model(tmp_path))
    of = {one.effect: one for one in found.considered}
    assert found.considered[0].effect == "frame"
    assert of["frame"].by_evidence > 0.9
    assert of["rest_shape"].probability < 0.1


def test_a_sheet_with_a_dome_is_a_rest_shape(tmp_path: Path) -> None:
    """What no motion of the frame makes is not the frame's."""
    found = verdict_of(campaign(warped, tmp_path), model(tmp_path))
    assert found.effects == ("rest_shape",)
    assert {one.effect: one for one in found.considered}["frame"].probability < 0.1
