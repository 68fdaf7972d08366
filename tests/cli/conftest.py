"""A simulated rig that hides something, in a folder of its own."""

from collections.abc import Callable
from pathlib import Path
from typing import Any

import pytest
import yaml

RIG = {
    "name": "bench",
    "chambers": [{"name": f"c{n}", "max_kpa": 60} for n in range(1, 5)],
    "pressure": {"kind": "simulated"},
    "mocap": {"kind": "simulated", "rate_hz": 20},
    "simulated": {"surface": "membrane", "seed": 0, "hidden": "sealed.json"},
    "follow": {
        "tolerance_kpa": 20,
        "tolerance_share": 0.5,
    },  # what it hides may be a leak or a wrong regulator
}
MODEL = "base: {kind: simulator, rig: rig.yaml}\neffects: []\n"


@pytest.fixture
def lab(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> Callable[..., Path]:
    """Makes a folder with a simulated rig that hides something, and its model, and goes there."""
    from labrig_drivers.simulated import hide, seal

    def make(hidden: str, seed: int = 1, **rig: Any) -> Path:
        monkeypatch.chdir(tmp_path)
        (tmp_path / "rig.yaml").write_text(yaml.safe_dump({**RIG, **rig}))
        (tmp_path / "model.yaml").write_text(MODEL)
        seal(tmp_path, hide(hidden, seed=seed))
        return tmp_path

    return make
