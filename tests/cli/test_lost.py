"""A marker that falls off during a run is said at its end, and when it is looked at."""

from pathlib import Path

import pytest
import yaml

CAMERA = """
import math
import numpy as np
from labrig_drivers import Identity, MarkerFrame

class Camera:
    def __init__(self, clock, marker_names):
        self.clock, self.marker_names, self.last = clock, marker_names, None
        self.start = clock.now_s()
    def connect(self): pass
    def identify(self): return Identity("", "camera", "a camera")
    def frames(self):
        now = math.floor(20 * self.clock.now_s())
        first, self.last = (self.last or now) + 1, now
        return [self.frame(tick) for tick in range(first, now + 1)]
    def frame(self, tick):
        x = np.zeros((2, 3))
        lost = tick / 20 > self.start + 1.5
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
        "chambers": [{"name": f"c{n}", "max_kpa": 60} for n in range(1, 10)],
        "markers": ["m01", "m02"],
        "pressure": {"kind": "simulated"},
        "mocap": {"kind": "python", "file": "camera.py", "class": "Camera"},
        "simulated": {"surface": "mannequin", "seed": 0},
    }
    Path("rig.yaml").write_text(yaml.safe_dump(rig))
    Path("camera.py").write_text(CAMERA)
    quick = ("--repeated", "0", "--settle-s", "0.1", "--record-s", "0.2", "--captures", "4")
    code, out, err = labrig("run", "capture", "--rig", "rig.yaml", "--out", "one", *quick)
    assert (code, out.startswith("one: 4 captures in ")) == (0, True)
    said = next(line for line in err.splitlines() if "m02" in line).removeprefix("labrig: ")
    assert said.startswith("m02 was not seen in ")
    assert " of 4 captures (" in said
    assert "not once since capture " in said
    assert f"markers: {said}" in labrig("show", "one")[1]
