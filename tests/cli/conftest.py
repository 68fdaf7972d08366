"""A simulated rig that hides something, in a folder of its own."""

from collections.abc import Callable
from pathlib import Path
from typing import Any

import pytest
import yaml

from tests.rigs import MODEL, RIG


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
