"""A shape checked on a rig whose true pressures are seen: what comes before it moves, and how it ends vented."""

from typing import Any
from urllib.parse import quote

import pytest
import yaml

from labrig.log import summarise
from tests.shapes import NEAR, simulated, write_target

CHECK = {"target": "near.ply", "model": "model.yaml", "refine": 0, "without": [], "unit": ""}
SIMULATOR = {"base": {"kind": "simulator", "rig": "simulated.yaml"}}


@pytest.fixture
def shape(bench: Any) -> Any:
    """The workbench of the rig, with a target and the model of the rig's simulator."""
    write_target(bench.folder / "near.ply", NEAR)
    (bench.folder / "simulated.yaml").write_text(yaml.safe_dump(simulated()), encoding="utf-8")
    (bench.folder / "model.yaml").write_text(yaml.safe_dump(SIMULATOR), encoding="utf-8")
    return bench


def _plan(shape: Any) -> dict[str, Any]:
    status, plan = shape.ask("/api/shape/check/plan", CHECK)
    assert status == 200, plan
    return plan


def _start(shape: Any, shown: dict[str, Any], rig: bool = True, **more: Any) -> tuple[int, Any]:
    asked = {**shown["asked"], "plan": shown["plan"], "out": shown["out"], "mine": True, **more}
    return shape.ask("/api/shape/check/start", asked, rig)


def _standing(shape: Any, run: str) -> dict[str, Any]:
    return shape.ask(f"/api/shape/check?run={quote(run)}")[1]


def _filled(shape: Any, rig: Any) -> dict[str, Any]:
    """Start a check, and wait until it has filled a chamber; how it stands then."""
    status, begun = _start(shape, _plan(shape))
    assert status == 202, begun
    rig.wait_above(10.0)
    return _standing(shape, begun["run"])


def test_the_plan_comes_first_and_moves_nothing(shape: Any, rig: Any) -> None:
    """Its set-points are the pressures for the target, all of them within the limits that are told."""
    plan = _plan(shape)
    highest = max(max(step["pressure_kpa"]) for step in plan["steps"] if step["kind"] == "actuate")
    assert highest == pytest.approx(NEAR.max(), abs=1.0)
    assert plan["broken"] == []
    assert {(low, high) for _, low, high, _ in plan["limits"]} == {(0.0, 60.0)}
    assert plan["captures"] == 1
    assert rig.highest_kpa < 1.0


@pytest.mark.parametrize(
    ("changes", "said"),
    [
        ({"mine": False}, "nothing was moved: say first that the rig is yours and nobody is near it"),
        ({"refine": 1}, "no plan: rig bench has no scanner, and refining needs one"),
        ({"without": ["warp"]}, "model.yaml: has no warp that could be left out"),
        ({"plan": "another"}, "nothing was moved: this is not the plan that was shown"),
        ({"out": "near.ply"}, "near.ply: choose the name of a new run"),
    ],
)
def test_what_is_wrong_is_said_and_nothing_moves(
    shape: Any, rig: Any, changes: dict[str, Any], said: str
) -> None:
    """In one line, before a process is begun."""
    status, answer = _start(shape, _plan(shape), **changes)
    assert status == 400
    assert said in answer["error"]
    assert rig.highest_kpa < 1.0


def test_only_the_page_that_was_opened_for_the_rig_begins_one(shape: Any, rig: Any) -> None:
    """Whoever has the workbench's address alone sees the plan, and moves nothing."""
    status, answer = _start(shape, _plan(shape), rig=False)
    assert status == 403
    assert "only the page" in answer["error"]
    assert rig.highest_kpa < 1.0


def test_limits_that_became_lower_since_the_plan_hold(shape: Any, rig: Any) -> None:
    """What was shown is not what would be done now: it does not start until the new plan is seen."""
    plan = _plan(shape)
    content = yaml.safe_load(rig.file.read_text(encoding="utf-8"))
    for chamber in content["chambers"]:
        chamber["max_kpa"] = 30
    rig.file.write_text(yaml.safe_dump(content), encoding="utf-8")
    status, answer = _start(shape, plan)
    assert (status, "this is not the plan that was shown" in answer["error"]) == (400, True)
    lower = _plan(shape)
    assert max(max(step["pressure_kpa"]) for step in lower["steps"] if step["kind"] == "actuate") <= 30.0
    assert rig.highest_kpa < 1.0


@pytest.mark.slow
def test_one_that_is_cancelled_vents_first_and_is_gone_on_with(shape: Any, rig: Any, until: Any) -> None:
    """Cancelled while chambers are filled it ends with all of them empty; gone on with it says what it measured."""
    told = _filled(shape, rig)
    run = told["run"]
    assert (told["state"], told["measuring"], told["found"]) == ("running", True, None)
    assert shape.ask("/api/watch/start", {"procedure": "capture", "out": "other"})[0] == 400
    assert shape.ask(f"/api/jobs/{told['job']}/cancel", {})[0] == 202
    until(lambda: _standing(shape, run)["state"] != "running", "the check goes on")
    assert rig.highest_kpa < 3.0
    told = _standing(shape, run)
    assert (told["state"], told["vented"], told["can_resume"]) == ("cancelled", True, True)
    assert "cancel" in told["ended"]
    assert shape.now(run)["procedure"] == "validate"  # by which Watch leads to what its scans showed
    refused = shape.ask("/api/shape/check/resume", {"run": run})
    assert (refused[0], "say first that the rig is yours" in refused[1]["error"]) == (400, True)
    assert shape.ask("/api/shape/check/resume", {"run": run, "mine": True})[0] == 202
    until(lambda: _standing(shape, run)["found"], "nothing was found", 120.0)
    told = _standing(shape, run)
    (one,) = told["found"]
    assert (one["target"], one["realised_mm"]) == ("near.ply", None)  # this rig has no scanner
    assert one["markers_against_predicted_mm"]["mean"] < 2.0
    assert (told["vented"], told["can_resume"], told["ended"]) == (True, False, "completed")
    (shape.folder / run / "validation.json").unlink()
    assert (_standing(shape, run)["can_compare"], _standing(shape, run)["can_resume"]) == (True, False)
    assert shape.ask("/api/shape/check/resume", {"run": run}, rig=False)[0] == 202  # which moves nothing
    until(lambda: _standing(shape, run)["found"], "its scans are not compared", 120.0)
    assert shape.ask("/api/shape/check/resume", {"run": run, "mine": True})[0] == 400
    assert shape.ask("/api/shape")[1]["checks"][0]["run"] == run
    assert rig.highest_kpa < 3.0


@pytest.mark.slow
def test_the_vent_button_ends_one(shape: Any, rig: Any, press_vent: Any, until: Any) -> None:
    """Pressed during a check it vents, confirmed, and the check says who ended it."""
    run = _filled(shape, rig)["run"]
    assert "vented, confirmed" in press_vent(shape.vent_address())
    assert rig.highest_kpa < 3.0
    until(lambda: _standing(shape, run)["state"] != "running", "the check goes on")
    told = _standing(shape, run)
    assert (told["vented"], told["can_resume"], told["found"]) == (True, True, None)
    assert "the vent button" in told["ended"]
    assert "the vent button" in summarise(shape.folder / run).state
