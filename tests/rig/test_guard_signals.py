"""The guard and signals: those that end a program make it vent, also while the runner is alive and well."""

import os
import signal
import sys
import time
from collections.abc import Callable, Iterator
from pathlib import Path
from typing import Any

import numpy as np
import pytest

from labrig.rig import Rig, connect, load_rig
from labrig_drivers import DeviceError, RealClock

pytestmark = pytest.mark.skipif(
    sys.platform == "win32", reason="Windows cannot send these to another process"
)
SLOW_S = 10.0


@pytest.fixture
def rig(write_rig: Callable[..., Path]) -> Iterator[Rig]:
    """A guarded rig whose guard would wait a minute for a sign of life."""
    rig = connect(load_rig(write_rig(safety={"heartbeat_s": 60.0, "guard_patience_s": 20.0})), RealClock())
    yield rig
    rig.close()


def _process(rig: Any) -> Any:
    return rig.pressure._process


@pytest.mark.parametrize("name", ["SIGTERM", "SIGHUP"])
def test_a_guard_that_is_asked_to_end_vents_first(valves: Any, rig: Rig, name: str) -> None:
    """At shutdown of the computer nobody waits for a heartbeat: the vent comes with the signal, then the end."""
    rig.pressure.set(np.array([40.0, 30.0]))
    valves.wait_for(39.0, 41.0, SLOW_S)
    os.kill(_process(rig).pid, getattr(signal, name))
    valves.wait_for(0.0, 0.5, SLOW_S)
    assert _process(rig).wait(SLOW_S) == 0
    with pytest.raises(DeviceError, match=r"^pressure: the guard process ended"):
        rig.pressure.set(np.array([40.0, 30.0]))
    assert valves.pressure_kpa <= 0.5


def test_ctrl_c_is_the_runners_to_answer(valves: Any, rig: Rig) -> None:
    """SIGINT, which a terminal sends to everybody, leaves the guard as it is."""
    rig.pressure.set(np.array([40.0, 30.0]))
    valves.wait_for(39.0, 41.0, SLOW_S)
    os.kill(_process(rig).pid, signal.SIGINT)
    time.sleep(0.3)
    rig.pressure.samples()
    assert valves.pressure_kpa == pytest.approx(40.0, abs=0.1)
    assert _process(rig).poll() is None
    rig.vent()
