"""An investigation from the workbench: refused, started, ended, gone on with; how it stands is read from its files."""

import json
import urllib.request
from collections.abc import Callable, Iterator
from pathlib import Path
from typing import Any

import pytest

from labrig.log import summarise
from labrig.rig import in_use, load_rig

START, RESUME, END = (f"/api/investigate/{word}" for word in ("start", "resume", "end"))
ASKED = {
    "runs": [],
    "model": "better.yaml",
    "budget_min": 5,
    "highest": 0.6,
    "out": "asked/one",
    "mine": True,
}


@pytest.fixture
def bench(asked: Any) -> Iterator[Any]:
    """The workbench of a simulated rig; nothing that a test began goes on after it."""
    yield asked
    for name in asked.ask("/api/watch/rig")[1]["investigating"]:
        asked.ask(END, {"name": name})


@pytest.fixture
def stands(bench: Any, until: Any) -> Callable[..., Any]:
    """How an investigation stands, once that holds."""

    def when(name: str, holds: Callable[[Any], Any], what: str = "it does not come to that") -> Any:
        def look() -> Any:
            status, told = bench.ask(f"/api/investigate/state?name={name}")
            assert status == 200, told
            return told if holds(told) else None

        return until(look, what)

    return when


def jobs_of(folder: Path) -> list[list[str]]:
    """The words of the jobs that were started."""
    return [
        json.loads(path.read_text())["words"] for path in sorted(folder.glob(".workbench/jobs/*/job.json"))
    ]


def test_what_could_be_begun_moves_nothing(bench: Any) -> None:
    """The card is told the rig, the models that fit, and a folder that is new; nothing is started for it."""
    status, told = bench.ask("/api/investigate?run=runs/run")
    assert status == 200
    assert told["rig"] == "small"
    assert set(told["models"]) == {"better.yaml", "worse.yaml"}
    assert told["other_rig"] == ""
    assert not (bench.folder / told["out"]).exists()
    assert bench.ask("/api/investigate")[1]["models"] == told["models"]
    assert jobs_of(bench.folder) == []


@pytest.mark.parametrize(
    ("changes", "said"),
    [
        ({"mine": False}, "nothing was moved: say first that the rig is yours and nobody is near it"),
        ({"budget_min": -1}, "-1: give the time on the rig in minutes, more than 0"),
        ({"budget_min": "nan"}, "nan: give the time on the rig in minutes, more than 0"),
        ({"highest": 1.2}, "1.2: the highest pressure is a share of the limit, 0.1 to 1"),
        ({"out": "runs"}, "runs: choose the name of a new folder"),
        ({"out": "../elsewhere"}, "../elsewhere: lies outside the workbench's folder "),
        ({"model": "none.yaml"}, "there is no none.yaml in "),
        ({"model": "other.yaml"}, "nothing was moved: other.yaml is for chamber Solldruck; the rig has chambers"),
        ({"runs": ["runs/none"]}, "there is no runs/none in "),
    ],
)  # fmt: skip
def test_what_is_wrong_is_said_and_nothing_begins(bench: Any, changes: dict[str, Any], said: str) -> None:
    """One line for each; no job is started and no folder made."""
    (bench.folder / "other.yaml").write_text(
        "base: {kind: static, degree: 1}\neffects:\n"
        "- {name: creep, fitted_on: {chambers: [Solldruck], low: [0.0], high: [2.4]}}\n",
        encoding="utf-8",
    )
    status, content = bench.ask(START, {**ASKED, **changes})
    assert status == 400
    assert content["error"].startswith(said)
    assert jobs_of(bench.folder) == []
    assert not (bench.folder / "asked").exists()


def test_only_the_page_that_was_opened_for_the_rig_begins_one(bench: Any) -> None:
    """With the workbench's token alone nothing is started and nothing gone on with."""
    for path in (START, RESUME):
        status, content = bench.ask(path, {**ASKED, "name": "asked/one"}, rig=False)
        assert status == 403
        assert "labrig workbench --rig" in content["error"]
    assert jobs_of(bench.folder) == []


@pytest.mark.slow
def test_one_goes_from_its_start_to_its_end(lab: Any, until: Any) -> None:
    """The command has what was asked for; round, verdict and errors come from its files, its report is shown alone."""
    bench = lab("nothing")
    body = {**ASKED, "runs": ["first"], "model": "model.yaml", "budget_min": 3, "realtime": False}
    assert bench.ask(START, body)[0] == 202
    rig = str(bench.folder / "rig.yaml")
    words = ["investigate", "first", "--rig", rig, "--model", "model.yaml", "--budget", "3"]
    assert jobs_of(bench.folder) == [[*words, "--highest", "0.6", "--out", "asked/one"]]
    assert bench.ask("/api/watch/rig")[1]["investigating"] == ["asked/one"]

    def over() -> Any:
        told = bench.ask("/api/investigate/state?name=asked/one")[1]
        return None if told["alive"] else told

    told = until(over, "it does not end")
    content = json.loads((bench.folder / "asked/one/investigation.json").read_text())
    assert (told["state"], told["conclusion"], told["why"]) == ("settled", content["conclusion"], "")
    assert told["can_resume"] is False
    first = told["rounds"][0]
    assert first["runs"] == [{"name": "first", "here": True}]
    assert (first["programme"], first["captures"], first["verdict"]) == ("given", 16, "nothing_missing")
    assert first["error"]["floor"] == content["rounds"][0]["error"]["floor"] > 0
    assert told["picture"] is None  # one round is no course
    assert bench.ask("/api/investigate")[1]["known"][0]["state"] == "settled"
    assert bench.ask(RESUME, {"name": "asked/one", "mine": True})[0] == 400
    for report in (told["report"], first["report"]):
        request = urllib.request.Request(
            f"{bench.origin}/reports/{report}", headers={"x-labrig-token": bench.token}
        )
        with urllib.request.urlopen(request, timeout=60) as answer:
            policies = answer.headers.get_all("content-security-policy")
            assert len(policies) == 1
            assert policies[0].startswith("sandbox allow-scripts; ")
            assert b"<html" in answer.read()
    for other in ("model.yaml", "asked/one/investigation.json", "asked/report.html"):
        assert bench.ask(f"/reports/{other}")[0] == 400


@pytest.mark.slow
def test_one_that_goes_on_has_the_rig_until_it_is_ended(bench: Any, stands: Any) -> None:
    """Nothing else begins beside it; its run is watched as any; its end leaves the chambers vented and can be gone on
    with, by a command that keeps to what was asked for.
    """
    assert bench.ask(START, ASKED)[0] == 202
    told = stands("asked/one", lambda s: (s.get("now") or {}).get("live"), "its run does not answer")
    run = told["now"]["live"]
    assert (run, told["now"]["what"], told["state"]) == ("asked/one/run-1", "measuring", "goes on")
    live = bench.live(run)
    assert live["investigation"] == "asked/one"
    for path, body in ((START, {**ASKED, "out": "asked/two"}), (RESUME, {"name": "asked/one", "mine": True})):
        status, content = bench.ask(path, body)
        assert status == 400
        assert "goes on; end it first" in content["error"] or "cannot be gone on with" in content["error"]
    assert "goes on; end it first" in bench.begin("runs/second", {"procedure": "capture"})[1]["error"]
    assert bench.ask(END, {"name": "asked/one"}, rig=False)[1]["measuring"] is True
    told = stands("asked/one", lambda s: not s["alive"], "it does not end")
    assert (told["state"], told["can_resume"]) == ("interrupted", True)
    assert "ended by End in the workbench after" in told["conclusion"]
    assert bench.now(run)["vented"] is True
    assert summarise(bench.folder / run).state == "the workbench"
    assert told["resume"].endswith("--budget 5 --highest 0.6 --seed 0 --out asked/one --realtime --resume")
    assert bench.ask(END, {"name": "asked/one"})[0] == 400


def test_one_is_gone_on_with_by_the_command_it_was_begun_with(bench: Any, stands: Any) -> None:
    """Also after a power cut; what the command says against it stands there in one line."""
    folder = bench.folder / "asked" / "one"
    folder.mkdir(parents=True)
    rig = str(bench.folder / "rig.yaml")
    settings = {"rig": rig, "model": "better.yaml", "budget_min": 1.0, "out": "asked/one", "seed": 3}
    settings |= {"highest": 0.4, "realtime": False, "runs": ["runs/run"]}
    content = {"state": "under way", "conclusion": "Under way.", "units": "", "minutes": 0.0, "rounds": []}
    content |= {"confirmation": None, "budget_min": 1.0, "waterfall": [], "model": None, "warnings": []}
    (folder / "investigation.json").write_text(json.dumps({**content, "settings": {**settings, "runs": []}}))
    told = stands("asked/one", lambda _: True)
    assert (told["state"], told["alive"], told["can_resume"]) == ("cut short", False, True)
    assert bench.ask(RESUME, {"name": "asked/one", "mine": True})[0] == 202
    assert jobs_of(bench.folder)[-1] == [
        *("investigate", "--rig", rig, "--model", "better.yaml", "--budget", "1", "--highest", "0.4"),
        *("--seed", "3", "--out", "asked/one", "--resume"),
    ]  # fmt: skip
    told = stands("asked/one", lambda s: not s["alive"], "the job does not end")
    assert told["why"].startswith("a budget of 1 min is too little to begin with; give it ")
    folder.mkdir(exist_ok=True)
    for changed, said in (
        (
            {"rig": "/other/rig.yaml"},
            "asked/one was begun on the rig /other/rig.yaml; open the workbench for that",
        ),
        ({"model": "gone.yaml"}, "there is no gone.yaml in "),
        ({"model": "/gone.yaml"}, "/gone.yaml lies outside the workbench's folder: go on in a terminal"),
        ({"runs": ["runs/gone"]}, "asked/one began with runs/gone, which is not in this folder any more"),
    ):
        (folder / "investigation.json").write_text(
            json.dumps({**content, "settings": {**settings, **changed}})
        )
        assert stands("asked/one", lambda _: True)["resume_why"].startswith(said)
        assert bench.ask(RESUME, {"name": "asked/one", "mine": True})[0] == 400


def test_a_rig_that_somebody_uses_is_left_alone(bench: Any) -> None:
    """The line says who has it; a rig of another folder, with a link of its own, is known by that link."""
    text = (bench.folder / "rig.yaml").read_text()
    (bench.folder / "rig.yaml").write_text(
        text.replace("pressure: {kind: simulated}", "pressure: {kind: openpneu, port: /dev/ttyNONE}")
    )
    with in_use(load_rig(bench.folder / "rig.yaml"), "rig check"):
        status, content = bench.ask(START, ASKED)
    assert status == 400
    assert content["error"].startswith("rig check (process ")
    assert content["error"].endswith("is using this rig; wait, or stop it")
    assert jobs_of(bench.folder) == []


def test_an_unknown_one_is_said_to_be_none(bench: Any) -> None:
    """A name that is no investigation, also one outside the folder, is answered in one line."""
    for name in ("runs/run", "", "../elsewhere"):
        status, content = bench.ask(f"/api/investigate/state?name={name}")
        assert status == 400
        assert "investigation of this folder" in content["error"] or "lies outside" in content["error"]
