"""A rig of fake devices on a clock that lets a test act at a chosen moment of a run."""

import importlib.util
import sys
from collections.abc import Callable
from dataclasses import dataclass
from pathlib import Path
from types import ModuleType
from typing import Any

import pytest

from labrig.rig import Rig, RigConfig, connect, parse_rig
from labrig_drivers import SimulatedClock

HERE = Path(__file__).parent


class EventfulClock(SimulatedClock):
    """A simulated clock that calls `on_sleep` before each sleep."""

    def __init__(self) -> None:
        super().__init__()
        self.on_sleep: Callable[[], None] = lambda: None

    def sleep(self, duration_s: float) -> None:
        """Act, then move the clock."""
        self.on_sleep()
        super().sleep(duration_s)


@dataclass
class FakeRig:
    """A connected fake rig with its parts in reach."""

    rig: Rig
    clock: EventfulClock

    @property
    def pressure(self) -> Any:
        """The fake pressure controller."""
        return self.rig.pressure

    @property
    def mocap(self) -> Any:
        """The fake motion capture."""
        return self.rig.mocap

    @property
    def pressure_kpa(self) -> Any:
        """What the chambers really hold now."""
        return self.pressure.world.pressure(self.clock.now_s())


def device(name: str) -> dict[str, Any]:
    """The settings of a fake device."""
    return {"kind": "python", "file": "fake_devices.py", "class": name}


def fake_config(**changes: Any) -> RigConfig:
    """A rig of two chambers and three markers."""
    content: dict[str, Any] = {
        "name": "fake",
        "chambers": [{"name": "c1", "max_kpa": 60}, {"name": "c2", "max_kpa": 60}],
        "markers": ["m1", "m2", "m3"],
        "pressure": device("FakePressure"),
        "mocap": device("FakeMocap"),
        "scanner": device("FakeScanner"),
    }
    return parse_rig({**content, **changes}, "rig.yaml", HERE)


@pytest.fixture
def config() -> RigConfig:
    """The fake rig's description."""
    return fake_config()


@pytest.fixture
def make_rig() -> Callable[..., FakeRig]:
    """Connect a fake rig; changes go into its description."""

    def make(**changes: Any) -> FakeRig:
        clock = EventfulClock()
        return FakeRig(connect(fake_config(**changes), clock), clock)

    return make


@pytest.fixture
def fake(make_rig: Callable[..., FakeRig]) -> FakeRig:
    """A connected fake rig."""
    return make_rig()


def load_module(path: Path) -> ModuleType:
    """Import a file of the tests by its path."""
    spec = importlib.util.spec_from_file_location(path.stem, path)
    assert spec is not None
    assert spec.loader is not None
    module = importlib.util.module_from_spec(spec)
    sys.modules[path.stem] = module
    spec.loader.exec_module(module)
    return module
