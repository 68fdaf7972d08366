"""Recordings: whole, arranged, and drawn without a complaint."""

import subprocess
import sys
from pathlib import Path

import numpy as np
import pytest
import xarray as xr
from PIL import Image

from labrig import LabrigError
from labrig.view import _recording, screenshot, write_recording
from labrig.view._colours import rgb
from labrig.view._fields import residuals, rms
from labrig.view._legend import legend_picture
from labrig.view._recording import worst_number
from labrig.view._scene import CHAMBER_COLOURS
from labrig.view._style import ERROR_SCALE
from labrig.view._viewer import quiet_environment, viewer_path

drawing = pytest.mark.skipif(
    sys.platform == "linux" and not any(Path("/usr/share/vulkan/icd.d").glob("*.json")),
    reason="no Vulkan driver here: apt-get install mesa-vulkan-drivers libvulkan1",
)


def rrd(*arguments):
    """Ask rerun's own tool about a recording."""
    command = [str(viewer_path()), "rrd", *map(str, arguments)]
    ran = subprocess.run(
        command, capture_output=True, text=True, timeout=180, check=True, env=quiet_environment()
    )
    return ran.stdout + ran.stderr


def entities(path):
    """The entity paths of a recording."""
    printed = rrd("print", path)
    return {word.rstrip(",") for word in printed.split() if word.startswith("/")}


@pytest.fixture(scope="module")
def recording(make_result, tmp_path_factory):
    """A recording of the made-up result."""
    return write_recording(make_result(), tmp_path_factory.mktemp("recording") / "demo.rrd")


@pytest.fixture(scope="module")
def run():
    """Three captures of four rows of the markers of a small plate, two chambers; m1 is not seen in the second."""
    captures, rows = 3, 4
    rest = np.array([[x, y, 0.0] for x in (0.0, 50.0, 100.0) for y in (0.0, 50.0, 100.0)])
    lift = np.array([0.0, 5.0, 9.0])[:, None, None, None] * np.array([0.0, 0.0, 1.0])
    position = np.broadcast_to(rest, (captures, rows, 9, 3)) + lift
    position[1, :, 1] = np.nan
    time_s = 4.0 * np.arange(captures)[:, None] + 0.1 * np.arange(rows) + 3.0
    return xr.Dataset(
        {
            "commanded": (("capture", "chamber"), np.array([[0, 0], [30, 0], [50, 10.0]]), {"units": "kPa"}),
            "measured": (("capture", "time", "chamber"), np.full((captures, rows, 2), 20.0)),
            "position_mm": (("capture", "time", "marker", "axis"), position),
            "time_s": (("capture", "time"), time_s),
            "event_time_s": ("event", np.array([0.0, 4.0, 8.0])),
            "event_commanded": (("event", "chamber"), np.array([[0, 0], [30, 0], [50, 10.0]])),
            "rest_mm": (("marker", "axis"), rest),
        },
        coords={"chamber": ["c1", "c2"], "marker": [f"m{i}" for i in range(9)], "axis": ["x", "y", "z"]},
        attrs={"run": "plate", "warnings": ["log.000.mcap: cut at byte 900; 1 capture is lost"]},
    )


def test_recording_is_whole(recording):
    """rerun's own check finds nothing wrong, and what a person looks for is in it, before and after."""
    assert "verified without error" in rrd("verify", recording)
    kinds = ("surface", "measured", "predicted", "occluded", "residual")
    wanted = {f"/{root}/{kind}" for root in ("before", "after") for kind in kinds}
    wanted |= {"/error/before", "/error/after", "/error/floor", "/commanded/c1", "/verdict"}
    assert wanted <= entities(recording)


def test_nothing_missing_has_no_after(make_result, tmp_path):
    """Without an improvement there is one surface, not two that are the same."""
    error = {"base": 0.11, "model": 0.11, "floor": 0.11}
    result = make_result(verdict="nothing_missing", effects=[], error=error)
    found = entities(write_recording(result, tmp_path / "x.rrd"))
    assert "/before/surface" in found
    assert not {path for path in found if path.startswith("/after") or path == "/error/after"}


def test_without_geometry_there_are_curves(make_result, fields, tmp_path):
    """A result without markers is recorded as curves and words."""
    found = entities(write_recording(make_result(fields=fields.drop_vars("rest_mm")), tmp_path / "x.rrd"))
    assert "/error/before" in found
    assert "/before/surface" not in found


def test_run_without_a_model(run, tmp_path):
    """A run alone shows markers, surface, and pressures commanded and measured."""
    path = write_recording(run, tmp_path / "run.rrd")
    assert "verified without error" in rrd("verify", path)
    assert {"/rig/surface", "/rig/measured", "/rig/occluded", "/commanded/c2", "/measured/c1"} <= entities(
        path
    )


def test_imported_run_without_markers(run, tmp_path):
    """A run of forces shows the force."""
    force = run.drop_vars(["position_mm", "rest_mm", "marker", "axis"])
    force["observed"] = (("capture", "time", "observable"), np.arange(12.0).reshape(3, 4, 1))
    force = force.assign_coords(observable=["force"], unit=("observable", ["N"]))
    assert "/observed/force" in entities(write_recording(force, tmp_path / "force.rrd"))


@pytest.mark.parametrize("captures", [0, 3])
def test_a_run_in_which_no_marker_was_seen(run, captures, tmp_path):
    """One that ended before its first capture, or whose cameras saw nothing, shows the pressures all the same."""
    blind = run.isel(capture=slice(captures))
    blind = blind.assign(position_mm=blind["position_mm"] * np.nan).drop_vars("rest_mm")
    drawn = entities(write_recording(blind, tmp_path / "run.rrd"))
    assert "/commanded/c2" in drawn
    assert "/rig/measured" not in drawn


def test_a_recording_that_fails_leaves_nothing(run, tmp_path):
    """Nothing half-written stays behind."""
    with pytest.raises(KeyError):
        write_recording(run.drop_vars("event_time_s"), tmp_path / "run.rrd")
    assert list(tmp_path.iterdir()) == []


@drawing
def test_drawn_without_a_complaint(recording, tmp_path):
    """Every view of the arranged window draws, and the surface before has the colours of a large error."""
    complaints = screenshot(recording, tmp_path / "before.png", capture=10)
    assert complaints == []
    with Image.open(tmp_path / "before.png") as image:
        picture = np.asarray(image.convert("RGB")).astype(int)
    height, width = picture.shape[:2]
    before = picture[: height // 2, : width // 3].reshape(-1, 3)
    after = picture[: height // 2, 3 * width // 8 : 11 * width // 16].reshape(-1, 3)

    def red(pixels):
        return int(((pixels[:, 0] > 120) & (pixels[:, 0] > 1.6 * pixels[:, 2])).sum())

    assert red(before) > 5000
    assert red(before) > 3 * red(after)


@drawing
def test_run_drawn_without_a_complaint(run, tmp_path):
    """The recording of a run alone draws, too."""
    path = write_recording(run, tmp_path / "run.rrd")
    assert screenshot(path, tmp_path / "run.png", size="900x600") == []
    with Image.open(tmp_path / "run.png") as image:
        assert image.size == (900, 600)


def test_a_result_opens_at_its_worst_capture(fields):
    """The layout goes to the capture with the largest error, and stays there."""
    from labrig.view import _rerun

    error = rms(residuals(fields)[0], axis=1)
    worst = worst_number(fields)
    assert error[worst] == np.nanmax(error)
    time = _rerun.arrangement(_rerun.page("x", "/x"), "capture", at=worst).time_panel
    assert (time.time_selection.min.value, time.time_selection.max.value) == (worst, worst)
    assert time.loop_mode == "selection"


@pytest.mark.parametrize("chambers", [3, 9, 14])
def test_the_legend_has_the_scale_and_every_chamber(chambers):
    """The picture has the colours of the scale and of each chamber, and grows where there are more."""
    picture = legend_picture(0.125, "mm", [f"c{i}" for i in range(chambers)])
    assert picture.dtype == np.uint8
    seen = np.unique(picture.reshape(-1, 3), axis=0).astype(int)
    for colour in [*CHAMBER_COLOURS[:chambers], *(colour for _, colour in ERROR_SCALE)]:
        assert np.abs(seen - rgb(colour)).max(axis=1).min() <= 6, colour
    assert len(legend_picture(None, "", ["c1"])) < len(picture)


def test_a_disk_that_is_full_is_one_line(tmp_path, monkeypatch):
    """What rerun says of it becomes an error with the recording's name, and nothing is left of the recording."""

    def full(*_):
        raise RuntimeError("Failed to encode: Failed to write: No space left on device (os error 28)")

    monkeypatch.setattr(_recording, "draw", full)
    with pytest.raises(LabrigError) as caught:
        write_recording(xr.Dataset(), tmp_path / "run.rrd")
    path = tmp_path / "run.rrd"
    assert str(caught.value) == (
        f"the recording {path} cannot be written: No space left on device; make room there"
    )
    assert list(tmp_path.iterdir()) == []
