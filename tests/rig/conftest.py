"""A rig whose chambers outlive its runner."""

import importlib.util
import subprocess
import sys
from collections.abc import Callable, Iterator
from pathlib import Path
from typing import Any

import pytest
import yaml

HERE = Path(__file__).parent
SPEC = importlib.util.spec_from_file_location("valves", HERE / "valves.py")
assert SPEC is not None
assert SPEC.loader is not None
MODULE = importlib.util.module_from_spec(SPEC)
SPEC.loader.exec_module(MODULE)

RUNNER = """
import sys, time
from labrig_drivers import RealClock
from labrig.rig import connect, load_rig
rig = connect(load_rig(sys.argv[1]), RealClock())
rig.vent()
rig.pressure.set([40.0, 30.0])
print("pressurised", flush=True)
{then}
"""
POLLING = "while True: rig.pressure.samples(); time.sleep(0.02)"


@pytest.fixture
def valves() -> Iterator[Any]:
    """Chambers that nobody vents but the rig."""
    valves = MODULE.Valves()
    yield valves
    valves.close()


@pytest.fixture
def write_rig(tmp_path: Path, valves: Any) -> Callable[..., Path]:
    """Write a rig.yaml for the valves; changes go into it."""

    def write(**changes: Any) -> Path:
        content = {
            "name": "valves",
            "chambers": [{"name": "c1", "max_kpa": 60}, {"name": "c2", "max_kpa": 60}],
            "pressure": {
                "kind": "python",
                "file": str(HERE / "valves.py"),
                "class": "ValveClient",
                "port": valves.port,
            },
            "safety": {"heartbeat_s": 0.6, "stale_pressure_s": 5.0, "guard_patience_s": 20.0},
            **changes,
        }
        path = tmp_path / "rig.yaml"
        path.write_text(yaml.safe_dump(content), encoding="utf-8")
        return path

    return write


@pytest.fixture
def runner() -> Iterator[Callable[..., subprocess.Popen[str]]]:
    """Start a process that holds the valves under pressure and then does something."""
    started: list[subprocess.Popen[str]] = []

    def start(rig: Path, then: str = POLLING) -> subprocess.Popen[str]:
        command = [sys.executable, "-c", RUNNER.format(then=then), str(rig)]
        process = subprocess.Popen(command, stdout=subprocess.PIPE, stderr=subprocess.PIPE, text=True)
        started.append(process)
        assert process.stdout is not None
        assert process.stdout.readline() == "pressurised\n"
        return process

    yield start
    for process in started:
        process.kill()
        process.communicate()
