"""An investigation in a real browser: by clicks to its end, and ended by a click with the chambers vented."""

import json
from collections.abc import Callable, Iterator
from typing import Any

import pytest

from labrig.log import summarise
from tests.browsers import frame_at

START = "#investigate-start"
STATIC = "base: {kind: static, degree: 1}\neffects: []\n"


@pytest.fixture
def open_page(browser: Any) -> Iterator[Callable[..., Any]]:
    """Opens a workbench's page for its rig; a script that fails in it fails the test."""
    contexts, wrong = [], []

    def opening(bench: Any, width: int = 1280) -> Any:
        context = browser.new_context(viewport={"width": width, "height": 900}, reduced_motion="reduce")
        context.set_default_timeout(180_000)
        contexts.append(context)
        page = context.new_page()
        page.on("pageerror", lambda error: wrong.append(str(error)))
        page.goto(bench.address)
        page.wait_for_selector(START)
        return page

    yield opening
    for context in contexts:
        context.close()
    assert wrong == []


@pytest.mark.slow
def test_from_the_click_to_the_new_model(lab: Any, open_page: Any) -> None:
    """A hidden leak is found and confirmed: rounds, conclusion, report, runs and model are there to be clicked."""
    bench = lab("leak")
    page = open_page(bench)
    page.evaluate("location.hash = '#/run/first/watch?model=model.yaml'")
    page.wait_for_selector("#begin-with option[value=first]", state="attached")
    assert "actuates bench again and again without asking" in page.inner_text("#investigate-acts")
    assert page.is_disabled(START)
    for box, typed, why in (
        ("#budget", "0", "time on the rig: a number of minutes, 1 to 10000"),
        ("#highest", "700", "highest pressure: 10 to 100 % of the limit"),
    ):
        before = page.input_value(box)
        page.fill(box, typed)
        assert page.inner_text("#investigate-why") == why
        page.fill(box, before)
    page.fill("#budget", "2")
    page.fill("#highest", "80")
    page.check("#investigate-fast")
    words = page.inner_text("#investigate .command code")
    assert "labrig investigate first --rig " in words
    assert " --model model.yaml --budget 2 --highest 0.8 --out investigation-" in words
    assert page.is_disabled(START)
    page.check("#mine")
    assert not list(bench.folder.glob("investigation-*"))
    page.click(START)
    page.wait_for_selector("#rig a.live")
    page.wait_for_selector("#investigation-state:has-text('settled')")
    folder = next(bench.folder.glob("investigation-*"))
    content = json.loads((folder / "investigation.json").read_text(encoding="utf-8"))
    assert page.inner_text("#conclusion") == content["conclusion"]
    assert content["conclusion"].startswith("Leak: with it the error falls from ")
    rows = page.locator("#rounds tbody tr")
    cells = rows.evaluate_all("rows => rows.map(row => [...row.cells].map(cell => cell.innerText))")
    assert len(cells) == len(content["rounds"]) > 1
    told = [(row[0], row[2], row[5]) for row in cells]
    assert told == [(str(k + 1), str(each["captures"]), "leak") for k, each in enumerate(content["rounds"])]
    page.wait_for_selector("#rounds-picture[data-drawn]")
    with page.context.expect_page() as opened:
        page.click("text=The report, round by round")
    report = opened.value
    report.wait_for_selector(f"h1:has-text('{content['conclusion']}')")
    report.click("table a >> nth=0")
    report.wait_for_selector("h1:has-text('Leak is missing')")
    page.click("text=Compare it with the last run")
    new = f"{folder.relative_to(bench.folder).as_posix()}/model.new.yaml"
    page.wait_for_selector(f"#about option[value='{new}'][selected]", state="attached")


@pytest.mark.slow
def test_ended_by_a_click_the_chambers_are_vented(bench: Any, rig: Any, open_page: Any) -> None:
    """On a rig whose true pressures are seen, in a narrow window: nothing moves before the click, its run is watched
    and paused as any, End vents, and what is kept can be gone on with by a click.
    """
    (bench.folder / "line.yaml").write_text(STATIC, encoding="utf-8")
    page = open_page(bench, 420)
    page.check("#mine")
    page.wait_for_selector(f"{START}:not([disabled])")
    assert rig.highest_kpa < 1.0
    page.click(START)
    page.wait_for_selector("#investigation-now:has-text('measuring')")
    rig.wait_above(10.0)
    assert page.evaluate("document.documentElement.scrollWidth") <= 420
    page.click("text=Watch this run, pause it")
    page.click("#part-of a")
    page.click("#end-investigation")
    page.click("#end-investigation")
    page.wait_for_selector("#investigation-state:has-text('interrupted')")
    assert rig.highest_kpa < 3.0
    folder = next(bench.folder.glob("investigation-*"))
    assert summarise(folder / "run-1").state == "the workbench"
    assert page.is_disabled("#resume-investigation")
    page.check("#mine-again")
    page.click("#resume-investigation")
    rig.wait_above(10.0)
    said = frame_at(page, "/said?theme=")
    said.wait_for_selector("b.good", state="detached")  # of a vent before
    frame_at(page, "/?theme=").locator("button").click()
    said.wait_for_selector("b.good", timeout=180_000)
    page.wait_for_selector("#conclusion:has-text('the vent button')")
    assert rig.highest_kpa < 3.0
    assert bench.ask("/api/watch/rig")[1]["investigating"] == []
