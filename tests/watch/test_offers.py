"""What Watch offers first, and where it leads: models before and after, procedures, a run that nobody could watch."""

import json
import time
from collections.abc import Iterator
from typing import Any

import pytest

from tests.waiting import wait_for

NEXT = "procedure: programme\npoints:\n- {pressure_kpa: {%s: 10}, hold_s: 4}\n"
IMPROVED = """
base: {kind: python, file: better.py, function: predict}
effects:
- {name: creep, fitted_on: {chambers: [c1, c2, c3, c4], low: [0, 0, 0, 0], high: [60, 60, 60, 60]}}
"""


@pytest.fixture
def page(asked: Any, browser: Any) -> Iterator[Any]:
    """A page that was opened for the rig; errors in its console fail the test."""
    context = browser.new_context(viewport={"width": 1280, "height": 900}, reduced_motion="reduce")
    context.set_default_timeout(180_000)
    page = context.new_page()
    wrong: list[str] = []
    page.on("pageerror", lambda error: wrong.append(str(error)))
    page.goto(asked.address)
    page.wait_for_selector("#campaign")
    yield page
    context.close()
    assert wrong == []


def _at(page: Any, address: str) -> None:
    page.evaluate("address => location.hash = address", address)


def test_the_original_is_before(asked: Any, page: Any) -> None:
    """Whatever its name, a model with more effects is the one after, also where it is the model that is open."""
    (asked.folder / "worse.yaml").unlink()
    (asked.folder / "an-improved-one.yaml").write_text(IMPROVED, encoding="utf-8")
    for model in ("an-improved-one.yaml", "better.yaml"):
        _at(page, f"#/run/runs/run/watch?model={model}")
        page.wait_for_selector(f"#about option[value='{model}'][selected]", state="attached")
        page.wait_for_selector("#versus #a")
        chosen = ["better.yaml", "an-improved-one.yaml"]
        wait_for(
            lambda chosen=chosen: [page.input_value(f"#versus #{which}") for which in "ab"] == chosen,
            "others are chosen",
        )


def test_a_programme_of_another_rig_is_not_proposed(asked: Any, page: Any) -> None:
    """The newest list of set-points is chosen beforehand if the rig has its chambers; else labrig's own capture is."""
    other, own = asked.folder / "runs/run/a/next.yaml", asked.folder / "runs/run/b/next.yaml"
    for path, chamber in ((other, "c9"), (own, "c2")):
        path.parent.mkdir()
        path.write_text(NEXT % chamber, encoding="utf-8")
        page.reload()
        page.wait_for_selector("#campaign")
        wanted = "capture" if chamber == "c9" else "runs/run/b/next.yaml"
        wait_for(lambda wanted=wanted: page.input_value("#procedure") == wanted, "another one is chosen")


def test_a_run_that_nobody_could_watch_is_led_to(asked: Any, page: Any) -> None:
    """As fast as it goes: the page waits, and has a link to the new run."""
    page.select_option("#procedure", "capture")
    page.fill("#arguments", "--captures 5")
    page.click("#show-plan")
    page.check("#fast")
    name = page.input_value("#out")
    page.click("#start")
    page.click("#measured a")
    page.wait_for_selector(f"#about .run:has-text('{name}')")


def test_nothing_to_settle_is_said_to_stay(asked: Any, page: Any) -> None:
    """That nothing is left to settle is an answer: it stands in the card, and no error is shown."""
    job = asked.folder / ".workbench" / "jobs" / "20260101-000000-000000000-aaaa"
    job.mkdir(parents=True)
    words = ["next", "runs/run", "--model", "better.yaml", "--minutes", "10"]
    about = {"words": words, "title": "what to measure next", "run": "runs/run", "started_s": 1.0}
    (job / "job.json").write_text(json.dumps(about), encoding="utf-8")
    said = "labrig: the verdict is nothing_missing: it leaves nothing to settle"
    (job / "output.txt").write_text(said, encoding="utf-8")
    (job / "ended.json").write_text(json.dumps({"code": 4, "ended_s": time.time()}), encoding="utf-8")
    _at(page, "#/run/runs/run/watch?model=better.yaml")
    assert "the verdict is nothing_missing" in page.inner_text("#settled-already")
    page.fill("#minutes", "2")
    assert "--minutes 2 " in page.inner_text("#next .command code")
    page.fill("#minutes", "-5")
    assert page.is_disabled("#propose")
    assert page.inner_text("#propose-why") == "the time on the rig: a number of minutes, 1 to 600"
    query = "/api/next?run=runs/run&model=better.yaml&minutes=10"
    assert asked.ask(query)[1]["settled"] == said.removeprefix("labrig: ")
    (asked.folder / "better.py").touch()
    assert asked.ask(query)[1]["settled"] == ""  # of another model


def test_a_rig_file_that_was_broken_is_said_and_vent_stays(asked: Any, page: Any) -> None:
    """A slip in the file is told where campaigns are begun, which none is until it is mended."""
    file = asked.folder / "rig.yaml"
    right = file.read_text("utf-8")
    file.write_text(right.replace("name: small", "nam: small"), encoding="utf-8")
    page.reload()
    page.wait_for_selector("#rig-wrong:has-text('nam: there is no such field')")
    page.wait_for_selector("#vent iframe")
    assert page.locator("#campaign, #investigate").count() == 0
    file.write_text(right, encoding="utf-8")
    page.reload()
    page.wait_for_selector("#campaign")


def test_a_file_that_is_no_rig_is_told_before_a_page_opens(asked: Any) -> None:
    """A page without VENT would be all that somebody sees who names the wrong file."""
    from labrig import LabrigError
    from labrig.workbench import open_desk

    with pytest.raises(LabrigError, match=r"better\.yaml"):
        open_desk(asked.folder, asked.folder / "better.yaml")
