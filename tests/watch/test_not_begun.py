"""A run that cannot begin, as its device is off: the page says so, and why, and leads back to the plan."""

from collections.abc import Iterator
from pathlib import Path
from typing import Any

import pytest

from tests.waiting import wait_for
from tests.watch.conftest import Bench

OFF = """
name: dead
chambers: [{name: c1, max_kpa: 60}]
pressure: {kind: openpneu, port: "socket://127.0.0.1:1"}
"""
WHY = "refuses the connection"


@pytest.fixture
def off(tmp_path: Path) -> Iterator[Bench]:
    """A workbench in this process, for a rig whose pressure controller nobody has switched on."""
    from labrig.workbench import open_desk, start

    (tmp_path / "rig.yaml").write_text(OFF, encoding="utf-8")
    running = start(open_desk(tmp_path, tmp_path / "rig.yaml"))
    yield Bench.of(running)
    assert running.desk.jobs.wait(60)
    running.stop()


def test_how_it_stands_says_why(off: Bench) -> None:
    """There is no log to read: the command's own last words are what is known."""
    run = off.start("first", "--captures", 4)
    state = wait_for(lambda: (found := off.now(run)).get("live") is False and found, "it says nothing")
    assert (state["state"], WHY in state["why"]) == ("not begun", True)
    assert off.ask("/api/watch/now?run=another")[0] == 400


def test_the_page_says_why(off: Bench, browser: Any) -> None:
    """Beside Start, or in place of the run where that answered before it knew; also where it has ended already when
    the page looks for it.
    """
    context = browser.new_context(reduced_motion="reduce")
    context.set_default_timeout(60_000)
    page = context.new_page()
    page.goto(off.address)
    page.click("#show-plan")
    run = page.input_value("#out")
    page.click("#start:not([disabled])")
    page.wait_for_selector(f"#not-begun .wrong:has-text('{WHY}'), #start-wrong:has-text('{WHY}')")
    page.evaluate("location.hash = '#/choose'")
    page.wait_for_selector("table.runs, .dropzone")
    page.evaluate("run => location.hash = `#/watch?live=${run}`", run)
    page.wait_for_selector(f"#not-begun .wrong:has-text('{WHY}')")
    context.close()
