"""A campaign is planned, started, watched, paused and ended from the workbench; it never depends on it."""

import json
from typing import Any

import pytest

from labrig.log import open_run, summarise

QUICK = ("--captures", 4, "--repeated", 0, "--settle-s", 0.4, "--record-s", 0.4)


def test_the_plan_comes_first_and_moves_nothing(bench: Any, rig: Any) -> None:
    """The dry run gives steps, set-points, duration and limits, and the command that it is."""
    before = set(bench.folder.glob("*/log.*"))
    status, plan = bench.ask("/api/watch/plan", {"procedure": "capture", "arguments": ["--captures", "5"]})
    assert status == 200
    assert plan["captures"] == 5
    assert plan["broken"] == []
    assert plan["duration_s"] == pytest.approx(sum(1 + 3 for _ in range(5)), rel=0.5)
    assert len([step for step in plan["steps"] if step["kind"] == "actuate"]) >= 5
    assert plan["command"].startswith("labrig run capture --captures 5 --rig ")
    assert plan["command"].endswith("--dry-run")
    assert len(plan["limits"]) == len(rig.twins.plant.channels)
    assert rig.highest_kpa < 1.0
    assert set(bench.folder.glob("*/log.*")) == before


def test_a_plan_that_breaks_a_limit_does_not_start(bench: Any, rig: Any) -> None:
    """A procedure file with a set-point above a chamber's limit is shown with what it breaks, and refused."""
    chamber = rig.twins.plant.channels[0].name
    (bench.folder / "high.yaml").write_text(
        f"procedure: programme\npoints: [{{pressure_kpa: {{{chamber}: 500}}, hold_s: 1}}]\n", encoding="utf-8"
    )
    assert "high.yaml" in bench.ask("/api/watch/rig")[1]["files"]
    _, plan = bench.ask("/api/watch/plan", {"procedure": "high.yaml"})
    assert "500 kPa is above its limit" in plan["broken"][0]
    status, content = bench.ask("/api/watch/start", {"procedure": "high.yaml", "out": "never"})
    assert status == 400
    assert "nothing was moved" in content["error"]


def test_only_the_plan_that_was_shown_starts(bench: Any, rig: Any) -> None:
    """A start names the plan that was shown; one of other parameters, or of a rig file edited since, moves nothing."""
    asked = {"procedure": "capture", "arguments": ["--captures", "8", "--highest", "0.2"]}
    plan = bench.ask("/api/watch/plan", asked)[1]
    assert plan["asked"] == {**asked, "seed": 0}
    other = {
        **asked,
        "arguments": ["--captures", "8", "--highest", "1"],
        "plan": plan["plan"],
        "out": "never",
    }
    unseen = {**asked, "out": "never"}
    for wrong in (other, unseen):
        status, content = bench.ask("/api/watch/start", wrong)
        assert status == 400
        assert "not the plan that was shown" in content["error"]
    text = rig.file.read_text(encoding="utf-8")
    rig.file.write_text(text.replace("max_kpa: 60", "max_kpa: 50", 1), encoding="utf-8")
    edited = {**asked, "plan": plan["plan"], "out": "never"}
    assert "not the plan that was shown" in bench.ask("/api/watch/start", edited)[1]["error"]
    assert not (bench.folder / "never").exists()


def test_a_plan_that_is_too_long_holds_nothing_up(bench: Any) -> None:
    """More set-points than a plan may have are refused in one line, and the workbench answers meanwhile."""
    asked = {"procedure": "capture", "arguments": ["--captures", "1000000000"]}
    status, content = bench.ask("/api/watch/plan", asked)
    assert status == 400
    assert (
        content["error"]
        == "no plan: capture: more than 100000 set-points; ask for fewer, or measure in several runs"
    )
    assert bench.ask("/api/watch/rig")[0] == 200


def test_only_the_page_that_was_opened_for_the_rig_moves_it(bench: Any) -> None:
    """A page with the workbench's token alone can look, and starts nothing."""
    status, content = bench.ask("/api/watch/start", {"procedure": "capture", "out": "never"}, rig=False)
    assert status == 403
    assert "labrig workbench --rig" in content["error"]
    assert not (bench.folder / "never").exists()


@pytest.mark.slow
def test_a_run_is_watched_paused_continued_and_ends(bench: Any, rig: Any, until: Any) -> None:
    """The live state has surface, pressures and step; a pause vents; what is logged in the end is whole."""
    run = bench.start("first", *QUICK)
    state = bench.live(run)
    assert len(state["position_mm"]) == len(state["markers"]) == len(state["rest_mm"])
    assert bench.ask("/api/watch/rig")[1]["running"] == [run]
    assert bench.ask("/api/watch/start", {"procedure": "capture", "out": "second"})[0] == 400
    assert bench.ask("/api/watch/pause", {"run": run})[1] == {"paused": True}
    until(lambda: any(row[3].startswith("paused") for row in bench.now(run)["events"]), "it does not pause")
    until(lambda: rig.highest_kpa < 3.0, "a pause does not vent")
    assert bench.ask("/api/watch/go_on", {"run": run}, rig=False)[0] == 403
    assert bench.ask("/api/watch/go_on", {"run": run})[1] == {"paused": False}
    over = until(lambda: (s := bench.now(run)) and not s["live"] and s, "the run does not end")
    assert over["state"] == "completed"
    assert over["captures"] == 4
    assert open_run(bench.folder / run).sizes["capture"] == 4
    assert rig.highest_kpa < 3.0


def test_end_vents(bench: Any, rig: Any, until: Any) -> None:
    """The end of a run from the page is the runner's own: vented, with the reason in its log."""
    run = bench.start("first", "--captures", 50, "--settle-s", 0.3, "--record-s", 0.3)
    bench.live(run)
    rig.wait_above(10.0)
    bench.ask("/api/watch/end", {"run": run}, rig=False)
    until(lambda: not bench.now(run)["live"], "the run does not end")
    assert rig.highest_kpa < 3.0
    assert "the workbench" in summarise(bench.folder / run).state


@pytest.mark.slow
def test_the_run_goes_on_without_the_workbench(bench: Any, rig: Any, until: Any) -> None:
    """Ctrl-C in the workbench's terminal ends the server; the run goes on, and is found again."""
    from labrig._running import notes

    run = bench.start("first", *QUICK)
    bench.live(run)
    said = bench.stop()
    assert "still at work" in said
    folder = str(bench.folder / run)
    assert [note for note in notes("run") if note.facts["folder"] == folder]
    until(lambda: not [note for note in notes("run") if note.facts["folder"] == folder], "it does not end")
    assert summarise(bench.folder / run).state == "completed"


def test_the_error_of_the_open_model_follows_the_captures(bench: Any, rig: Any, until: Any) -> None:
    """Every capture is held against the model while the run goes on, with the same numbers as afterwards."""
    (bench.folder / "model.py").write_text(
        "import json\nfrom pathlib import Path\nimport numpy as np\n"
        "REST = np.array(json.loads(Path(__file__).with_name('rest.json').read_text()))\n"
        "def predict(actuation):\n    return np.repeat(REST.reshape(1, -1), len(actuation), axis=0)\n",
        encoding="utf-8",
    )
    (bench.folder / "rest.json").write_text(
        json.dumps(rig.twins.plant.plant.rest_mm.tolist()), encoding="utf-8"
    )
    (bench.folder / "model.yaml").write_text(
        "base: {kind: python, file: model.py, function: predict}\neffects: []\n", encoding="utf-8"
    )
    run = bench.start("first", "--captures", 50, "--settle-s", 0.3, "--record-s", 0.4)
    bench.live(run)

    def known() -> Any:
        error = bench.now(run, model="model.yaml").get("error") or {}
        assert "error" not in error, error
        return error if len(error.get("captures", [])) >= 3 else None

    error = until(known, "no error is known")
    bench.ask("/api/watch/end", {"run": run})
    until(lambda: not bench.now(run)["live"], "the run does not end")
    measured = open_run(bench.folder / run)
    settled = measured["position_mm"].where(measured["settled"]).mean("time").values
    rest = rig.twins.plant.plant.rest_mm
    for capture, position in zip(error["captures"], settled, strict=False):
        assert capture["rms"] == pytest.approx(float(((position - rest) ** 2).mean() ** 0.5), rel=0.02)
