"""A rig whose chambers outlive its runner."""

import importlib.util
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
