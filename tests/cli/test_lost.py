"""A marker that falls off during a run is said at its end, and when it is looked at."""

from pathlib import Path

import pytest
import yaml

DEVICES = """
import math
from pathlib import Path
import numpy as np
from labrig_drivers import Identity, MarkerFrame, PressureSample, VentReport

SET = Path("set")

class Valve:
    def __init__(self, name, clock, channels):
        self.name, self.clock, self.channels = name, clock, channels
        self.kpa = np.zeros(len(channels))
    def connect(self): pass
    def identify(self): return Identity(self.name, "valve", "a valve")
    def set(self, pressure_kpa):
        if not np.array_equal(self.kpa, pressure_kpa):
            with SET.open("a") as file:
                file.write("x")
        self.kpa = np.array(pressure_kpa)
    def samples(self): return [PressureSample(self.clock.now_s(), self.kpa)]
    def vent(self, timeout_s=10.0):
        self.kpa = np.zeros_like(self.kpa)
        return VentReport(self.kpa, 0.0)
    def close(self): pass

class Camera:
    def __init__(self, clock, marker_names):
        self.clock, self.marker_names, self.last = clock, marker_names, None
    def connect(self): pass
    def identify(self): return Identity("", "camera", "a camera")
    def frames(self):
        now = math.floor(20 * self.clock.now_s())
        first, self.last = (self.last or now) + 1, now
        return [self.frame(tick) for tick in range(first, now + 1)]
    def frame(self, tick):
        x = np.zeros((2, 3))
        lost = SET.exists() and SET.stat().st_size >= 3
        if lost:
            x[1] = np.nan
        return MarkerFrame(tick / 20, tick, x, np.array([0, int(lost)], np.int8))
    def close(self): pass
"""


def test_a_marker_that_falls_off_is_said(tmp_path: Path, monkeypatch: pytest.MonkeyPatch, labrig) -> None:
    """`run` ends with the marker, how many captures lack it and since when; `show` says it again."""
    monkeypatch.chdir(tmp_path)
    rig = {
        "name": "small",
        "chambers": [{"name": "c1", "max_kpa": 60, "slew_kpa_s": 100000}],
        "markers": ["m01", "m02"],
        "pressure": {"kind": "python", "file": "devices.py", "class": "Valve"},
        "mocap": {"kind": "python", "file": "devices.py", "class": "Camera"},
    }
    Path("rig.yaml").write_text(yaml.safe_dump(rig))
    Path("devices.py").write_text(DEVICES)
    quick = ("--repeated", "0", "--settle-s", "0.1", "--record-s", "0.2", "--captures", "4")
    code, out, err = labrig("run", "capture", "--rig", "rig.yaml", "--out", "one", *quick)
    assert (code, out.startswith("one: 4 captures in ")) == (0, True)
    said = next(line for line in err.splitlines() if "m02" in line).removeprefix("labrig: ")
    assert said.startswith("m02 was not seen in 2 of 4 captures (")
    assert "not once since capture " in said
    assert f"markers: {said}" in labrig("show", "one")[1]
