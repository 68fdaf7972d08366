"""What is learned from a run: the end of each hold, markers that were seen there, and scans with their set-points."""

from dataclasses import replace
from pathlib import Path
from typing import Any, cast

import numpy as np
import pytest

from labrig import LabrigError
from labrig.campaign import Actuate, Procedure, Record, RigInfo, Scan, Settle, Steps, run
from labrig.log import Layout, open_run
from labrig.log._dataset import CampaignArrays, to_dataset
from labrig.rig import connect, parse_rig
from labrig.surrogate import Frames, frames_of, shots_of
from labrig_drivers import Scan as Scanned
from labrig_drivers import Scanner, SimulatedClock
from labrig_drivers.simulated._artec_twin import obj_bytes


def _run(position, unit="kPa", settled=None):
    """A Dataset of captures of two markers under chambers b and a."""
    F, T = position.shape[:2]
    layout = Layout(("b", "a"), (0.0, 0.0), (60.0, 60.0), unit, ("m1", "m2"))
    commanded = np.stack([np.arange(F) * 1.0, np.arange(F) * 10.0], axis=1)
    arrays = CampaignArrays(
        commanded=commanded,
        hold_s=np.tile(np.arange(T) * 1.0, (F, 1)),
        time_s=np.arange(F * T).reshape(F, T) * 1.0,
        settled=np.ones((F, T), bool) if settled is None else settled,
        event_time_s=np.arange(F) * 1.0 * T,
        event_commanded=commanded,
        session=["1"] * F,
        repeat=[""] * F,
        event_session=["1"] * F,
        event_of=np.arange(F),
        position_mm=position,
    )
    return to_dataset(arrays, layout, {"run": "test"})


def test_the_end_of_each_hold():
    """The median of the second half of the settled rows counts, chambers come in the order asked for."""
    position = np.zeros((2, 6, 2, 3))
    position[0, :, 0, 0] = [50.0, 9.0, 9.0, 1.0, 2.0, 900.0]
    settled = np.ones((2, 6), bool)
    settled[:, 0] = False
    settled[0, 5] = False
    frames = frames_of(_run(position, settled=settled), ("a", "b"))
    assert frames.position_mm[0, 0, 0] == 1.5
    assert frames.pressure_kpa.tolist() == [[0.0, 0.0], [10.0, 1.0]]


def test_markers_that_were_hidden():
    """A marker that most rows of the end did not see is not captured; a frame without any is left out."""
    position = np.zeros((3, 4, 2, 3))
    position[0, 2:, 1] = np.nan
    position[1] = np.nan
    frames = frames_of(_run(position), ("b", "a"))
    assert len(frames) == 2
    assert frames.captured.tolist() == [[True, False], [True, True]]
    assert frames.complete.tolist() == [False, True]


def test_runs_are_joined():
    """Frames of several runs are all there, each marker by its name, and what a run does not have is not captured."""
    one = Frames(("m1", "m2"), np.zeros((1, 2)), np.array([[[1.0] * 3, [2.0] * 3]]))
    two = Frames(("m3", "m1"), np.ones((2, 2)), np.array([[[3.0] * 3, [4.0] * 3]] * 2))
    joined = Frames.joined([one, two])
    assert joined.marker_names == ("m1", "m2", "m3")
    assert joined.pressure_kpa.tolist() == [[0.0, 0.0], [1.0, 1.0], [1.0, 1.0]]
    expected = [[1.0, 2.0, np.nan], [4.0, np.nan, 3.0], [4.0, np.nan, 3.0]]
    np.testing.assert_array_equal(joined.position_mm[..., 0], expected)


def test_visits_of_one_set_point():
    """Visits of one set-point are one frame: the mean over those that saw the marker."""
    position = np.zeros((3, 2, 3))
    position[:, 0, 0] = [1.0, 5.0, 3.0]
    position[2, 1] = np.nan
    frames = Frames(("m1", "m2"), np.array([[7.0, 0.0], [2.0, 0.0], [7.0, 0.0]]), position)
    assert frames.set_points().tolist() == [0, 1, 0]
    merged = frames.merged()
    assert merged.pressure_kpa.tolist() == [[7.0, 0.0], [2.0, 0.0]]
    assert merged.position_mm[:, 0, 0].tolist() == [2.0, 5.0]
    assert merged.captured.all()


def test_pressures_in_another_unit():
    """A run in psi is converted, as it is for a model that is diagnosed."""
    frames = frames_of(_run(np.zeros((2, 6, 2, 3)), "psi"), ("a", "b"))
    np.testing.assert_allclose(frames.pressure_kpa, [[0.0, 0.0], [68.94757, 6.894757]], rtol=1e-6)


@pytest.mark.parametrize(
    ("chambers", "unit", "complaint"),
    [
        (("a", "c"), "kPa", "test: its chambers (b, a) are not the forward model's (a, c)"),
        (("a", "b"), "mm", "test: the forward model needs pressures; its are in mm"),
    ],
)
def test_other_rigs_are_refused(chambers, unit, complaint):
    """Chambers of other names and what is no pressure are named."""
    with pytest.raises(LabrigError) as caught:
        frames_of(_run(np.zeros((1, 2, 2, 3)), unit), chambers)
    assert str(caught.value) == complaint


def test_nothing_was_seen():
    """A run in which no marker was ever seen is refused."""
    with pytest.raises(LabrigError) as caught:
        frames_of(_run(np.full((1, 2, 2, 3), np.nan)), ("a", "b"))
    assert str(caught.value) == "test: no marker was seen at the end of any hold"


class _Two(Procedure):
    """Two set-points, the second one scanned."""

    def steps(self, rig: RigInfo) -> Steps:
        """Actuate, settle, record, scan."""
        for share in (0.2, 0.5):
            yield Actuate([60.0 * share, 0.0, 0.0, 30.0])
            yield Settle(0.5)
            yield Record(0.1)
        yield Scan()


class _InCentimetres:
    """A scanner whose files are OBJ, in cm."""

    def __init__(self, scanner: Scanner, folder: Path) -> None:
        self._scanner, self._folder = scanner, folder

    def __getattr__(self, name: str) -> Any:
        return getattr(self._scanner, name)

    def scan(self, timeout_s: float = 120.0) -> Scanned:
        """The same surface in a file."""
        scan = self._scanner.scan(timeout_s)
        path = self._folder / "export.obj"
        path.write_bytes(obj_bytes(scan.vertices_mm / 10.0, scan.triangles, "export.mtl", False))
        return replace(scan, files=(path,), unit="cm")


def test_scans_of_a_run(tmp_path):
    """A scan comes with the set-point that it was taken at, whatever unit the scanner's files are in."""
    content = {
        "name": "sheet",
        "chambers": [{"name": f"c{i}", "min_kpa": 0, "max_kpa": 60} for i in (1, 2, 3, 4)],
        "pressure": {"kind": "simulated"},
        "mocap": {"kind": "simulated"},
        "scanner": {"kind": "simulated"},
        "simulated": {"surface": "membrane"},
    }
    clock = SimulatedClock(0.0)
    rig = connect(parse_rig(content, "rig", Path()), clock)
    run(_Two(), rig, tmp_path / "run", clock)
    (whole,) = shots_of(tmp_path / "run", ("c1", "c2", "c3", "c4"))
    assert rig.scanner is not None
    rig.scanner = cast(Any, _InCentimetres(rig.scanner, tmp_path))
    run(_Two(), rig, tmp_path / "in_cm", clock)
    rig.close()
    (same,) = shots_of(tmp_path / "in_cm", ("c1", "c2", "c3", "c4"))
    np.testing.assert_allclose(
        np.ptp(same.mesh.vertices_mm, axis=0), np.ptp(whole.mesh.vertices_mm, axis=0), rtol=0.02
    )
    shots = shots_of(tmp_path / "run", ("c4", "c1", "c2", "c3"))
    assert [shot.name for shot in shots] == ["000/scan.ply"]
    assert shots[0].pressure_kpa.tolist() == [30.0, 30.0, 0.0, 0.0]
    assert len(shots[0].mesh.triangles) > 1000
    assert len(frames_of(open_run(tmp_path / "run"), ("c1", "c2", "c3", "c4"))) == 2
