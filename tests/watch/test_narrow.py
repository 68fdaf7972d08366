"""A narrow window, or letters of twice the size: whatever acts on the rig is in sight."""

from typing import Any

import pytest

from tests.browsers import box_of, frame_at

LONG = "--captures 150 --settle-s 0.3 --record-s 0.3"


def _inside(part: Any, width: int, height: int) -> bool:
    """Whether it is in the window, and all of it."""
    box = box_of(part)
    return box["x"] >= 0 and box["x"] + box["width"] <= width and 0 <= box["y"] <= height - box["height"]


@pytest.mark.slow
def test_what_acts_on_the_rig_is_in_sight(bench: Any, rig: Any, browser: Any) -> None:
    """At 400 px VENT, its confirmation, Pause, Go on and End are in the window, and no page is wider than it."""
    width, height = 400, 800
    context = browser.new_context(viewport={"width": width, "height": height}, reduced_motion="reduce")
    page = context.new_page()
    page.goto(bench.address)
    page.wait_for_selector("#campaign")
    page.select_option("#procedure", "capture")
    page.fill("#arguments", LONG)
    page.click("#show-plan")
    page.click("#start:not([disabled])")
    page.wait_for_selector(".live-run", timeout=180_000)
    rig.wait_above(10.0)
    page.wait_for_timeout(500)
    assert page.evaluate("document.documentElement.scrollWidth") <= width
    page.mouse.wheel(0, 600)
    page.wait_for_timeout(300)
    for part in ("#go-on", "#pause", "#end", "#vent iframe"):
        assert _inside(page.locator(part), width, height), part
    button = frame_at(page, "/?theme=").locator("button")
    assert _inside(button, width, height)
    said = frame_at(page, "/said?theme=")
    said.wait_for_selector("b.good", state="detached", timeout=60_000)  # of a vent before
    button.click()
    said.wait_for_selector("b.good", timeout=180_000)
    assert _inside(said.locator("b.good"), width, height)
    said.wait_for_function("document.body && document.body.scrollWidth <= innerWidth", timeout=10_000)
    context.close()
