"""An investigation's page says what its figures are of, and its form shows what it begins with."""

import json
import shutil
from collections.abc import Callable, Iterator
from typing import Any

import pytest

from labrig.log import run_id

ONE = "investigation-1"
LONG = "runs/20261130-120000-first-campaign"
WHOLE = """e => {
    const free = e.cloneNode(true);
    free.style.cssText = "position: absolute; width: auto; max-width: none";
    e.parentElement.append(free);
    const wanted = free.offsetWidth;
    free.remove();
    return e.offsetWidth >= wanted;
}"""


@pytest.fixture
def open_at(asked: Any, browser: Any) -> Iterator[Callable[[str], Any]]:
    """Opens the workbench of a run and two models at an address within it."""
    page = browser.new_page(viewport={"width": 1280, "height": 900}, reduced_motion="reduce")
    page.set_default_timeout(60_000)

    def at(address: str) -> Any:
        page.goto(asked.address)
        page.evaluate("hash => location.hash = hash", address)
        return page

    yield at
    page.close()


def test_what_the_errors_of_an_investigation_are_of_is_said(asked: Any, open_at: Any) -> None:
    """Beside the table, beside the link, and in the list of runs: those here are of all captures together."""
    folder = asked.folder / ONE
    shutil.copytree(asked.folder / "runs" / "run", folder / "run-2")
    settings = {"rig": "rig.yaml", "model": "better.yaml", "budget_min": 1.0, "out": ONE, "seed": 0}
    known = {"verdict": "identified", "effects": ["leak"], "rivals": [], "probability": 0.9, "captures": 16}
    known |= {"error": {"base": 0.9, "model": 0.385, "floor": 0.129}}
    content = {
        "state": "settled",
        "conclusion": "Leak: with it the error falls from 0.9 to 0.2 mm on captures recorded after the verdict.",
        "units": "mm",
        "minutes": 0.5,
        "budget_min": 1.0,
        "rounds": [
            {"round": 1, "programme": "given", "run": "run", "minutes": 0.0, "given": ["runs/run"], **known},
            {"round": 2, "programme": "confirmation", "run": "run-2", "minutes": 0.5, **known},
        ],
        "confirmation": {"effects": ["leak"], "before": 0.9, "after": 0.2, "floor": 0.129, "run": "run-2"},
        "waterfall": [],
        "model": f"{ONE}/better.yaml",
        "warnings": [],
        "settings": {**settings, "highest": 0.8, "realtime": False, "runs": ["runs/run"]},
    }
    (folder / "investigation.json").write_text(json.dumps(content), encoding="utf-8")
    runs = [{"run": "runs/run", "id": run_id(folder / "run-2")}]
    result = {"model": "better.yaml", "units": "mm", "effects": ["leak"], "verdict": "identified"}
    result |= {"error": known["error"], "runs": runs}
    (folder / "diagnosis-2").mkdir()
    (folder / "diagnosis-2" / "diagnosis.json").write_text(json.dumps(result), encoding="utf-8")
    page = open_at(f"#/watch?investigation={ONE}")
    page.wait_for_selector("#rounds tbody")
    heads = page.locator("#rounds th").all_inner_texts()
    assert heads[-3:] == ["error of all, mm", "floor of all", "run by itself"]
    assert "all captures up to a round together" in page.inner_text("#rounds")
    assert "fitted to all 32 captures" in page.inner_text("#of-what")
    page.evaluate("location.hash = '#/choose'")
    page.wait_for_selector(f"tr[data-run='{ONE}/run-2']:has-text('2 runs together')")


def test_the_form_shows_whole_names(asked: Any, open_at: Any) -> None:
    """At 1280 pixels neither the run that it begins with nor the model is cut."""
    shutil.copytree(asked.folder / "runs" / "run", asked.folder / LONG)
    page = open_at(f"#/run/{LONG}/watch")
    for box in ("#begin-with", "#investigate-model"):
        page.wait_for_selector(box)
        assert page.locator(box).evaluate(WHOLE)
    assert page.input_value("#investigation-out").startswith("investigation-")
