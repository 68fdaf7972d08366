"""Runs that are diagnosed together from a page, and what somebody says could not act in one of them."""

import json

import pytest

from labrig.catalogue import read_notes
from tests.waiting import wait_for

pytestmark = pytest.mark.usefixtures("browser")


@pytest.fixture
def runs(make_run):
    """A run beside which another lies of the same rig."""
    make_run("first", captures=14, rows=2)
    make_run("second", seed=7, captures=12, rows=2)


@pytest.fixture
def two(runs, open_page):
    """The page of the first."""
    page = open_page()
    page.evaluate("location.hash = '#/run/first/which?model=model.yaml'")
    page.wait_for_selector("details.together")
    return page


def test_runs_are_diagnosed_together(two, bench):
    """Other runs with the same chambers and observables can be chosen; the page says of which the result is, and what
    is to be kept in mind, such as what is gone where it was ruled out.
    """
    two.click("details.together summary")
    button = two.locator("[data-start=together]")
    assert button.is_disabled()
    two.check("details.together input[value=second]")
    assert "labrig diagnose first second --model model.yaml --out first/model" in two.inner_text(
        "main .command"
    )
    button.click()
    two.wait_for_selector(".effect")
    found = json.loads((bench.desk.folder / "first" / "model" / "diagnosis.json").read_text())
    assert [run["run"] for run in found["runs"]] == ["first", "second"]
    assert found["warnings"]
    assert all(words in two.inner_text("main") for words in found["warnings"])
    assert two.is_checked("details.together input[value=second]")
    assert "labrig diagnose first second --model model.yaml" in two.inner_text("main .command")
    two.uncheck("details.together input[value=second]")
    button.click()
    alone = wait_for(lambda: next((j for j in bench.desk.jobs.all() if j.state == "running"), None))
    assert "labrig diagnose first --model model.yaml --out first/model" in alone.command
    pid = alone.folder / "pid"
    wait_for(lambda: pid.is_file() and pid.read_text())
    bench.desk.jobs.cancel(alone)


def test_what_could_not_act_is_said_of_a_run(two, bench, ask):
    """It is typed beside the run, kept in its notes, shown wherever the run is offered, and taken back by a click."""
    two.evaluate("location.hash = '#/choose'")
    two.click("[aria-label='rule out in second']")
    two.wait_for_selector("#effects option[value=creep]", state="attached")
    two.keyboard.type("Marker Slip")
    two.keyboard.press("Enter")
    two.wait_for_selector("[data-run=second] .tag >> text=without marker_slip")
    assert read_notes(bench.desk.folder / "second").ruled_out == {"marker_slip": []}
    (other,) = ask("/api/which?run=first&model=model.yaml")[1]["others"]
    assert (other["run"], other["ruled_out"]) == ("second", "marker_slip")
    two.click("[data-run=second] .tag")
    two.wait_for_selector("[data-run=second] .tag", state="detached")
    assert read_notes(bench.desk.folder / "second").ruled_out == {}
    status, said = ask("/api/rule-out", {"run": "second", "effect": "contacts"})
    assert status == 400
    assert said["error"].startswith("there is no effect 'contacts'; did you mean contact?; there are ")
    assert "contact, " in said["error"]
    assert ask("/api/rule-out", {"run": "second", "effect": ""})[1]["error"].startswith("name an effect; ")


@pytest.fixture
def diagnosed(runs, bench, ask):
    """Both runs, diagnosed together; the answer to what that result is of."""
    ask("/api/which", {"run": "first", "model": "model.yaml", "with": ["second"]})
    bench.desk.jobs.wait(120)
    return lambda: ask("/api/which?run=first&model=model.yaml")


def test_a_result_of_several_runs_is_one_of_them_as_they_are_now(diagnosed, bench, ask):
    """Once something else is ruled out in one it is out of date; where nobody can tell what is, as its notes are
    damaged, it counts for none either, and the page of the others is shown all the same.
    """
    assert diagnosed()[1]["diagnosed"]
    ask("/api/rule-out", {"run": "second", "effect": "contact"})
    assert not diagnosed()[1]["diagnosed"]
    ask("/api/rule-out", {"run": "second", "effect": "contact", "remove": True})
    assert diagnosed()[1]["diagnosed"]
    (bench.desk.folder / "second" / "notes.yaml").write_text("tags: good\n", encoding="utf-8")
    status, said = diagnosed()
    assert (status, said["diagnosed"]) == (200, False)
