"""What the page says of a run that goes on, beside what is drawn; the run is one that a test tells it of."""

import json
from collections.abc import Callable
from typing import Any

import pytest

LOOK = {
    "captures": 8,
    "minutes": 2.0,
    "verdict": "identified",
    "effects": ["dead_time"],
    "probability": {"dead_time": 0.6689, "creep": 0.25},
    "base": 1.4,
    "error": 0.31,
    "floor": 0.12,
    "units": "mm",
}
REST = [[0.0, 0.0, 0.0], [40.0, 0.0, 0.0], [0.0, 40.0, 0.0], [40.0, 40.0, 0.0]]
SKIN = {"weight": [[1.0 * (m == v) for m in range(4)] for v in range(4)], "triangles": [[0, 1, 2], [1, 3, 2]]}
SKIN |= {"scale": [[0, "#ffffff"], [1, "#b0492e"]], "steps": 16, "floor_mm": 0.2}
STATE: dict[str, Any] = {
    "live": True,
    "run": "told",
    "paused": False,
    "progress": {
        "steps": 9,
        "steps_done": 3,
        "captures_done": 2,
        "captures": 6,
        "elapsed_s": 9.0,
        "remaining_s": 30,
    },
    "history": {"time_s": [1.0, 2.0], "measured_kpa": [[0.0], [9.0]], "commanded_kpa": [[0.0], [10.0]]},
    "events": [],
    "chambers": ["c1"],
    "colours": ["#e58b55", "#6fb3c8"],
    "measured_kpa": [9.0],
    "markers": ["m1", "m2", "m3", "m4"],
    "rest_mm": REST,
    "position_mm": [[x, y, 12.0] for x, y, _ in REST],
    "step": {"kind": "settle"},
}


def _told(content: Any) -> Callable[[Any], None]:
    body = json.dumps(content)
    return lambda route: route.fulfill(body=body, content_type="application/json")


@pytest.fixture
def watched(asked: Any, browser: Any) -> Any:
    """Opens Watch on a run that stands as it is told."""
    page = browser.new_page(viewport={"width": 1280, "height": 1000}, reduced_motion="reduce")
    page.set_default_timeout(60_000)
    rig = asked.ask("/api/watch/rig")[1] | {"running": ["told"]}

    def opening(**state: Any) -> Any:
        answers = {"rig": rig, "now": STATE | state, "skin": SKIN, "models": {"models": []}}
        for name, content in answers.items():
            page.route(f"**/api/watch/{name}*", _told(content))
        page.goto(asked.address)
        page.evaluate("location.hash = '#/watch?live=told'")
        page.wait_for_selector(".live-run")
        return page

    yield opening
    page.close()


def test_the_two_errors_are_told_apart(watched: Callable[..., Any]) -> None:
    """That of the diagnosis says with what it is, and without; probabilities are in per cent, as everywhere."""
    page = watched(looks=[LOOK], diagnosed="model.yaml")
    words = "held-out error with dead time added 0.31 mm, without 1.4 mm; noise floor 0.12 mm"
    page.wait_for_selector(f"#look-errors:text-is('{words}')")
    assert "dead time 66 %" in page.inner_text("#live-verdict .legend")


def test_a_diagnosis_that_has_said_nothing_yet_is_told(watched: Callable[..., Any]) -> None:
    """From the beginning; without one there is no such card."""
    page = watched(diagnosed="model.yaml")
    page.wait_for_selector("#live-verdict:has-text('A diagnosis with model.yaml goes on')")
    assert page.is_hidden("#live-verdict canvas")
    assert watched(diagnosed="").is_hidden("#live-verdict")


def test_colours_that_are_no_errors_have_a_legend(watched: Callable[..., Any]) -> None:
    """Without a model they are how far the surface moved from rest."""
    page = watched()
    page.wait_for_selector("#moved:has-text('moved from rest: 0')")
    assert page.inner_text("#moved").endswith("12 mm")


HELD = """() => {
    const again = new KeyboardEvent("keydown", { key: "Enter", repeat: true, cancelable: true });
    return !document.querySelector("#end").dispatchEvent(again);
}"""
"""Whether a key that is held does nothing more."""
AT_ONCE = """() => new MutationObserver(() => {
    const button = document.querySelector("#resume");
    if (button && !button.dataset.tried) (button.dataset.tried = "yes"), button.click();
}).observe(document.body, { childList: true, subtree: true })"""
"""A press that comes as the button appears."""


@pytest.fixture
def presses(watched: Callable[..., Any]) -> Any:
    """A page on a run that pauses, goes on and ends as it is asked to, and what it was asked for."""
    page, asked = watched(), []
    state = STATE | {"paused": False}

    def told(route: Any) -> None:
        asked.append(route.request.url.rpartition("/")[2])
        state["paused"] = {"pause": True, "go_on": False}.get(asked[-1], state["paused"])
        route.fulfill(json={})

    for name in ("pause", "go_on", "end", "resume"):
        page.route(f"**/api/watch/{name}", told)
    page.route("**/api/watch/now*", lambda route: route.fulfill(json=state))
    return page, asked, state


def test_a_second_press_of_pause_fills_nothing(presses: Any) -> None:
    """However late it comes: Go on is a button of its own, in a place of its own, and nothing moves."""
    page, asked, _ = presses
    page.wait_for_selector("#go-on:disabled")
    place = page.locator("#pause").bounding_box()
    at = place["x"] + place["width"] / 2, place["y"] + place["height"] / 2
    page.mouse.dblclick(*at)
    page.wait_for_selector("#go-on:not(:disabled)")
    page.mouse.dblclick(*at)
    page.keyboard.press("Enter")
    assert page.locator("#pause").bounding_box() == place
    assert set(asked) == {"pause"}
    page.click("#go-on")
    page.wait_for_selector("#pause:not(:disabled)")
    assert asked[-1] == "go_on"


def test_only_a_press_of_its_own_ends_a_run(presses: Any) -> None:
    """The second half of a double click is none, nor is a key that is held; and what has ended is not filled by one."""
    page, asked, state = presses
    page.dblclick("#end")
    page.wait_for_selector("#end:has-text('Press again'):not([aria-disabled])")
    assert page.evaluate(HELD)
    assert asked == []
    page.evaluate(AT_ONCE)
    page.click("#end")
    state |= {"live": False, "state": "the workbench", "vented": True, "captures": 2, "missed": 0}
    page.wait_for_selector("#resume[data-tried]:not([aria-disabled])")
    assert asked == ["end"]
    page.click("#resume")
    page.wait_for_selector("#resume:disabled")
    assert asked[-1] == "resume"
