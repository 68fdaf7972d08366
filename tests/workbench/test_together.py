"""Runs that are diagnosed together from a page, and what somebody says could not act in one of them."""

import json

import pytest

from labrig.catalogue import read_notes

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


def test_runs_are_diagnosed_together(two, bench, ask):
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
    two.wait_for_selector("details.together input[value=second]:not(:checked)")
    asked = "/api/which?run=first&model=model.yaml"
    for _ in range(600):
        if ask(asked)[1]["diagnosed"] and not ask(asked)[1]["others"][0]["with"]:
            break
        two.wait_for_timeout(100)
    found = json.loads((bench.desk.folder / "first" / "model" / "diagnosis.json").read_text())
    assert [run["run"] for run in found["runs"]] == ["first"]


def test_what_could_not_act_is_said_of_a_run(two, bench, ask):
    """It is typed beside the run, kept in its notes, shown wherever the run is offered, and taken back by a click."""
    two.evaluate("location.hash = '#/choose'")
    two.click("[aria-label='rule out in second']")
    two.keyboard.type("marker slip")
    two.keyboard.press("Enter")
    two.wait_for_selector("[data-run=second] .tag >> text=without marker_slip")
    assert read_notes(bench.desk.folder / "second").ruled_out == {"marker_slip": []}
    (other,) = ask("/api/which?run=first&model=model.yaml")[1]["others"]
    assert (other["run"], other["ruled_out"]) == ("second", "marker_slip")
    two.click("[data-run=second] .tag")
    two.wait_for_selector("[data-run=second] .tag", state="detached")
    assert read_notes(bench.desk.folder / "second").ruled_out == {}
    status, said = ask("/api/rule-out", {"run": "second", "effect": "contacts"})
    assert (status, said["error"]) == (400, "there is no effect 'contacts'; did you mean contact?")


def test_a_result_is_out_of_date_once_something_else_is_ruled_out(runs, bench, ask):
    """A diagnosis of runs in which nothing was ruled out is none of them as they are now."""
    ask("/api/which", {"run": "first", "model": "model.yaml", "with": ["second"]})
    bench.desk.jobs.wait(120)
    asked = "/api/which?run=first&model=model.yaml"
    assert ask(asked)[1]["diagnosed"]
    ask("/api/rule-out", {"run": "second", "effect": "contact"})
    assert not ask(asked)[1]["diagnosed"]
    ask("/api/rule-out", {"run": "second", "effect": "contact", "remove": True})
    assert ask(asked)[1]["diagnosed"]


def test_a_run_can_be_seen_though_the_notes_of_another_are_damaged(runs, bench, ask):
    """A result of several runs counts for none where nobody can tell what is ruled out in one; the others are shown."""
    ask("/api/which", {"run": "first", "model": "model.yaml", "with": ["second"]})
    bench.desk.jobs.wait(120)
    (bench.desk.folder / "second" / "notes.yaml").write_text("tags: good\n", encoding="utf-8")
    status, said = ask("/api/which?run=first&model=model.yaml")
    assert (status, said["diagnosed"]) == (200, False)
