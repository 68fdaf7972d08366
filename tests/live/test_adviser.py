"""A campaign that is followed by a diagnosis."""

from pathlib import Path
from typing import Any

import pytest

from labrig import LabrigError, open_run
from labrig.campaign import Ask, Control, Interrupted, Observer, Watching, read_completed, resume, run
from labrig.live import LiveDiagnosis, Settings
from labrig.log import summarise
from labrig.rig import RigConfig, connect
from labrig_drivers import SimulatedClock
from labrig_procedures import Capture

from .conftest import Told, said

PLAN = Capture(captures=36, repeated=0, settle_s=0.5, record_s=0.2)
ASKED = Settings("model.yaml", until="settled")


def follow(
    config: RigConfig,
    folder: Path,
    looker: Any,
    *,
    settings: Settings = ASKED,
    waits: bool = True,
    **watching: Any,
) -> LiveDiagnosis:
    """Run the plan to its end, followed by the looker."""
    adviser = LiveDiagnosis(settings, PLAN.captures, looker, waits=waits)
    with connect(config, SimulatedClock()) as rig:
        run(PLAN, rig, folder, watching=Watching(adviser=adviser, **watching))
    return adviser


def lines(folder: Path) -> list[str]:
    """What the log says to people."""
    return [text for _, text in summarise(folder).events]


def test_a_settled_campaign_ends_vented_and_says_why(config: RigConfig, tmp_path: Path) -> None:
    """Settled it ends before its plan does, completed and vented, and the log has the looks and the reason."""
    looker = Told(lambda captures: said(captures, 0.95 if captures >= 16 else 0.5))
    follow(config, tmp_path / "run", looker)
    summary = summarise(tmp_path / "run")
    assert looker.asked == [12, 16, 20, 24, 28, 32]
    assert (summary.captures, summary.state) == (32, "completed")
    said_so = [line for line in lines(tmp_path / "run") if line.startswith("diagnosis")]
    assert said_so[0] == (
        "diagnosis of 12 captures: creep 0.50; error 0.3 mm, floor 0.1 mm, left to gain 0.2 mm"
    )
    assert said_so[-1] == (
        "diagnosis: the campaign ends here, vented: settled: sure of creep 0.95; all other effects are out "
        "(each of them 1 % for what was not seen yet)"
    )
    answers = [done.result.content for done in read_completed(tmp_path / "run") if isinstance(done.step, Ask)]
    assert [answer["look"]["captures"] for answer in answers if "look" in answer] == looker.asked
    assert answers[-1]["stop"].startswith("settled")
    assert answers[-1]["probability"] == {"creep": 0.95}


def test_without_until_it_is_the_plan(config: RigConfig, tmp_path: Path) -> None:
    """Where nothing is to end it, the whole plan is done, however sure the looks are."""
    looker = Told(lambda captures: said(captures, 0.99))
    follow(config, tmp_path / "run", looker, settings=Settings("model.yaml", every=6))
    assert open_run(tmp_path / "run").sizes["capture"] == 36
    assert looker.asked == [12, 18, 24, 30, 36]


def test_nobody_waits_for_a_look_on_a_real_clock(config: RigConfig, tmp_path: Path) -> None:
    """A diagnosis that hangs is asked once, and the whole plan is done without it."""
    looker = Told(lambda captures: None)
    follow(config, tmp_path / "run", looker, waits=False)
    assert looker.asked == [12]
    assert open_run(tmp_path / "run").sizes["capture"] == 36


def test_a_look_that_comes_late_counts_when_it_comes(config: RigConfig, tmp_path: Path) -> None:
    """On a real clock a look is taken in at the next question, and the next one is begun after `every` captures."""
    looker = Told(lambda captures: said(captures, 0.95))
    follow(config, tmp_path / "run", looker, waits=False)
    assert looker.asked == [12, 16, 20, 24]
    assert open_run(tmp_path / "run").sizes["capture"] == 25


@pytest.mark.parametrize("how", ["says so", "raises"])
def test_a_diagnosis_that_fails_changes_nothing_but_a_warning(
    config: RigConfig, tmp_path: Path, how: str
) -> None:
    """Trouble in the diagnosis is a warning in the log; every capture of the plan is there."""

    def fails(captures: int) -> dict[str, Any]:
        if how == "raises":
            raise ZeroDivisionError("no floor")
        return {"trouble": "the diagnosis failed: no floor"}

    follow(config, tmp_path / "run", Told(fails))
    assert open_run(tmp_path / "run").sizes["capture"] == 36
    assert any("no floor" in line for line in lines(tmp_path / "run"))


def test_a_budget_ends_the_campaign_in_time(config: RigConfig, tmp_path: Path) -> None:
    """No capture begins that would end after the budget, with no look at all."""
    follow(config, tmp_path / "run", None, settings=Settings("model.yaml", budget="20s"))
    run_ = open_run(tmp_path / "run")
    took_s = float(run_["time_s"].max())
    assert 12 <= run_.sizes["capture"] < 36
    assert took_s <= 20.5
    assert any(
        "out of time: the next capture would end after 0.333 min" in line for line in lines(tmp_path / "run")
    )


class _EndsAfter(Observer):
    """Ends the run after so many questions."""

    def __init__(self, control: Control, questions: int) -> None:
        self.control, self.left = control, questions

    def step_done(self, completed: Any) -> None:
        self.left -= isinstance(completed.step, Ask)
        if self.left == 0:
            self.control.end("the test")


def test_a_resumed_run_decides_the_same(config: RigConfig, tmp_path: Path) -> None:
    """What was answered before the interruption counts from the log alone: nobody is asked again, and it ends there."""
    folder = tmp_path / "run"

    def interrupted(captures: int) -> dict[str, Any]:
        return said(captures, 0.95)

    control = Control()
    with pytest.raises(Interrupted):
        follow(config, folder, Told(interrupted), control=control, observers=[_EndsAfter(control, 1)])
    done = [step for step in read_completed(folder) if isinstance(step.step, Ask)]
    assert done
    assert done[0].result.content["look"]["captures"] == 12
    looker = Told(lambda captures: said(captures, 0.95))
    adviser = LiveDiagnosis(ASKED, PLAN.captures, looker, waits=True)
    with connect(config, SimulatedClock()) as rig:
        resume(PLAN, rig, folder, watching=Watching(adviser=adviser))
    assert looker.asked == [16, 20, 24]
    assert summarise(folder).captures == 24
    assert [look.captures for look in adviser.looks] == [12, 16, 20, 24]


def test_a_resumed_run_wants_its_diagnosis_back(config: RigConfig, tmp_path: Path) -> None:
    """A run that was followed cannot be resumed without: its steps would be others."""
    folder, control = tmp_path / "run", Control()
    with pytest.raises(Interrupted):
        follow(config, folder, Told(lambda n: None), control=control, observers=[_EndsAfter(control, 1)])
    with (
        connect(config, SimulatedClock()) as rig,
        pytest.raises(LabrigError, match="no longer makes the steps that it made"),
    ):
        resume(PLAN, rig, folder)


def test_a_model_that_was_changed_meanwhile_is_refused(tmp_path: Path) -> None:
    """Settings from run.yaml name the model file by its content; another content is another campaign."""
    model = tmp_path / "model.yaml"
    model.write_text("base: {kind: static, degree: 1}\n")
    kept = Settings(str(model), 5, "settled", "1h").to_dict()
    assert Settings.from_dict(kept, "run") == Settings(str(model), 5, "settled", "1h")
    model.write_text("base: {kind: static, degree: 2}\n")
    with pytest.raises(LabrigError, match="no longer the model that this run is diagnosed with"):
        Settings.from_dict(kept, "run")
