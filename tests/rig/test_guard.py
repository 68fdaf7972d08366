"""The guard vents when the runner is killed, hangs, or is gone; it stays out of the way otherwise."""

import os
import signal
import sys
from collections.abc import Callable, Iterator
from pathlib import Path
from typing import Any

import numpy as np
import pytest

from labrig import LabrigError
from labrig.rig import GuardedPressure, Rig, connect, load_rig
from labrig_drivers import DeviceError, RealClock, SimulatedClock

SLOW_S = 30.0
"""Longer than any of these vents takes on a busy machine; the time stated in the docs is the heartbeat's."""

HANGING = "time.sleep(60)"


@pytest.fixture
def rig(write_rig: Callable[..., Path]) -> Iterator[Rig]:
    """A connected, guarded rig in this process."""
    rig = connect(load_rig(write_rig()), RealClock())
    yield rig
    rig.close()


def _guard_id(rig: Rig) -> int:
    assert isinstance(rig.pressure, GuardedPressure)
    process = rig.pressure._process
    assert process is not None
    return process.pid


def test_killing_the_runner_vents(valves: Any, write_rig: Any, runner: Any) -> None:
    """SIGKILL leaves the runner no chance; the guard sees its input end and vents."""
    process = runner(write_rig())
    valves.wait_for(35.0, 45.0, SLOW_S)
    process.kill()
    valves.wait_for(0.0, 0.5, SLOW_S)


def test_a_runner_that_hangs_is_vented(valves: Any, write_rig: Any, runner: Any) -> None:
    """A runner that lives but gives no sign of life is as good as dead."""
    process = runner(write_rig(), HANGING)
    valves.wait_for(35.0, 45.0, SLOW_S)
    valves.wait_for(0.0, 0.5, SLOW_S)
    assert process.poll() is None


@pytest.mark.skipif(not hasattr(signal, "SIGSTOP"), reason="POSIX only")
def test_a_stopped_runner_is_vented(valves: Any, write_rig: Any, runner: Any) -> None:
    """Ctrl-Z freezes a runner; the chambers are vented all the same."""
    process = runner(write_rig())
    valves.wait_for(35.0, 45.0, SLOW_S)
    os.kill(process.pid, signal.SIGSTOP)
    valves.wait_for(0.0, 0.5, SLOW_S)
    os.kill(process.pid, signal.SIGCONT)


def test_a_polling_runner_is_left_alone(valves: Any, rig: Rig) -> None:
    """Every request is a sign of life: the pressure stays for longer than the heartbeat."""
    rig.pressure.set(np.array([40.0, 30.0]))
    valves.wait_for(39.0, 41.0, SLOW_S)
    end_s = RealClock().now_s() + 1.5
    while RealClock().now_s() < end_s:
        rig.pressure.samples()
        RealClock().sleep(0.05)
    assert valves.pressure_kpa == pytest.approx(40.0, abs=0.1)
    assert rig.vent().pressure_kpa.max() <= 0.5


def test_a_procedure_may_think(valves: Any, rig: Rig) -> None:
    """The guard waits as long as it was told to, while the procedure's own code runs."""
    rig.pressure.set(np.array([40.0, 30.0]))
    rig.thinking()
    RealClock().sleep(1.5)
    assert valves.pressure_kpa == pytest.approx(40.0, abs=0.1)
    rig.vent()


def test_after_it_vented_alone_the_guard_refuses_set_points(valves: Any, rig: Rig) -> None:
    """A runner that comes back learns what happened, and can go on after a vent of its own."""
    rig.pressure.set(np.array([40.0, 30.0]))
    valves.wait_for(39.0, 41.0, SLOW_S)
    valves.wait_for(0.0, 0.5, SLOW_S)
    RealClock().sleep(0.3)
    with pytest.raises(
        DeviceError, match=r"^pressure: the guard vented: no sign of life from the runner for \d"
    ):
        rig.pressure.set(np.array([40.0, 30.0]))
    rig.vent()
    rig.pressure.set(np.array([10.0, 10.0]))
    valves.wait_for(9.9, 10.1, SLOW_S)
    rig.vent()


def test_a_lost_link_that_comes_back_is_used_to_vent(
    valves: Any, write_rig: Any, runner: Any, tmp_path: Path
) -> None:
    """The guard connects again, for as long as it takes."""
    process = runner(write_rig())
    valves.wait_for(35.0, 45.0, SLOW_S)
    valves.cut_links()
    process.kill()
    valves.wait_for(0.0, 0.5, SLOW_S)


def test_when_the_guard_dies_the_runner_hears_of_it_and_can_still_vent(valves: Any, rig: Rig) -> None:
    """The next call says so; a vent starts a new guard."""
    rig.pressure.set(np.array([40.0, 30.0]))
    valves.wait_for(39.0, 41.0, SLOW_S)
    os.kill(_guard_id(rig), signal.SIGTERM if sys.platform == "win32" else signal.SIGKILL)
    with pytest.raises(DeviceError, match=r"^pressure: the guard process ended \(exit code -?\d+\); look at"):
        rig.pressure.samples()
    assert valves.pressure_kpa > 1.0
    rig.vent()
    assert valves.pressure_kpa <= 0.5


@pytest.mark.skipif(sys.platform == "win32", reason="SIGTERM cannot be caught on Windows")
def test_terminating_the_guard_vents(valves: Any, rig: Rig) -> None:
    """SIGTERM, as at shutdown of the computer, is a reason to vent."""
    rig.pressure.set(np.array([40.0, 30.0]))
    valves.wait_for(39.0, 41.0, SLOW_S)
    os.kill(_guard_id(rig), signal.SIGTERM)
    valves.wait_for(0.0, 0.5, SLOW_S)


def test_leaving_the_rig_vents_and_ends_the_guard(valves: Any, write_rig: Any) -> None:
    """`with connect(...)` leaves no pressure and no process."""
    with connect(load_rig(write_rig()), RealClock()) as rig:
        rig.pressure.set(np.array([40.0, 30.0]))
        valves.wait_for(39.0, 41.0, SLOW_S)
        process = rig.pressure._process  # type: ignore[attr-defined]
    assert valves.pressure_kpa <= 0.5
    assert process.returncode == 0


def test_errors_of_the_device_come_through(write_rig: Any, valves: Any) -> None:
    """What the device says behind the guard is what the caller reads."""
    path = write_rig()
    port = valves.port
    valves.close()
    with pytest.raises(DeviceError, match=rf"^pressure: port {port}: .*refused"):
        connect(load_rig(path), RealClock())


def test_the_guard_writes_down_what_it_does(valves: Any, write_rig: Any, tmp_path: Path) -> None:
    """Its own log says why it vented and what it read."""
    log = tmp_path / "guard.log"
    rig = connect(load_rig(write_rig()), RealClock(), guard_log=log)
    rig.pressure.set(np.array([40.0, 30.0]))
    valves.wait_for(39.0, 41.0, SLOW_S)
    rig.close()
    lines = [line.split(" ", 1)[1] for line in log.read_text().splitlines()]
    assert lines[0] == "the runner is gone: venting"
    assert lines[1].startswith("vented: 0.")


def test_a_simulated_rig_has_no_guard(tmp_path: Path) -> None:
    """There is nothing to guard in a simulation inside this process; asking for it is an error."""
    path = tmp_path / "rig.yaml"
    path.write_text(
        "name: s\nchambers: [{name: c1, max_kpa: 60}]\npressure: {kind: simulated}\nsimulated: {surface: mannequin}\n"
    )
    with pytest.raises(LabrigError) as caught:
        connect(load_rig(path), SimulatedClock(), guard=True)
    assert str(caught.value) == "rig s: a simulated pressure controller cannot be guarded"


def test_a_driver_that_prints_or_asks_somebody_does_not_disturb_the_guard(
    valves: Any, write_rig: Any, tmp_path: Path
) -> None:
    """What it writes is no answer of the guard's, and what it reads no request: it vents as any other."""
    (tmp_path / "talks.py").write_text(
        f"""
import sys
sys.path.insert(0, {str(Path(__file__).parent)!r})
from valves import ValveClient

class Talks(ValveClient):
    def __init__(self, name, clock, channels, port):
        print("made")
        super().__init__(name, clock, channels, port)

    def set(self, pressure_kpa):
        print("set", pressure_kpa, flush=True)
        try:
            input("go on? ")
        except EOFError:
            pass
        super().set(pressure_kpa)
""",
        encoding="utf-8",
    )
    pressure = {"kind": "python", "file": "talks.py", "class": "Talks", "port": valves.port}
    with connect(load_rig(write_rig(pressure=pressure)), RealClock()) as rig:
        rig.pressure.set(np.array([40.0, 30.0]))
        valves.wait_for(35.0, 45.0, SLOW_S)
        rig.pressure.samples()
    assert valves.pressure_kpa < 0.5
