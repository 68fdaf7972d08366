"""A small campaign of a simulated rig that hides creep, and the model that does not know it."""

from pathlib import Path

import pytest
import yaml

import labrig
from tests.rigs import RIG


@pytest.fixture(scope="session")
def lab(tmp_path_factory: pytest.TempPathFactory) -> Path:
    """A folder with rig.yaml, model.yaml and the run `first`."""
    from labrig_drivers.simulated import hide, seal

    folder = tmp_path_factory.mktemp("lab")
    (folder / "rig.yaml").write_text(yaml.safe_dump(RIG), encoding="utf-8")
    (folder / "model.yaml").write_text(
        "base: {kind: simulator, rig: rig.yaml}\neffects: []\n", encoding="utf-8"
    )
    seal(folder, hide("creep", seed=1))
    labrig.run("capture", folder / "rig.yaml", out=folder / "first", captures=40)
    return folder


@pytest.fixture(scope="session")
def diagnosis(lab: Path) -> labrig.Diagnosis:
    """What the model lacks."""
    return labrig.diagnose(lab / "first", lab / "model.yaml")
