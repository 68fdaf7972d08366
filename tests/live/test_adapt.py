"""Campaigns whose set-points follow the verdict."""

from pathlib import Path
from typing import Any

import numpy as np
import pytest

from labrig import LabrigError, open_run
from labrig.campaign import Ask, Control, Interrupted, Watching, dry_run, resume, rig_info, run
from labrig.experiment import Limits
from labrig.live import LiveDiagnosis, Range, Settings
from labrig.live._adapt import propose
from labrig.rig import RigConfig, connect
from labrig_drivers import SimulatedClock
from labrig_procedures import Capture

from .conftest import Told, said
from .test_adviser import _EndsAfter

PLAN = Capture(captures=24, repeated=0, settle_s=0.5, record_s=0.2, highest=0.5)
ASKED = Settings("model.yaml", adapt=True)


def probe(label: str, *c1_kpa: float) -> list[dict[str, Any]]:
    """Points that bring chamber c1 to pressures, one after the other."""
    return [{"pressure_kpa": {"c1": kpa}, "hold_s": 0.6, "label": label} for kpa in c1_kpa]


PROPOSED = {
    12: [*probe("up and down", 11.0, 22.0, 11.0), *probe("again", 13.0)],
    16: probe("step", 17.0, 0.0),
}


def answer(captures: int) -> dict[str, Any]:
    """Creep stays open, and these points would tell."""
    return {**said(captures, 0.5), "points": PROPOSED.get(captures, [])}


def adviser(config: RigConfig, looker: Any) -> LiveDiagnosis:
    """One that adapts within the plan's range."""
    within = Range.of(dry_run(PLAN, config), rig_info(config))
    return LiveDiagnosis(ASKED, PLAN.captures, looker, waits=True, range_kpa=within)


def test_what_is_proposed_takes_the_place_of_the_plan(config: RigConfig, tmp_path: Path) -> None:
    """A programme is done whole, then that of a newer look; without one it is the plan again."""
    looker = Told(answer)
    with connect(config, SimulatedClock()) as rig:
        run(PLAN, rig, tmp_path / "run", watching=Watching(adviser=adviser(config, looker)))
    made = open_run(tmp_path / "run")["commanded"].values
    planned = np.array([step.pressure_kpa for step in dry_run(PLAN, config).steps if step.kind == "actuate"])
    assert len(made) == 24
    np.testing.assert_allclose(made[:12], planned[:12])
    assert made[12:18, 0].tolist() == [11.0, 22.0, 11.0, 13.0, 17.0, 0.0]
    np.testing.assert_allclose(made[18:], planned[12:18])
    assert looker.asked == [12, 16, 20, 24]


def test_a_programme_is_nearly_done_before_another_is_asked_for(config: RigConfig, tmp_path: Path) -> None:
    """Looks in the middle of a long programme ask for a verdict only; the next programme follows its last point."""
    long = [
        *probe("steps", 1.0, 2.0, 3.0, 4.0),
        *probe("strokes", 5.0, 6.0, 7.0, 8.0),
        *probe("swing", 9.0, 10.0),
    ]
    programmes = {12: long, 16: probe("too early", 60.0), 20: probe("more", 11.0)}
    questions: list[tuple[int, bool]] = []

    class Asked(Told):
        def ask(self, question: dict[str, Any]) -> None:
            super().ask(question)
            questions.append((question["captures"], "adapt" in question))
            if "adapt" not in question:
                self._now = {k: v for k, v in self._now.items() if k != "points"}

    looker = Asked(lambda captures: {**said(captures, 0.5), "points": programmes.get(captures, [])})
    with connect(config, SimulatedClock()) as rig:
        run(PLAN, rig, tmp_path / "run", watching=Watching(adviser=adviser(config, looker)))
    made = open_run(tmp_path / "run")["commanded"].values
    assert made[12:23, 0].tolist() == [1.0, 2.0, 3.0, 4.0, 5.0, 6.0, 7.0, 8.0, 9.0, 10.0, 11.0]
    assert questions[:3] == [(12, True), (16, False), (20, True)]


def test_a_late_answer_is_not_asked_for_twice() -> None:
    """On a real clock a programme that has just arrived is known when the next look is asked for."""

    class Late:
        def __init__(self) -> None:
            self.questions: list[dict[str, Any]] = []
            self.open: dict[str, Any] | None = None

        @property
        def idle(self) -> bool:
            return self.open is None

        def ask(self, question: dict[str, Any]) -> None:
            self.open = question
            self.questions.append(question)

        def found(self) -> dict[str, Any] | None:
            if self.open is None or now < self.open["captures"] + 5:
                return None
            question, self.open = self.open, None
            return {"points": probe("long", *range(1, 21))} if "adapt" in question else {}

        wait = found

    looker = Late()
    within = Range((0.0,), (60.0,), (100.0,))
    adviser = LiveDiagnosis(ASKED, 100, looker, waits=False, range_kpa=within)  # type: ignore[arg-type]
    for now in range(12, 34):
        adviser._learn(adviser.advise(Ask(now), 0.0))
        adviser._points = adviser._points[1:]
    asked = [(q["captures"], "adapt" in q) for q in looker.questions]
    assert asked[:4] == [(12, True), (17, False), (22, False), (27, False)]


def test_the_range_is_that_of_the_plan(config: RigConfig, tmp_path: Path) -> None:
    """What is asked for stays between vented and the plan's highest, whatever the rig would allow."""
    looker = Told(answer)
    with connect(config, SimulatedClock()) as rig:
        run(PLAN, rig, tmp_path / "run", watching=Watching(adviser=adviser(config, looker)))
    highest = open_run(tmp_path / "run")["commanded"].values[:12].max(axis=0)
    asked = looker.questions[0]["adapt"]
    assert asked["low_kpa"] == (0.0,) * 4
    assert (np.array(asked["high_kpa"]) >= highest).all()
    assert max(asked["high_kpa"]) <= 30.0


def test_what_is_proposed_knows_how_fast_the_rig_is(
    config: RigConfig, monkeypatch: pytest.MonkeyPatch
) -> None:
    """A slow rig's way to a set-point is part of what a programme takes: its rate goes with the range."""
    chambers = [c.model_copy(update={"slew_kpa_s": 5.0 + k}) for k, c in enumerate(config.chambers)]
    slow = config.model_copy(update={"chambers": chambers})
    looker = Told(answer)
    LiveDiagnosis(
        ASKED, 24, looker, waits=True, range_kpa=Range.of(dry_run(PLAN, slow), rig_info(slow))
    ).advise(Ask(12), 0.0)
    asked: list[Limits] = []

    def proposed(*_: Any, limits: Limits, **__: Any) -> None:
        asked.append(limits)
        raise LabrigError("nothing")

    monkeypatch.setattr("labrig.experiment.propose_experiment", proposed)
    assert propose(open_run, None, {}, **looker.questions[0]["adapt"]) == []  # type: ignore[arg-type]
    np.testing.assert_allclose(asked[0].slew_per_s, [5.0, 6.0, 7.0, 8.0])


def test_a_resumed_campaign_takes_the_logged_set_points(config: RigConfig, tmp_path: Path) -> None:
    """Set-points that were proposed before the interruption are part of the log: the rest of a probe is done."""
    folder, control = tmp_path / "run", Control()
    watching = Watching([_EndsAfter(control, 1)], control, adviser=adviser(config, Told(answer)))
    with connect(config, SimulatedClock()) as rig, pytest.raises(Interrupted):
        run(PLAN, rig, folder, watching=watching)
    looker = Told(answer)
    with connect(config, SimulatedClock()) as rig:
        resume(PLAN, rig, folder, watching=Watching(adviser=adviser(config, looker)))
    made = open_run(folder)["commanded"].values
    assert made[12:18, 0].tolist() == [11.0, 22.0, 11.0, 13.0, 17.0, 0.0]
    assert 12 not in looker.asked
    assert len(made) == 24


def test_a_set_point_beyond_a_limit_ends_the_run_before_it_moves(config: RigConfig, tmp_path: Path) -> None:
    """Limits hold for what is proposed as for what is planned: checked before anything moves, and vented."""
    looker = Told(lambda captures: {**said(captures, 0.5), "points": probe("too far", 61.0)})
    with (
        connect(config, SimulatedClock()) as rig,
        pytest.raises(LabrigError, match="c1 61 kPa is above its limit of 60 kPa; it was not sent"),
    ):
        run(PLAN, rig, tmp_path / "run", watching=Watching(adviser=adviser(config, looker)))
    measured = open_run(tmp_path / "run")
    assert measured.sizes["capture"] == 12
    assert measured["event_commanded"].values.max() <= 30.0
    assert measured["event_commanded"].values[-1].tolist() == [0.0] * 4
