"""The rig over all its runs: a job whose result is a file, and what a page shows of it."""

import json
from pathlib import Path
from typing import Any

import pytest


def days(count: int) -> list[str]:
    """So many mornings."""
    return [f"2026-02-{day:02d} 08:00" for day in range(1, count + 1)]


def content(rig: str, model: str) -> dict[str, Any]:
    """What `labrig history` writes of a rig whose second chamber leaks from the fifth of six mornings on."""
    dates = days(6)
    leak = {"group": "leak", "name": "c2", "unit": "%/min", "runs": list(range(6)), "sd": [0.1] * 6}
    error = leak | {"group": "error", "name": "error", "unit": "mm"}
    change = {
        "group": "leak",
        "name": "c2",
        "unit": "%/min",
        "shape": "step",
        "begins": 4,
        "date": dates[4],
        "earliest": dates[3],
        "latest": dates[4],
        "noticed": 5,
        "noticed_date": dates[5],
        "before": [0.0],
        "after": [5.6],
        "amount": [5.6],
        "sd": 0.1,
        "odds": 1e6,
        "words": "the leak of c2 went from 0.00 to 5.60 %/min since 2026-02-05",
        "since_fit": True,
    }
    return {
        "rig": rig,
        "model": model,
        "fitted_until": None,
        "alpha": 0.05,
        "runs": [
            {"run": f"{k}", "date": date, "procedure": "check", "kind": "a"} for k, date in enumerate(dates)
        ],
        "quantities": [leak | {"value": [[0.0]] * 4 + [[5.6]] * 2}, error | {"value": [[0.1]] * 6}],
        "changes": [change],
        "unconfirmed": [],
        "left_out": [],
    }


def written(asked: Any) -> Path:
    """The history of the rig `small`, as the command would have left it beside its runs; the path of the file."""
    path = Path(asked.folder) / "history" / "small-better" / "history.json"
    path.parent.mkdir(parents=True)
    path.write_text(json.dumps(content("small", "better.yaml")), encoding="utf-8")
    return path


def test_the_history_of_a_rig_is_a_job(asked: Any, until: Any) -> None:
    """`labrig history` of the run's rig, in a folder of the rig's and the model's names, and what it said."""
    query = "/api/history?run=runs/run&model=better.yaml"
    before = asked.ask(query)[1]
    assert (before["rig"], before["found"]) == ("small", None)
    assert before["command"] == "labrig history small --model better.yaml --runs . --out history/small-better"
    status, job = asked.ask("/api/history", {"run": "runs/run", "model": "better.yaml"})
    assert status == 202
    until(lambda: asked.ask(f"/api/jobs/{job['job']}")[1]["state"] != "running", "the job does not end")
    found = asked.ask(query)[1]["found"]
    assert found["headline"].startswith(f"{found['runs']} run")
    assert "a change shows from the seventh run of a programme on" in found["headline"]
    assert found["changes"] == []
    assert {"data", "layout"} <= set(found["pictures"]["error"])
    assert asked.ask("/api/history?run=runs/run&model=worse.yaml")[1]["found"] is None


@pytest.mark.parametrize("wrong", [{"rig": "other"}, {"model": "worse.yaml"}, {"model": None}])
def test_a_history_of_something_else_is_not_shown(asked: Any, wrong: dict[str, Any]) -> None:
    """What lies in the folder and is of another rig or model, or damaged, counts as nothing."""
    path, query = written(asked), "/api/history?run=runs/run&model=better.yaml"
    found = asked.ask(query)[1]["found"]
    words = content("", "")["changes"][0]["words"]
    assert found["changes"] == [[words, "2026-02-06 08:00", True]]
    missing = json.dumps({"rig": "small", "model": "better.yaml"})
    for text in (json.dumps(content("small", "better.yaml") | wrong), '{"rig": "small"', "[]", missing):
        path.write_text(text, encoding="utf-8")
        assert asked.ask(query)[1]["found"] is None


def test_a_page_shows_what_changed(asked: Any, browser: Any) -> None:
    """In Watch, beside a run: the sentence, each change with its days, and each picture, which has an address."""
    written(asked)
    page = browser.new_page(viewport={"width": 1280, "height": 900}, reduced_motion="reduce")
    page.set_default_timeout(180_000)
    wrong: list[str] = []
    page.on("pageerror", lambda error: wrong.append(str(error)))
    page.goto(asked.address)
    page.evaluate("hash => location.hash = hash", "#/run/runs/run/watch?model=better.yaml")
    page.wait_for_selector("#history [data-drawn=leaks] .main-svg")
    assert "leak of c2" in page.inner_text("#history-words")
    row = page.inner_text("#history tbody tr")
    assert row.split("\t")[1:] == ["2026-02-06", "since the model was fitted"]
    page.select_option("#history select", "error")
    page.wait_for_selector("#history [data-drawn=error]")
    assert "picture=error" in page.url
    page.close()
    assert wrong == []
