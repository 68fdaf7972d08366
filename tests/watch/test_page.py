"""Watch in a real browser: a campaign from its plan to its end, and the vent while the page hangs."""

import os
import signal
from collections.abc import Iterator
from typing import Any

import pytest

from labrig.log import summarise
from tests.browsers import NO_WEBGL, frame_at

LONG = "--captures 150 --settle-s 0.3 --record-s 0.3"
PLACE = {"width": 1280, "height": 900}
BUTTON = (80, PLACE["height"] - 30)


@pytest.fixture
def page(bench: Any, browser: Any) -> Iterator[Any]:
    """The page as `labrig workbench` opens it; errors in its console fail the test."""
    context = browser.new_context(viewport=PLACE, reduced_motion="reduce")
    page = context.new_page()
    wrong: list[str] = []
    page.on("pageerror", lambda error: wrong.append(str(error)))
    page.on("console", lambda said: wrong.append(said.text) if said.type == "error" else None)
    page.goto(bench.address)
    page.wait_for_selector("#campaign")
    yield page
    context.close()
    assert [text for text in wrong if "ERR_" not in text and "Failed to load" not in text] == []


def _begin(page: Any) -> str:
    """Plan and start a campaign; gives its name."""
    page.select_option("#procedure", "capture")
    page.fill("#arguments", LONG)
    page.press("#arguments", "Tab")
    page.click("#show-plan")
    page.wait_for_selector("#plan-words")
    name = page.input_value("#out")
    page.click("#start")
    page.wait_for_selector(".live-run", timeout=180_000)
    return name


def _vent_frame(page: Any) -> Any:
    """Where the button says what became of a press; the button itself is in the frame around it."""
    return frame_at(page, "/said?theme=")


def _filled(page: Any, rig: Any) -> Any:
    """Wait until a chamber is filled and no vent before is told any more; gives the frame that tells of the next."""
    rig.wait_above(10.0)
    frame = _vent_frame(page)
    frame.wait_for_selector("b.good", state="detached", timeout=60_000)
    return frame


@pytest.mark.slow
def test_from_the_plan_to_the_end(bench: Any, rig: Any, page: Any, until: Any) -> None:
    """Plan, start, watch, reload (without WebGL: flat), pause, go on, end: each by a click, each true of the rig."""
    page.select_option("#procedure", "capture")
    page.fill("#arguments", LONG)
    page.press("#arguments", "Tab")
    page.click("#show-plan")
    assert "150 captures" in page.inner_text("#plan-words")
    assert "--dry-run" in page.inner_text("#plan .command")
    assert rig.highest_kpa < 1.0
    run = _begin(page)
    page.wait_for_selector(".surface canvas", timeout=180_000)
    assert page.locator("canvas.curve:visible").count() == 2
    page.add_init_script(NO_WEBGL)
    page.reload()
    page.wait_for_selector(".live-run .surface canvas.flat")
    page.wait_for_selector("text=no WebGL")
    rig.wait_above(10.0)
    page.click("#pause")
    page.wait_for_selector(".state.waiting:has-text('paused, vented')", timeout=180_000)
    until(lambda: rig.highest_kpa < 3.0, "the pause does not vent")
    assert page.get_attribute("#go-on", "title").startswith("fills the chambers again")
    page.click("#go-on")
    rig.wait_above(10.0)
    page.click("#end")
    page.click("#end")
    page.wait_for_selector("#over", timeout=180_000)
    assert rig.highest_kpa < 3.0
    assert "the workbench" in summarise(bench.folder / run).state


@pytest.mark.slow
def test_vent_while_the_page_hangs(bench: Any, rig: Any, page: Any, until: Any) -> None:
    """The button is a process of the browser's own: a script of the page that never ends does not reach it."""
    run = _begin(page)
    frame = _filled(page, rig)
    page.evaluate("setTimeout(() => { const end = Date.now() + 10000; while (Date.now() < end); }, 50)")
    page.wait_for_timeout(300)
    page.mouse.click(*BUTTON)
    frame.wait_for_selector("b.good", timeout=10_000)
    assert rig.highest_kpa < 3.0
    said = frame.inner_text("ul")
    assert all(channel.name in said for channel in rig.twins.plant.channels)
    until(lambda: not bench.now(run)["live"], "the run goes on")
    assert "the vent button" in summarise(bench.folder / run).state


@pytest.mark.slow
@pytest.mark.skipif(not hasattr(signal, "SIGSTOP"), reason="POSIX only")
def test_vent_with_the_workbench_stopped(bench: Any, rig: Any, page: Any) -> None:
    """The button asks another server than the page does."""
    _begin(page)
    frame = _filled(page, rig)
    os.kill(bench.process.pid, signal.SIGSTOP)
    try:
        page.mouse.click(*BUTTON)
        frame.wait_for_selector("b.good", timeout=180_000)
        assert rig.highest_kpa < 3.0
        page.wait_for_selector("body.lost", timeout=180_000)  # what it shows of the run is old
    finally:
        os.kill(bench.process.pid, signal.SIGCONT)
    page.wait_for_selector("body:not(.lost)", timeout=180_000)


def test_start_is_for_the_plan_that_is_shown(page: Any) -> None:
    """Other words in the boxes close Start, with a word why, until their own plan was shown."""
    page.select_option("#procedure", "capture")
    page.fill("#arguments", "--captures 8 --highest 0.2")
    page.click("#show-plan")
    page.wait_for_selector("#start:not([disabled])")
    page.fill("#arguments", "--captures 8 --highest 1")
    assert page.is_disabled("#start")
    assert "show the plan first" in page.inner_text("#start-why")
    page.click("#show-plan")
    page.wait_for_selector("#start:not([disabled])")
    page.select_option("#procedure", "idle")
    assert page.is_disabled("#start")
    assert page.input_value("#arguments") == ""


@pytest.mark.slow
def test_what_was_vented_is_not_said_of_a_rig_that_is_filled_again(rig: Any, page: Any) -> None:
    """After "Go on with it" no page says "vented, confirmed", and the button itself was never replaced."""
    _begin(page)
    frame = _filled(page, rig)
    button = frame.parent_frame.query_selector("button")
    page.mouse.click(*BUTTON)
    frame.wait_for_selector("b.good", timeout=180_000)
    page.click("#resume", timeout=180_000)
    rig.wait_above(10.0)
    frame.wait_for_selector("b.good", state="detached", timeout=60_000)
    assert button.is_visible()
    other = page.context.new_page()
    other.goto(page.url)
    other.wait_for_selector("#vent iframe")
    _vent_frame(other).wait_for_selector("body:has-text('every chamber of')")


def test_the_button_is_on_every_step(bench: Any, page: Any) -> None:
    """Also where no run is chosen, and on a page that was not opened for the rig."""
    for step in ("choose", "watch"):
        page.goto(f"{bench.origin}/#/{step}")
        page.wait_for_selector("#vent iframe")
    other = page.context.new_page()
    other.goto(f"{bench.origin}/#/watch")
    other.wait_for_selector("#vent iframe")
    other.click("#show-plan")
    other.wait_for_selector("#plan-words")
    assert other.is_disabled("#start")
