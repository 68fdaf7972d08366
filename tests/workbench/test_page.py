"""The workbench in a real browser: from a dropped table to a lower error, and what may go wrong on the way."""

import json

import pytest

from labrig._yaml import read_yaml
from labrig.catalogue import read_notes

pytestmark = pytest.mark.usefixtures("browser")

SAVES = """() => {
    document.querySelector("[data-save]").click();
    return document.querySelector("[aria-label='name of the new model']").disabled;
}"""


@pytest.fixture
def drop(tmp_path, table, table_mapping):
    """Drops a table on a page, says what its columns mean, and makes a run of it."""

    def dropping(page, name, seed, **settings):
        page.goto(page.url.split("#")[0] + "#/choose")
        page.set_input_files("input[type=file]", table(tmp_path / f"{name}.csv", seed, **settings))
        page.click("details.mapping summary")
        page.fill("textarea", table_mapping)
        page.click("[data-import]")
        _at(page, f"#/run/{name}/compare")

    return dropping


def _at(page, part):
    """Wait until a part of the address is this; the page's own policy forbids conditions as texts."""
    for _ in range(800):
        if part in page.url:
            return
        page.wait_for_timeout(50)
    raise AssertionError(page.url)


def _error(page):
    """The error of the run that is compared, as the page shows it."""
    page.wait_for_selector("[data-drawn]")
    return float(page.inner_text(".figure.error b").split()[0])


@pytest.mark.slow
def test_the_whole_way_by_clicks(open_page, bench, drop, make_run):
    """From a dropped table over compare, where, which and add to a lower error on a run that was not fitted."""
    folder = bench.desk.folder
    page = open_page()
    drop(page, "first", 0, captures=24, rows=3)
    page.click("[data-base=straight]")
    before = _error(page)
    page.click("text=Where does it fail?")
    page.wait_for_selector(".panels .chart .main-svg")
    page.click("text=Which effect is it?")
    page.click("[data-start=diagnose]")
    page.wait_for_selector(".effect.sure")
    assert page.inner_text(".effect.sure b") == "creep"
    found = json.loads((folder / "first" / "first-model" / "diagnosis.json").read_text())
    assert found["effects"] == ["creep"]
    page.click("text=Add it and watch the error fall")
    page.wait_for_selector("[data-refined=true]")
    assert "+  value: " in page.inner_text(".diff") or "creep" in page.inner_text(".diff")
    assert page.evaluate(SAVES)  # what is typed while it saves is no name of what is saved
    page.wait_for_selector("[data-saved]")
    model = read_yaml(folder / "first-model.improved.yaml", "model")
    assert [entry["name"] for entry in model["effects"]] == ["creep"]
    assert before > 0.1
    make_run("fresh", seed=7, captures=24, rows=3)
    errors = {}
    for name in ("first-model.yaml", "first-model.improved.yaml"):
        page.evaluate("hash => location.hash = hash", f"#/run/fresh/compare?model={name}")
        page.wait_for_selector(f"#about option[value='{name}'][selected]", state="attached")
        page.wait_for_selector(".figures")
        errors[name] = _error(page)
    assert errors["first-model.improved.yaml"] < 0.8 * errors["first-model.yaml"]


def test_a_wrong_token_shows_no_page(browser, bench):
    """Who has a wrong token sees one line that says so, and nothing of the folder."""
    page = browser.new_page()
    page.goto(f"http://127.0.0.1:{bench.port}/?token=wrong")
    assert "token" in page.inner_text("body")
    assert str(bench.desk.folder) not in page.content()
    page.close()


def test_another_site_in_the_same_browser_gets_nothing(open_page, bench, make_run):
    """A page of another origin in the browser that has the cookie can read and change nothing."""
    run = make_run(captures=10)
    page = open_page()
    other = page.context.new_page()
    other.goto("data:text/html,<p>elsewhere</p>")
    asked = """async ([address, run]) => {
        const of = (options) => fetch(address + (options ? "tag" : "runs"), options).then((a) => a.status, () => "no");
        const body = JSON.stringify({run, tags: ["x"]});
        return [await of(), await of({method: "POST", mode: "no-cors", credentials: "include", body})];
    }"""
    assert other.evaluate(asked, [f"http://127.0.0.1:{bench.port}/api/", run])[0] == "no"
    assert not (bench.desk.folder / run / "notes.yaml").exists()


def test_runs_are_searched_and_tagged(open_page, make_run, bench):
    """Runs are found by words of their names and tags, and tags are put on and taken off."""
    for name in ("monday", "tuesday"):
        make_run(name, captures=10)
    page = open_page()
    page.reload()
    page.click("[aria-label='tag monday']")
    page.keyboard.type("good")
    page.keyboard.press("Enter")
    page.wait_for_selector("[data-run=monday] .tag")
    page.fill("input[type=search]", "good")
    page.wait_for_selector("[data-run=tuesday]", state="detached")
    page.click("[data-run=monday] .tag")
    page.wait_for_selector("text=0 of 2 runs")
    assert "good" not in (bench.desk.folder / "monday" / "notes.yaml").read_text()


def test_a_note_is_written_and_found(open_page, make_run, bench, ask):
    """A note that is typed stands with its run and is searched; Escape writes none; one without words is refused."""
    run = make_run(captures=10)
    page = open_page()
    page.click(f"[aria-label='note on {run}']")
    page.keyboard.type("never mind")
    page.keyboard.press("Escape")
    page.click(f"[aria-label='note on {run}']")
    page.keyboard.type("chamber 3 <hisses>")
    page.keyboard.press("Enter")
    page.wait_for_selector(f"[data-run={run}] .note >> text=chamber 3 <hisses>")
    page.fill("input[type=search]", "hisses")
    page.wait_for_selector("text=1 run")
    assert read_notes(bench.desk.folder / run).notes == ["chamber 3 <hisses>"]
    status, said = ask("/api/note", {"run": run, "text": " "})
    assert (status, said["error"].split(";")[0]) == (400, "the note is empty")
