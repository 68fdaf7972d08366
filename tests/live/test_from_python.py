"""A live diagnosis of a campaign that is run from Python, as from the command line."""

from pathlib import Path

import pytest
import yaml

import labrig
from labrig._errors import LabrigError
from tests.live.conftest import RIG

pytestmark = pytest.mark.usefixtures("hidden")


@pytest.fixture
def hidden(tmp_path: Path) -> None:
    """A rig that hides hysteresis, and its model."""
    from labrig_drivers.simulated import hide, seal

    (tmp_path / "rig.yaml").write_text(yaml.safe_dump(RIG), encoding="utf-8")
    (tmp_path / "model.yaml").write_text("base: {kind: simulator, rig: rig.yaml}\n", encoding="utf-8")
    seal(tmp_path, hide("hysteresis", seed=1))


def test_a_campaign_from_python_ends_when_its_budget_does(tmp_path: Path) -> None:
    """`budget` ends it before the procedure's captures are all taken, and run.yaml says what was asked."""
    folder = labrig.run(
        "capture",
        tmp_path / "rig.yaml",
        out=tmp_path / "runs" / "one",
        captures=40,
        diagnose=tmp_path / "model.yaml",
        budget="1min",
    )
    assert 8 <= labrig.open_run(folder).sizes["capture"] < 40
    asked = yaml.safe_load((folder / "run.yaml").read_text(encoding="utf-8"))["live_diagnosis"]
    assert asked["budget"] == "1min"


@pytest.mark.parametrize("rule", [{"until": "settled"}, {"budget": "4min"}, {"adapt": True}])
def test_a_rule_without_a_model_is_refused(tmp_path: Path, rule: dict[str, str | bool]) -> None:
    """What ends a campaign or steers it needs a model; nothing is made without one."""
    with pytest.raises(LabrigError, match="need a model to question"):
        labrig.run("capture", tmp_path / "rig.yaml", out=tmp_path / "runs" / "one", **rule)
    assert not (tmp_path / "runs").exists()
