"""Before and after in a real browser: two models on one run, side by side."""

from typing import Any

import pytest

from tests.waiting import wait_for

CAMERA = "e => e.layout.scene.camera.eye"
TURN = "e => window.Plotly.relayout(e, {'scene.camera': {...e.layout.scene.camera, eye: {x: 0.4, y: -2, z: 1.1}}})"
ERRORS = "e => e.data[0].marker.color"


@pytest.mark.slow
def test_before_and_after_are_turned_together(asked: Any, browser: Any) -> None:
    """Two surfaces in one scale of colours; who turns one turns both; a capture is shown by both, at an address."""
    page = browser.new_page(viewport={"width": 1280, "height": 900}, reduced_motion="reduce")
    page.set_default_timeout(180_000)
    wrong: list[str] = []
    page.on("pageerror", lambda error: wrong.append(str(error)))
    page.goto(asked.address)
    page.evaluate(
        "hash => location.hash = hash", "#/run/runs/run/watch?a=worse.yaml&b=better.yaml&model=worse.yaml"
    )
    page.click("#compare-two")
    page.wait_for_selector("#versus [data-drawn='-1']")
    surfaces = page.locator("#versus .surface")
    assert surfaces.count() == 2
    before, after = (surfaces.nth(k) for k in (0, 1))
    assert page.inner_text("#versus figure:first-child h3").startswith("worse: 9")
    assert min(before.evaluate(ERRORS)) > max(after.evaluate(ERRORS))
    before.evaluate(TURN)
    wait_for(lambda: after.evaluate(CAMERA) == {"x": 0.4, "y": -2, "z": 1.1}, "the other one is not turned")
    page.click("#versus [aria-label='next capture']")
    page.wait_for_selector("#versus [data-drawn]:not([data-drawn='-1'])")
    assert "capture=" in page.url
    page.close()
    assert wrong == []


def test_a_model_that_cannot_be_read_is_not_offered(asked: Any, browser: Any) -> None:
    """Neither before nor after: the page says which file it is, and what is wrong with it, also where no other is."""
    (asked.folder / "a.yaml").write_text("base: {kind: static, degree: 1\neffects: []\n", encoding="utf-8")
    page = browser.new_page(viewport={"width": 1280, "height": 900}, reduced_motion="reduce")
    page.set_default_timeout(180_000)
    page.goto(asked.address)
    page.evaluate("hash => location.hash = hash", "#/run/runs/run/watch?a=a.yaml")
    page.wait_for_selector("#compare-two")
    for which in ("#a", "#b"):
        assert page.locator(f"{which} option").all_inner_texts() == ["worse.yaml", "better.yaml"]
    assert "Not offered: a.yaml, line 2: is not YAML" in page.inner_text("#versus")
    assert page.locator("#about option[disabled]").inner_text() == "a.yaml (cannot be read)"
    for name in ("worse", "better"):
        (asked.folder / f"{name}.py").unlink()
    page.evaluate("location.hash = '#/run/runs/run/compare'")
    page.wait_for_selector("[data-base=straight]")
    assert "Not offered: better.yaml names better.py, which is not there." in page.inner_text("#main")
    page.close()
