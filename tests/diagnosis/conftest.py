"""A rig whose model is a small shell, for simulators as bases."""

from collections.abc import Callable
from pathlib import Path

import pytest
import yaml

from labrig.physics import load_shell


@pytest.fixture
def small_rig(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> Callable[[int], None]:
    """Makes, in a new current folder, a flat membrane of so many control points each way, and its rig."""
    monkeypatch.chdir(tmp_path)

    def make(points: int) -> None:
        shell = load_shell("membrane4").changed(count=(points, points))
        Path("small.yaml").write_text(yaml.safe_dump(shell.content()))
        rig = {
            "name": "small",
            "chambers": [{"name": f"c{n}", "max_kpa": 60} for n in range(1, 5)],
            "pressure": {"kind": "simulated"},
            "mocap": {"kind": "simulated"},
            "simulated": {"shell": "small.yaml"},
        }
        Path("rig.yaml").write_text(yaml.safe_dump(rig))

    return make
