"""What Watch shows stays there, and is seen whole."""

from typing import Any

import pytest

CAMERA = """rest_mm => import('/page/live_surface.js').then(({ Surface }) => {
    const { eye } = new Surface(null, 'run').camera({ rest_mm });
    return Math.hypot(eye.x, eye.y, eye.z);
})"""

ENDED = """title => {
    const job = { title, state: "done", run: "" };
    document.dispatchEvent(new CustomEvent("job-ended", { detail: job }));
}"""


@pytest.fixture
def page(asked: Any, browser: Any) -> Any:
    """The page of a workbench of a run and two models."""
    page = browser.new_page(viewport={"width": 1280, "height": 900}, reduced_motion="reduce")
    page.set_default_timeout(60_000)
    page.goto(asked.address)
    yield page
    page.close()


def test_a_plan_that_was_shown_is_shown_again(page: Any) -> None:
    """It has an address: when the page is made anew, as in other colours, it is there."""
    page.evaluate("location.hash = '#/run/runs/run/watch'")
    page.click("#show-plan")
    page.wait_for_selector("#plan-words")
    page.click("#theme")
    page.wait_for_selector("#plan-words", state="detached")
    page.wait_for_selector("#plan-words")


def test_a_job_that_ends_takes_no_name_and_no_tick_away(page: Any) -> None:
    """What was typed for an investigation, or beside a plan, stays; what a job has found is shown meanwhile."""
    page.evaluate("location.hash = '#/run/runs/run/watch'")
    page.fill("#investigation-out", "mine")
    page.check("#mine")
    with page.expect_response("**/api/next*"):
        page.evaluate(ENDED, "a")
    page.wait_for_selector("#said:has-text('a: done')")
    assert page.input_value("#investigation-out") == "mine"
    assert page.is_checked("#mine")
    page.reload()
    page.click("#show-plan")
    page.fill("#out", "runs/my name")
    page.check("#fast")
    with page.expect_response("**/api/next*"):
        page.evaluate(ENDED, "b")
    page.wait_for_selector("#said:has-text('b: done')")
    assert page.input_value("#out") == "runs/my name"
    assert page.is_checked("#fast")


def test_a_flat_surface_is_looked_at_from_further_off(page: Any) -> None:
    """Plotly draws by the mean of three extents: a flat thing would be larger than the picture that shows it live."""
    cube = [[x, y, z] for x in (0, 90) for y in (0, 90) for z in (0, 90)]
    sheet = [[x, y, 0.0] for x, y, _ in cube]
    near, far = (page.evaluate(CAMERA, points) for points in (cube, sheet))
    assert far == pytest.approx(near * (1 / 0.04 ** (1 / 3)) / 1.7)


def test_a_probability_is_the_same_in_a_card_and_in_a_sentence(page: Any) -> None:
    """Rounded down in both, and never certain."""
    from labrig._text import chance

    given = [0.004, 0.0149, 0.749, 0.9189, 0.9949, 0.9951]
    percent = "given => import('/page/dom.js').then(({ percent }) => given.map(percent))"
    assert page.evaluate(percent, given) == [chance(value) for value in given]
