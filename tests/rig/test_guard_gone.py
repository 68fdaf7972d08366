"""A guard that is stopped, hangs or cannot be started again: the runner notices soon and vents all the same."""

import os
import signal
import subprocess
import time
from collections.abc import Callable, Iterator
from pathlib import Path
from typing import Any

import numpy as np
import pytest
import yaml

from labrig.campaign import Actuate, Procedure, Record, RigInfo, Settle, Steps, run
from labrig.rig import GuardedPressure, Rig, connect, load_rig
from labrig_drivers import DeviceError, RealClock, VentNotConfirmedError

SLOW_S = 20.0


@pytest.fixture
def rig(write_rig: Callable[..., Path]) -> Iterator[Rig]:
    """A connected, guarded rig in this process."""
    rig = connect(load_rig(write_rig()), RealClock())
    yield rig
    rig.close()


def _process(rig: Rig) -> "subprocess.Popen[str]":
    assert isinstance(rig.pressure, GuardedPressure)
    assert rig.pressure._process is not None
    return rig.pressure._process


class Long(Procedure):
    """One long hold under pressure."""

    def steps(self, rig: RigInfo) -> Steps:
        """Actuate, settle, record for longer than the test lasts."""
        yield Actuate((40.0, 30.0))
        yield Settle(0.5)
        yield Record(600.0)


@pytest.mark.skipif(not hasattr(signal, "SIGSTOP"), reason="POSIX only: Windows cannot stop a process")
def test_a_stopped_guard_is_replaced_and_the_chambers_are_vented(
    valves: Any, rig: Rig, tmp_path: Path
) -> None:
    """The stopped guard is ended, another one vents, and the run ends with what happened."""
    import threading

    def stop() -> None:
        valves.wait_for(39.0, 41.0, SLOW_S)
        os.kill(_process(rig).pid, signal.SIGSTOP)

    stopped = _process(rig)
    thread = threading.Thread(target=stop)
    thread.start()
    with pytest.raises(DeviceError) as caught:
        run(Long(), rig, tmp_path / "run")
    thread.join()
    assert str(caught.value) == (
        "pressure: the guard did not answer for 3 s and was ended; the chambers are vented"
    )
    assert stopped.poll() is not None
    assert valves.pressure_kpa <= 0.5


def test_a_set_point_that_hangs_is_not_waited_for(valves: Any, write_rig: Callable[..., Path]) -> None:
    """Three seconds, as a silent guard, and no longer: then the guard is ended, and the vent is another one's."""
    config = load_rig(write_rig())
    hangs = config.pressure.model_copy(update={"hangs_at": 50.0})
    rig = connect(config.model_copy(update={"pressure": hangs}), RealClock())
    try:
        rig.pressure.set(np.array([40.0, 30.0]))
        valves.wait_for(39.0, 41.0, SLOW_S)
        with pytest.raises(
            DeviceError, match=r"^pressure: the device did not come back from `set` within 3 s"
        ):
            rig.pressure.set(np.array([50.0, 30.0]))
        rig.vent()
        assert valves.pressure_kpa <= 0.5
    finally:
        rig.close()


def test_a_guard_whose_driver_hangs_vents_when_its_runner_is_gone(
    valves: Any, write_rig: Callable[..., Path], runner: Any
) -> None:
    """The runner is killed while the driver hangs in a set-point: another process vents over a new link."""
    path = write_rig()
    content = yaml.safe_load(path.read_text(encoding="utf-8"))
    content["pressure"]["hangs_at"] = 50.0
    path.write_text(yaml.safe_dump(content), encoding="utf-8")
    process = runner(path, "rig.pressure.set([50.0, 30.0])")
    valves.wait_for(39.0, 41.0, SLOW_S)
    time.sleep(0.5)  # the set-point is on its way
    process.kill()
    valves.wait_for(0.0, 0.5, SLOW_S)


def test_a_link_that_was_cut_is_made_anew_for_the_next_vent(valves: Any, rig: Rig) -> None:
    """The first vent over a dead connection fails and opens another; the second one vents."""
    rig.pressure.set(np.array([40.0, 30.0]))
    valves.wait_for(39.0, 41.0, SLOW_S)
    valves.cut_links()
    with pytest.raises(VentNotConfirmedError, match=r"the link is lost.*; relieve the pressure by hand$"):
        rig.vent()
    rig.vent()
    assert valves.pressure_kpa <= 0.5


def test_a_device_that_takes_long_is_no_stopped_guard(
    valves: Any, write_rig: Callable[..., Path], tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    """While the guard is at work it says so: a call may last longer than the guard may be silent."""
    monkeypatch.setattr("labrig.rig._guard._SILENT_S", 1.5)
    config = load_rig(write_rig())
    slow = config.pressure.model_copy(update={"identify_s": 3.0})
    rig = connect(config.model_copy(update={"pressure": slow}), RealClock())
    assert rig.identity["pressure"].kind == "valves"
    rig.close()


@pytest.mark.skipif(not hasattr(signal, "SIGSTOP"), reason="POSIX only: Windows cannot stop a process")
def test_without_a_guard_the_runner_vents_itself(
    valves: Any, rig: Rig, monkeypatch: pytest.MonkeyPatch
) -> None:
    """The guard is killed and no other process can be started: the vent goes over a link of the runner's own."""
    rig.pressure.set(np.array([40.0, 30.0]))
    valves.wait_for(39.0, 41.0, SLOW_S)

    def refuse(*_: Any, **__: Any) -> None:
        raise OSError("no more processes")

    monkeypatch.setattr(subprocess, "Popen", refuse)
    assert isinstance(rig.pressure, GuardedPressure)
    os.kill(_process(rig).pid, signal.SIGSTOP)
    with pytest.raises(DeviceError, match="the guard did not answer for 3 s and was ended"):
        rig.pressure.samples()
    assert rig.vent().pressure_kpa.max() <= 0.5
    assert valves.pressure_kpa <= 0.5


def test_times_of_a_guard_follow_the_runners_clock(valves: Any, write_rig: Callable[..., Path]) -> None:
    """A run that is resumed sets its clock ahead; what the guard measures is dated by that clock."""
    clock = RealClock()
    rig = connect(load_rig(write_rig()), clock)
    try:
        clock.advance_to(clock.now_s() + 3600.0)
        time.sleep(0.05)
        rig.pressure.samples()
        time.sleep(0.05)
        sample = rig.pressure.samples()[-1]
        assert abs(sample.time_s - clock.now_s()) < 60.0
    finally:
        rig.close()
