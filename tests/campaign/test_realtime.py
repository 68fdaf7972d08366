"""On the real clock: the devices are polled while a scanner is waited for, and nothing waits for ever."""

import time
from pathlib import Path
from typing import Any

import numpy as np
import pytest

from labrig import open_run
from labrig.campaign import Actuate, Procedure, Record, RigInfo, Scan, Settle, Steps, read_completed, run
from labrig.campaign._scans import keep_scan
from labrig.rig import connect
from labrig_drivers import DeviceError, RealClock


class Scans(Procedure):
    """A scan under pressure, and a recording after it."""

    timeout_s: float = 10.0

    def steps(self, rig: RigInfo) -> Steps:
        """Four steps."""
        yield Actuate((20.0, 20.0))
        yield Settle(1.0)
        yield Scan(self.timeout_s)
        yield Record(0.3)


@pytest.fixture
def rig(make_rig: Any) -> Any:
    """The fake rig on the real clock, guard and all left out."""
    return connect(make_rig().rig.config, RealClock(), guard=False)


def test_a_disk_that_is_slow_keeps_nobody_from_looking_at_the_rig(
    rig: Any, tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    """While a scan's files are copied to a share the pressures are asked for, as the guard wants to hear."""
    asked: list[float] = []
    samples = rig.pressure.samples
    during: list[int] = []

    def keep(*given: Any) -> Any:
        before = len(asked)
        time.sleep(1.0)
        during.append(len(asked) - before)
        return keep_scan(*given)

    monkeypatch.setattr(rig.pressure, "samples", lambda: asked.append(0.0) or samples())
    monkeypatch.setattr("labrig.campaign._execute.keep_scan", keep)
    run(Scans(), rig, tmp_path / "run")
    assert during[0] >= 3


def test_a_scan_is_waited_for_while_everything_is_logged(rig: Any, tmp_path: Path) -> None:
    """Frames and pressures go on during the two seconds of the scan."""
    run(Scans(), rig, tmp_path / "run")
    done = read_completed(tmp_path / "run")
    assert [item.step.kind for item in done] == ["actuate", "settle", "scan", "record"]
    scan = done[2]
    assert scan.ended_s - scan.started_s >= 2.0
    hold = open_run(tmp_path / "run").isel(capture=0)
    during = hold["time_s"].to_numpy() - hold["time_s"].to_numpy()[0]
    assert np.diff(during[np.isfinite(during)]).max() < 1.0
    assert len(during) > 30
    assert np.abs(rig.pressure.world.pressure(rig.clock.now_s())).max() <= 0.5


def test_a_scanner_that_does_not_even_time_out_is_left(
    rig: Any, tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    """The runner has a limit of its own for drivers that break their promise."""
    monkeypatch.setattr("labrig.campaign._execute._SCAN_GRACE_S", 0.2)
    with pytest.raises(DeviceError) as caught:
        run(Scans(timeout_s=0.3), rig, tmp_path / "run")
    assert str(caught.value) == "scanner: no scan within 0.5 s; the chambers are vented"
    assert np.abs(rig.pressure.world.pressure(rig.clock.now_s())).max() <= 0.5


def test_the_devices_of_a_rig_may_fail_to_answer_at_all(rig: Any, tmp_path: Path) -> None:
    """The preflight says which device is silent, before the first step."""
    rig.mocap.faults["lost"] = True
    with pytest.raises(DeviceError) as caught:
        run(Scans(), rig, tmp_path / "run")
    assert str(caught.value) == (
        "mocap: nothing was received within 5 s; check that it is streaming; the chambers are vented"
    )
    assert {command for _, command in rig.pressure.world.commands} == {(0.0, 0.0)}
