"""A computer that is busy is no fault of a link: a rig that is simulated in the run's own process has none."""

from pathlib import Path
from typing import Any

import pytest

from labrig import open_run
from labrig.campaign import run
from labrig.log import summarise
from labrig.rig import connect, parse_rig
from labrig_drivers import DeviceError, SimulatedClock
from labrig_procedures import Capture

LATE_S = 17.7
QUICK = Capture(captures=2, settle_s=0.5, record_s=0.5)


def _late_once(rig: Any, clock: Any) -> None:
    """The third time that the cameras are asked, their answer takes long."""
    driver = vars(rig.mocap).get("_device", rig.mocap)
    asked, frames = [], driver.frames

    def late() -> Any:
        asked.append(1)
        if len(asked) == 3:
            clock.sleep(LATE_S)
        return frames()

    driver.frames = late


def test_a_simulated_rig_waits_for_its_own_process(tmp_path: Path) -> None:
    """Shapes that take 17 s to solve do not end a run of a simulated rig, and its captures are whole."""
    content = {
        "name": "small",
        "chambers": [{"name": f"c{k}", "max_kpa": 60} for k in (1, 2, 3, 4)],
        "pressure": {"kind": "simulated"},
        "mocap": {"kind": "simulated"},
        "simulated": {"surface": "membrane", "occlusion": 0.0},
    }
    clock = SimulatedClock(0.0)
    rig = connect(parse_rig(content, "rig.yaml", tmp_path), clock)
    _late_once(rig, clock)
    run(QUICK, rig, tmp_path / "run")
    assert summarise(tmp_path / "run").state == "completed"
    assert open_run(tmp_path / "run").sizes["capture"] == 2


def test_a_driver_is_not_waited_for(make_rig: Any, tmp_path: Path) -> None:
    """The same of a controller behind a link ends the run, vented: nobody knows what its chambers hold meanwhile."""
    fake = make_rig()
    _late_once(fake.rig, fake.clock)
    with pytest.raises(DeviceError, match=r"dated 17\.7\d* s before .* \(the limit is 1 s\); check its link"):
        run(QUICK, fake.rig, tmp_path / "run")
