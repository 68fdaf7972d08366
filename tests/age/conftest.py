"""A small simulated rig that is checked on a few mornings, and ages between them."""

from collections.abc import Callable
from pathlib import Path
from typing import Any
from unittest import mock

import pytest
import yaml

import labrig
from labrig.campaign import run
from labrig.rig import connect, load_rig
from labrig_drivers import SimulatedClock
from labrig_procedures import Check

START_S = 1_770_000_000.0
DAY_S = 86_400.0
MORNINGS, CHANGED = 14, 6
RIG: dict[str, Any] = {
    "name": "bench",
    "chambers": [{"name": f"c{n}", "max_kpa": 60, "slew_kpa_s": 2000} for n in range(1, 5)],
    "pressure": {"kind": "simulated", "rate_hz": 4},
    "mocap": {"kind": "simulated", "rate_hz": 4},
    "simulated": {"surface": "membrane"},
    "follow": {"tolerance_kpa": 20, "tolerance_share": 0.5},
}
SHORT = {"points": 3, "visits": 2, "hold_s": 40.0, "recovery_s": 10.0}


def measure(
    folder: Path, day: int, creep_mm: float = 0.8, procedure: Any = None, number: int = 0, **changed: Any
) -> Path:
    """A run of a day on the rig as it is then: creep of so many mm, and of another formula than the library's."""
    hidden = {"effects": [{"name": "creep", "amplitude": creep_mm}], "unit": "mm", "seed": 1}
    seed = 10 * day + number
    rig = RIG | {"simulated": {"surface": "membrane", "seed": seed, "hidden": hidden}} | changed
    rig["pressure"] = rig["pressure"] | {"seed": seed}
    path = folder.parent / f"rig-{day}-{number}.yaml"
    path.write_text(yaml.safe_dump(rig), encoding="utf-8")
    clock = SimulatedClock(START_S + DAY_S * day + 600.0 * number)
    with mock.patch("os.fsync"), connect(load_rig(path), clock) as connected:
        chosen = procedure or Check.model_validate(SHORT)
        return run(chosen, connected, folder / f"{day:02d}-{number}", clock=clock, seed=seed)


@pytest.fixture
def measured() -> Callable[..., Path]:
    """`measure`."""
    return measure


@pytest.fixture(scope="session")
def aged(tmp_path_factory: pytest.TempPathFactory) -> Path:
    """`runs` of 14 mornings, rig.yaml, and model.yaml, fitted on the first two; from the seventh on creep is double."""
    folder = tmp_path_factory.mktemp("aged")
    (folder / "rig.yaml").write_text(yaml.safe_dump(RIG), encoding="utf-8")
    (folder / "base.yaml").write_text("base: {kind: simulator, rig: rig.yaml}\n", encoding="utf-8")
    runs = folder / "runs"
    runs.mkdir()
    for day in range(MORNINGS):
        measure(runs, day, 0.8 if day < CHANGED else 1.6)
    better = labrig.improve([runs / "00-0", runs / "01-0"], folder / "base.yaml", "creep")
    better.model.save(folder / "model.yaml")
    return folder
