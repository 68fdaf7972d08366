"""An investigation is seen, paused and ended from outside, and two do not share a folder; on simulated rigs."""

import json
import threading
from collections.abc import Callable
from pathlib import Path
from typing import Any

import pytest
import yaml

import labrig
from labrig import LabrigError
from labrig._running import Note, notes
from labrig.campaign import Control, Interrupted
from labrig.investigation import Reporter
from labrig.investigation._endable import Endable
from labrig.log import summarise
from labrig.rig import investigations_on, vent_now
from tests.rigs import MODEL, RIG
from tests.waiting import wait_for


@pytest.fixture(autouse=True)
def here(tmp_path: Path, monkeypatch: pytest.MonkeyPatch, few_effects: Callable[..., None]) -> Path:
    """A folder with a rig and its model, in which the tests stand; few effects are asked about."""
    monkeypatch.chdir(tmp_path)
    few_effects("leak", "creep", "drift", "regulator")
    (tmp_path / "rig.yaml").write_text(yaml.safe_dump({**RIG, "simulated": {"surface": "membrane"}}))
    (tmp_path / "model.yaml").write_text(MODEL)
    return tmp_path


def investigated(reporter: Reporter | None = None, **more: Any) -> str:
    """How an investigation was interrupted, in its own words."""
    with pytest.raises(KeyboardInterrupt) as caught:
        labrig.investigate(
            None, "model.yaml", "rig.yaml", out="asked", budget_min=4, reporter=reporter, **more
        )
    return str(caught.value)


def state() -> Any:
    """What investigation.json says."""
    return json.loads(Path("asked/investigation.json").read_text(encoding="utf-8"))


def when_diagnosing(work: Callable[[], Any]) -> Reporter:
    """Does something between the first run and its diagnosis, and ends the test where it goes on to measure."""

    class Doing(Reporter):
        def round_started(self, number: int, programme: str, minutes: float) -> None:
            assert number == 1, "another run begins"

        def diagnosing(self, number: int, captures: int) -> None:
            work()

    return Doing()


def test_its_run_is_paused_and_ended_as_any_other(here: Path) -> None:
    """A run of an investigation answers, vents in a pause, and ends vented when it is told to: so does the whole."""
    said: list[str] = []
    work = threading.Thread(target=lambda: said.append(investigated(realtime=True)))
    work.start()

    def going() -> Note | None:
        found = [note for note in notes("run") if note.facts.get("folder") == str(here / "asked" / "run-1")]
        return found[0] if found else None

    run: Note = wait_for(going, "its run does not answer")

    def filled() -> bool:
        return max(run.ask("status")["measured_kpa"] or [0.0]) > 5.0

    wait_for(filled, "no chamber was filled")
    assert state()["now"]["what"] == "measuring"
    assert state()["now"]["run"] == "run-1"
    run.ask("pause")
    wait_for(lambda: any("paused" in event[3] for event in run.ask("status")["events"]), "it does not pause")
    wait_for(lambda: not filled(), "a pause does not vent")
    run.ask("go_on")
    wait_for(filled, "it does not go on")
    run.ask("end", why="a test")
    work.join(60)
    assert said[0].startswith("stopped by a test after ")
    assert "the chambers are vented; 0 rounds are in asked; to resume: " in said[0]
    assert (state()["state"], state()["now"]) == ("interrupted", None)
    assert summarise(here / "asked" / "run-1").state == "a test"


def test_a_vent_between_two_runs_ends_it(here: Path) -> None:
    """Chambers that somebody vents while it computes are not filled by its next run; what is known is kept."""
    config = labrig.load_rig("rig.yaml")

    def vent() -> None:
        assert [note.facts.get("folder") for note in investigations_on(config)] == [str(here / "asked")]
        vent_now(config, "the vent button")

    said = investigated(when_diagnosing(vent))
    assert said.startswith("stopped by the vent button, between two runs; the chambers are vented; 1 round")
    assert state()["state"] == "interrupted"
    assert state()["rounds"][0]["verdict"]
    assert investigations_on(config) == []


def test_two_in_one_folder_are_refused(here: Path) -> None:
    """The second says in one line who has the folder, and changes nothing in it."""
    (here / "other.yaml").write_text(
        yaml.safe_dump({**RIG, "name": "other", "simulated": {"surface": "membrane"}})
    )

    def second() -> None:
        before = state()
        who = r"^investigation asked \(process \d+, since .*\) is still going on; wait, or stop it$"
        with pytest.raises(LabrigError, match=who):
            labrig.investigate(None, "model.yaml", "other.yaml", out="asked", budget_min=4, resume=True)
        assert state() == before
        raise KeyboardInterrupt("enough")

    assert investigated(when_diagnosing(second)).startswith("enough")


def test_what_it_does_is_in_its_file(here: Path) -> None:
    """Whoever reads investigation.json meanwhile learns the round, its run, and that it is diagnosed just now."""
    seen: list[Any] = []

    def look() -> None:
        seen.append(state())
        raise KeyboardInterrupt("enough")

    investigated(when_diagnosing(look))
    now = seen[0]["now"]
    assert (now["what"], now["round"], now["programme"], now["run"]) == ("diagnosing", 1, "capture", "run-1")
    assert now["captures"] == summarise(here / "asked" / "run-1").captures
    assert now["minutes"] > 0
    assert (seen[0]["state"], seen[0]["rounds"]) == ("under way", [])


def test_gone_on_with_it_goes_no_higher_than_it_was_allowed(here: Path) -> None:
    """The highest pressure is that of the beginning, unless another one is given."""

    def enough() -> None:
        raise KeyboardInterrupt("enough")

    investigated(when_diagnosing(enough), highest=0.4)
    investigated(when_diagnosing(enough), resume=True)
    assert state()["settings"]["highest"] == 0.4
    investigated(when_diagnosing(enough), resume=True, highest=0.3)
    assert state()["settings"]["highest"] == 0.3


def test_no_run_begins_once_the_end_was_asked_for(here: Path) -> None:
    """Who vents just before a run begins finds the chambers as they were left: nothing moves."""
    with Endable(labrig.load_rig(here / "rig.yaml"), here / "asked") as endable:
        with endable.measuring(Control()):
            pass
        endable._answer({"do": "end", "why": "a vent from outside"})
        with (
            pytest.raises(Interrupted, match="stopped by a vent from outside, between two runs"),
            endable.measuring(Control()),
        ):
            pytest.fail("a run begins")
