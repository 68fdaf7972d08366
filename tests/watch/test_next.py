"""What to measure next, and two models on one run: jobs whose results lie in files, read by the page."""

import os
import time
from typing import Any

import pytest


def test_two_models_on_one_run(asked: Any, until: Any) -> None:
    """The comparison is a command, its result a file, and the page is told which model is nearer and by how much."""
    query = "/api/versus?run=runs/run&a=worse.yaml&b=better.yaml"
    before = asked.ask(query)[1]
    assert before["found"] is None
    assert before["command"].startswith(
        "labrig compare runs/run --model worse.yaml --model better.yaml --out "
    )
    status, job = asked.ask("/api/versus", {"run": "runs/run", "a": "worse.yaml", "b": "better.yaml"})
    assert status == 202
    until(lambda: asked.ask(f"/api/jobs/{job['job']}")[1]["state"] != "running", "the job does not end")
    found = asked.ask(query)[1]["found"]
    assert found["better"] == "better"
    assert found["difference"]["low"] > 0
    assert found["error"]["worse"] ** 2 == pytest.approx(found["error"]["better"] ** 2 + 81.0, rel=0.05)
    assert (
        asked.ask("/api/versus?run=runs/run&a=better.yaml&b=worse.yaml")[1]["found"] is None
    )  # the other order
    edited_ns = time.time_ns() + 10**9
    os.utime(asked.folder / "better.py", ns=(edited_ns, edited_ns))
    assert asked.ask(query)[1]["found"] is None  # of a model that is another one since
    status, content = asked.ask("/api/versus?run=runs/run&a=better.yaml&b=better.yaml")
    assert status == 400
    assert "two models" in content["error"]


@pytest.mark.slow
def test_what_to_measure_next_becomes_a_plan(asked: Any, until: Any) -> None:
    """The programme that `labrig next` finds is shown with its minutes, and can be run as it is."""
    query = "/api/next?run=runs/run&model=better.yaml&minutes=3"
    before = asked.ask(query)[1]
    assert before["found"] is None
    assert "--minutes 3 " in before["command"]
    status, job = asked.ask("/api/next", {"run": "runs/run", "model": "better.yaml", "minutes": 3})
    assert status == 202
    until(lambda: asked.ask(f"/api/jobs/{job['job']}")[1]["state"] != "running", "the job does not end", 100)
    ended = asked.ask(f"/api/jobs/{job['job']}")[1]
    after = asked.ask(query)[1]
    if ended["state"] == "failed":
        pytest.fail(ended["output"])
    assert 0 < after["found"]["minutes"] <= 3.5
    assert after["procedure"] in asked.ask("/api/watch/rig")[1]["files"]
    plan = asked.ask("/api/watch/plan", {"procedure": after["procedure"]})[1]
    assert plan["broken"] == []
    assert plan["duration_s"] == pytest.approx(60 * after["found"]["minutes"], rel=0.01)


def test_a_run_on_a_simulated_clock_is_over_at_once(asked: Any, until: Any) -> None:
    """`as fast as it goes`: nothing to watch, the run is there when its job is done."""
    body = {"procedure": "capture", "arguments": ["--captures", "5"]}
    status, content = asked.begin("runs/fast", body, realtime=False)
    assert status == 202
    assert "--realtime" not in content["command"]
    until(lambda: asked.ask(f"/api/jobs/{content['job']}")[1]["state"] == "done", "it does not end")
    assert asked.now("runs/fast")["captures"] == 5


def test_a_rig_that_is_simulated_inside_its_run_is_vented_by_it(
    asked: Any, until: Any, press_vent: Any
) -> None:
    """There is no link to open: the run ends, and says what its chambers read."""
    body = {"procedure": "capture", "arguments": ["--captures", "50", "--settle-s", "1"]}
    assert asked.begin("runs/slow", body)[0] == 202
    asked.live("runs/slow")
    until(lambda: max(asked.now("runs/slow")["measured_kpa"]) > 10, "no chamber was filled")
    text = press_vent(asked.vent_address())
    assert "vented, confirmed" in text
    assert "by the run" in text
    until(lambda: not asked.now("runs/slow")["live"], "the run goes on")
    assert asked.now("runs/slow")["vented"] is True


@pytest.mark.slow
def test_only_a_model_of_this_rig_is_held_against_a_run(asked: Any, until: Any) -> None:
    """Models of other chambers are neither offered nor used; a map fitted to the captures says nothing of few."""
    (asked.folder / "line.yaml").write_text("base: {kind: static, degree: 1}\n", encoding="utf-8")
    (asked.folder / "other.yaml").write_text(
        "base: {kind: static, degree: 1}\neffects:\n"
        "- {name: creep, fitted_on: {chambers: [Solldruck], low: [0.0], high: [2.4]}}\n",
        encoding="utf-8",
    )
    body = {
        "procedure": "capture",
        "arguments": ["--captures", "2000", "--settle-s", "0.3", "--record-s", "0.3"],
    }  # it goes on until it is ended below, however late the processes that look at it begin
    status, plan = asked.ask("/api/watch/plan", {**body, "model": "other.yaml"})
    assert (status, plan["diagnose"]) == (200, "")
    assert asked.ask("/api/watch/plan", {**body, "model": "better.yaml"})[1]["diagnose"] == "better.yaml"
    assert asked.begin("runs/slow", body, diagnose="other.yaml")[0] == 400
    assert asked.begin("runs/slow", body)[0] == 202
    until(lambda: "runs/slow" in asked.ask("/api/watch/rig")[1]["running"], "it does not answer")
    offered = asked.ask("/api/watch/models?run=runs/slow")[1]["models"]
    assert "better.yaml" in offered
    assert "other.yaml" not in offered
    said: set[str] = set()

    def known(model: str) -> Any:
        now = asked.now("runs/slow", model=model)
        assert now["live"]
        error = now.get("error") or {}
        said.add(error.get("error", ""))
        return error.get("captures")

    until(lambda: known("better.yaml"), "no error is known")  # asked from the run's first moment on
    assert said == {""}
    assert not known("other.yaml")
    assert said == {
        "",
        "other.yaml is for chamber Solldruck; the rig has chambers c1, c2, c3, c4; choose another model",
    }
    until(lambda: known("line.yaml"), "no error of the line is known")
    assert len(known("line.yaml")) > 5
    asked.ask("/api/watch/end", {"run": "runs/slow"})
    until(lambda: not asked.now("runs/slow")["live"], "the run goes on")
