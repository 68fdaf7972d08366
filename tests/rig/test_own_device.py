"""A device whose class somebody wrote: its markers go by their names, and its faults are said with their place."""

from pathlib import Path
from typing import Any

import numpy as np
import pytest

from labrig import LabrigError
from labrig.rig import Rig, connect, parse_rig
from labrig_drivers import DeviceError, MarkerStatus, SimulatedClock

VALVE = """
import numpy as np
from labrig_drivers import Identity, PressureSample, VentReport

class Valve:
    def __init__(self, clock, channels):
        self.clock = clock
    def connect(self): pass
    def identify(self): return Identity("", "valve", "a valve")
    def set(self, pressure_kpa): self.last = pressure_kpa
    def samples(self): return [PressureSample(1.0, np.array([1.0, 2.0]))]
    def vent(self, timeout_s=10.0): return VentReport(np.zeros(2), 0.1)
    def close(self): pass
"""
CAMERA = """
import numpy as np
from labrig_drivers import Identity, MarkerFrame

class Camera:
    marker_names = ["m2", "extra", "m1"]
    def connect(self): pass
    def identify(self): return Identity("", "camera", "a camera")
    def frames(self):
        x = np.array([[2.0, 0, 0], [9.0, 0, 0], [1.0, 0, 0]])
        return [MarkerFrame(1.0, 1, x, np.array([0, 0, 0], np.int8))]
    def close(self): pass
"""


def rig_of(
    folder: Path, valve: str = VALVE, camera: str = CAMERA, markers: tuple[str, ...] = ("m1", "m2")
) -> Rig:
    """A rig of both classes, connected."""
    (folder / "valve.py").write_text(valve, encoding="utf-8")
    (folder / "camera.py").write_text(camera, encoding="utf-8")
    content: dict[str, Any] = {
        "name": "own",
        "chambers": [{"name": "c1", "max_kpa": 60}, {"name": "c2", "max_kpa": 60}],
        "markers": markers,
        "pressure": {"kind": "python", "file": "valve.py", "class": "Valve"},
        "mocap": {"kind": "python", "file": "camera.py", "class": "Camera"},
    }
    return connect(parse_rig(content, "rig.yaml", folder), SimulatedClock())


def test_a_drivers_markers_go_by_their_names(tmp_path: Path) -> None:
    """A driver that names its markers in another order, or more of them, gives each marker of rig.yaml its own."""
    rig = rig_of(tmp_path)
    assert rig.mocap is not None
    frame = rig.mocap.frames()[0]
    assert list(rig.mocap.marker_names) == ["m1", "m2"]
    np.testing.assert_array_equal(frame.position_mm[:, 0], [1, 2])


def test_where_a_marker_was_last_is_not_measured_again(tmp_path: Path) -> None:
    """A driver that repeats the last position of a marker that it does not see, or sees one that is nowhere."""
    camera = CAMERA.replace("[0, 0, 0], np.int8", "[1, 0, 0], np.int8").replace(
        "[1.0, 0, 0]]", "[np.nan, 0, 0]]"
    )
    rig = rig_of(tmp_path, camera=camera)
    assert rig.mocap is not None
    frame = rig.mocap.frames()[0]
    assert np.isnan(frame.position_mm).all()
    np.testing.assert_array_equal(frame.status, [MarkerStatus.OCCLUDED, MarkerStatus.OCCLUDED])


def test_a_driver_that_names_no_markers_keeps_to_the_rig_file(tmp_path: Path) -> None:
    """Without names of its own its rows are those of rig.yaml, in that order."""
    rig = rig_of(tmp_path, camera=CAMERA.replace('["m2", "extra", "m1"]', "[]"), markers=("a", "b", "c"))
    assert rig.mocap is not None
    np.testing.assert_array_equal(rig.mocap.frames()[0].position_mm[:, 0], [2, 9, 1])


@pytest.mark.parametrize(
    ("markers", "names", "said"),
    [
        (
            ("m1", "m3"),
            '["m2", "extra", "m1"]',
            "does not name m3 of rig.yaml's markers (it names m2, extra, m1)",
        ),
        (("m1", "m2"), '["m2", "m1", "m1"]', "names the marker m1 twice"),
        ((), '["m2", "m1", "m1"]', "names the marker m1 twice"),
        ((), "[]", "is empty, and rig.yaml names no markers"),
    ],
)
def test_markers_that_do_not_match_are_refused(
    tmp_path: Path, markers: tuple[str, ...], names: str, said: str
) -> None:
    """A marker that the driver does not name, or names twice, is said before anything is measured."""
    with pytest.raises(DeviceError) as caught:
        rig_of(tmp_path, camera=CAMERA.replace('["m2", "extra", "m1"]', names), markers=markers)
    assert str(caught.value) == (f"mocap: camera.py: Camera.marker_names {said}")


@pytest.mark.parametrize(
    ("old", "new", "said"),
    [
        ("def connect", "def open", "valve.py: Valve has no method connect"),
        (
            'return Identity("", "valve", "a valve")',
            "return None",
            "valve.py: Valve.identify() returned None, not an Identity",
        ),
        ("self.clock = clock", "clock.x", "valve.py, line 7: Valve.__init__: AttributeError"),
        (
            "def connect(self): pass",
            "def connect(self): {}['x']",
            "valve.py, line 8: Valve.connect: KeyError",
        ),
    ],
)
def test_a_class_that_cannot_be_connected_is_said_with_its_place(
    tmp_path: Path, old: str, new: str, said: str
) -> None:
    """A method that is missing, returns nothing or fails names the file, the line, the class and the method."""
    with pytest.raises(DeviceError) as caught:
        rig_of(tmp_path, valve=VALVE.replace(old, new))
    assert str(caught.value).startswith(f"pressure: {said}")


@pytest.mark.parametrize(
    ("code", "said"),
    [
        ("def f(:\n", "valve.py, line 1: is no Python (invalid syntax)"),
        ("import nothing_of_that_name\n", "valve.py, line 1: ModuleNotFoundError: No module named"),
    ],
)
def test_a_file_that_is_no_python_is_said_with_its_line(tmp_path: Path, code: str, said: str) -> None:
    """What the driver's own file has wrong is no bug of labrig's: the file and the line are named."""
    with pytest.raises(LabrigError) as caught:
        rig_of(tmp_path, valve=code)
    assert str(caught.value).startswith(f"rig own: pressure: {tmp_path / said}")


@pytest.mark.parametrize(
    ("old", "new", "said"),
    [
        (
            "[PressureSample(1.0, np.array([1.0, 2.0]))]",
            "None",
            "returned None, not a list of PressureSample",
        ),
        ("np.array([1.0, 2.0])", "np.zeros(3)", "gave 3 pressures where there are 2"),
        ("np.array([1.0, 2.0])", "['a', 'b']", "gave pressures that are no numbers"),
        (
            "PressureSample(1.0, np.array([1.0, 2.0]))",
            "1.0",
            "returned a float, not a PressureSample",
        ),
    ],
)
def test_measurements_of_the_wrong_kind_are_refused(tmp_path: Path, old: str, new: str, said: str) -> None:
    """What `samples` returns is checked, so that nothing fails far from the driver."""
    rig = rig_of(tmp_path, valve=VALVE.replace(old, new))
    with pytest.raises(DeviceError) as caught:
        rig.pressure.samples()
    assert str(caught.value).startswith(f"pressure: valve.py: Valve.samples() {said}")


def test_a_list_of_numbers_will_do(tmp_path: Path) -> None:
    """Pressures in a plain list are taken as an array, of a vent and of the readings after it, which it is told by."""
    lists = VALVE.replace("np.zeros(2)", "[0.0, 0.0]").replace("np.array([1.0, 2.0])", "[1.0, 2.0]")
    assert rig_of(tmp_path, valve=lists).vent().pressure_kpa.tolist() == [1.0, 2.0]


def test_frames_and_vents_of_the_wrong_kind_are_refused(tmp_path: Path) -> None:
    """Positions without a marker, and a vent that reports nothing, are said with the method."""
    valve = VALVE.replace("return VentReport(np.zeros(2), 0.1)", "pass")
    rig = rig_of(tmp_path, valve=valve, camera=CAMERA.replace(", [1.0, 0, 0]]", "]"))
    with pytest.raises(DeviceError, match=r"Camera.frames\(\) gave 2 x 3 coordinates where there are 3 x 3"):
        rig.mocap.frames()  # type: ignore[union-attr]
    with pytest.raises(DeviceError, match=r"valve.py: Valve.vent\(\) returned None, not a VentReport"):
        rig.vent()


def test_a_driver_that_ends_the_program_has_failed(tmp_path: Path) -> None:
    """A vendor's library that calls `sys.exit` is a device that failed, also in a vent, which is not confirmed."""
    body = "return VentReport(np.zeros(2), 0.1)"
    assert body in VALVE
    rig = rig_of(tmp_path, valve=VALVE.replace(body, "raise SystemExit(0)"))
    with pytest.raises(DeviceError, match=r"valve\.py, line \d+: Valve\.vent: calls sys\.exit"):
        rig.vent()
