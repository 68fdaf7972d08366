"""What the workbench shows and starts of a live diagnosis."""

from pathlib import Path

import pytest

from labrig import LabrigError
from labrig.campaign import Answered, Ask, Completed, Control, Reachable
from labrig.rig import RigConfig
from labrig.workbench import open_desk
from labrig.workbench._watch import _followed
from labrig_drivers import SimulatedClock
from labrig_procedures import Capture

from .conftest import said


def test_whoever_watches_gets_every_look(config: RigConfig, tmp_path: Path) -> None:
    """The state of a run holds the looks in order; an answer without one adds nothing."""
    run = Reachable(Capture(), config, tmp_path, SimulatedClock(), Control())
    assert "looks" not in run._status(0.0, 0)
    for index, content in enumerate([said(12, 0.5), {}, said(16, 0.9)]):
        run.step_done(Completed(index, Ask(12), Answered(content)))
    looks = run._status(0.0, 0)["looks"]
    assert [(look["captures"], look["probability"]["creep"]) for look in looks] == [(12, 0.5), (16, 0.9)]


def test_a_page_can_ask_for_it(config: RigConfig, tmp_path: Path) -> None:
    """A start with a model becomes the words that a person would type; a model that is not there is refused."""
    desk = open_desk(tmp_path)
    (tmp_path / "model.yaml").write_text("base: {kind: static, degree: 1}\n")
    assert _followed(desk, config, {"procedure": "capture"}) == []
    assert _followed(desk, config, {"diagnose": "model.yaml"}) == ["--diagnose", "model.yaml"]
    words = ["--diagnose", "model.yaml", "--until", "settled"]
    assert _followed(desk, config, {"diagnose": "model.yaml", "settled": True}) == words
    with pytest.raises(LabrigError):
        _followed(desk, config, {"diagnose": "no.yaml"})
    (tmp_path / "other.yaml").write_text(
        "base: {kind: static}\neffects: [{name: creep, fitted_on: {chambers: [p9]}}]\n"
    )
    with pytest.raises(LabrigError, match=r"^nothing was moved: other.yaml is for chamber p9; the rig has"):
        _followed(desk, config, {"diagnose": "other.yaml"})
