"""The seed of a campaign planned by clicks: the next run has other set-points, unless somebody wants the same."""

from collections.abc import Iterator
from typing import Any

import pytest

from labrig.log import read_run_yaml
from tests.waiting import wait_for


@pytest.fixture
def page(asked: Any, browser: Any) -> Iterator[Any]:
    """Watch as it was opened for the rig of a run that was measured with seed 0."""
    page = browser.new_page(viewport={"width": 1280, "height": 900}, reduced_motion="reduce")
    page.set_default_timeout(60_000)
    page.goto(asked.address)
    page.wait_for_selector("#campaign")
    yield page
    page.close()


def test_the_next_run_has_a_seed_of_its_own(asked: Any, page: Any) -> None:
    """The form has the smallest seed that no run of the procedure has; its plan, its command and the run have it."""
    assert asked.ask("/api/watch/seed?procedure=capture")[1] == {"seed": 1}
    assert asked.ask("/api/watch/seed?procedure=pairs")[1] == {"seed": 0}
    page.select_option("#procedure", "capture")
    wait_for(lambda: page.input_value("#seed") == "1", "another seed is proposed")
    page.fill("#arguments", "--captures 5")
    page.click("#show-plan")
    page.wait_for_selector("#plan-words")
    assert "--captures 5 --seed 1 --rig" in page.inner_text("#plan .command code")
    page.check("#fast")
    name = page.input_value("#out")
    page.click("#start")
    page.wait_for_selector("#measured")
    assert read_run_yaml(asked.folder / name)["seed"] == 1
    wait_for(lambda: page.input_value("#seed") == "2", "the seed is used already")
    page.evaluate("location.hash = '#/choose'")


def test_a_plan_of_another_seed_is_shown_before_it_starts(asked: Any, page: Any) -> None:
    """Who types another seed sees other set-points first; the same seed may be measured again."""
    page.select_option("#procedure", "capture")
    page.click("#show-plan")
    page.wait_for_selector("#plan-words")
    page.fill("#seed", "0")
    assert page.is_disabled("#start")
    page.click("#show-plan")
    page.wait_for_selector("#start:enabled")
    assert "--seed" not in page.inner_text("#plan .command code")


@pytest.mark.parametrize("seed", ["", "-1", "1.5", "nine", 2**53])
def test_what_is_no_seed_is_refused(asked: Any, seed: Any) -> None:
    """In words, before anything is planned."""
    status, content = asked.ask("/api/watch/plan", {"procedure": "capture", "seed": seed})
    assert status == 400
    assert content["error"].startswith(f"seed {seed or 'left empty'}: give a whole number")


def test_runs_of_a_file_count_by_its_procedure(asked: Any) -> None:
    """A list of parameters for capture is capture; one that cannot be read is told when its plan is shown."""
    (asked.folder / "mine.yaml").write_text("procedure: capture\ncaptures: 9\n", encoding="utf-8")
    (asked.folder / "torn.yaml").write_text("procedure: {\n", encoding="utf-8")
    assert asked.ask("/api/watch/seed?procedure=mine.yaml")[1] == {"seed": 1}
    assert asked.ask("/api/watch/seed?procedure=torn.yaml")[1] == {"seed": 0}


def test_what_cannot_be_planned_is_not_offered(asked: Any) -> None:
    """`validate` needs targets, which only its own command takes."""
    offered = asked.ask("/api/watch/rig")[1]["procedures"]
    assert "validate" not in offered
    assert {"capture", "pairs", "programme"} <= set(offered)
