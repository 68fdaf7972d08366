"""The list of runs in a real browser: what somebody is in the middle of stays, and every name has room."""

from typing import Any

import pytest

from labrig._yaml import read_yaml

pytestmark = pytest.mark.usefixtures("browser")


@pytest.fixture(scope="module")
def bench(shared_bench: Any) -> Any:
    """The one that the tests of this file share."""
    return shared_bench


def _list_of(page: Any) -> Any:
    page.wait_for_selector("table.runs")
    return page


def test_a_note_that_is_being_typed_outlives_the_end_of_a_job(
    open_page: Any, make_run: Any, bench: Any
) -> None:
    """Work that ends meanwhile does not make the list anew under whoever writes in it."""
    make_run("noted")
    page = _list_of(open_page())
    page.click("[aria-label='note on noted']")
    page.keyboard.type("chamber 3 le")
    bench.desk.jobs.start(["--version"], "something else")
    page.wait_for_selector("#said:has-text('something else: done')")
    page.keyboard.type("aks")
    assert page.input_value("[aria-label='new note']") == "chamber 3 leaks"
    page.keyboard.press("Enter")
    page.wait_for_selector("[data-run=noted] .note:has-text('chamber 3 leaks')")


def test_light_or_dark_takes_no_dropped_table_away(
    open_page: Any, make_run: Any, table: Any, tmp_path: Any
) -> None:
    """What was chosen for a table's columns, and its name, stay while the colours change."""
    make_run("there")
    page = _list_of(open_page())
    page.set_input_files("input[type=file]", table(tmp_path / "dropped.csv", 0))
    page.wait_for_selector("[data-import]")
    page.fill("[aria-label='name of the run']", "mine")
    before = page.get_attribute("html", "data-theme")
    page.click("#theme")
    page.wait_for_timeout(500)
    assert page.get_attribute("html", "data-theme") != before
    assert page.input_value("[aria-label='name of the run']") == "mine"


def test_a_long_name_pushes_no_column_out_of_the_window(open_page: Any, make_run: Any) -> None:
    """A name without a space is broken where it has to be."""
    make_run("n" * 180)
    page = _list_of(open_page())
    assert page.evaluate("document.documentElement.scrollWidth <= innerWidth")


def test_a_note_is_written_once(open_page: Any, make_run: Any, bench: Any) -> None:
    """However often Enter is pressed, or held; the Enter that chooses a word in another script writes none."""
    folder = bench.desk.folder / make_run("once")
    page = _list_of(open_page())
    page.click("[aria-label='note on once']")
    page.keyboard.type("leaks")
    page.dispatch_event("[aria-label='new note']", "keydown", {"key": "Enter", "isComposing": True})
    page.keyboard.type(" again")
    for _ in range(3):
        page.keyboard.down("Enter")
    page.wait_for_selector("[data-run=once] .note:has-text('leaks again')")
    assert len(read_yaml(folder / "notes.yaml", "notes")["notes"]) == 1


TWO = """async () => {
    const given = new DataTransfer();
    const table = "t [s],p [kPa],x [mm]\\n0,1,2\\n1,2,3\\n2,1,2";
    for (const name of ["one.csv", "two.csv"]) given.items.add(new File([table], name));
    dispatchEvent(new DragEvent("drop", { dataTransfer: given, bubbles: true, cancelable: true }));
}"""


def test_of_several_files_the_others_are_named(open_page: Any, make_run: Any, bench: Any) -> None:
    """One is taken at a time, and those that are not are said; a table that is put away is kept no longer."""
    make_run("several")
    page = _list_of(open_page())
    page.evaluate(TWO)
    page.wait_for_selector(
        "#said:has-text('only one.csv was taken: one file at a time; drop two.csv after it')"
    )
    page.wait_for_selector("h2:has-text('one.csv')")
    assert list(bench.desk.folder.glob(".workbench/dropped/*/one.csv"))
    page.click("text=put it away")
    page.wait_for_selector("h2:has-text('one.csv')", state="detached")
    assert not list(bench.desk.folder.glob(".workbench/dropped/*/one.csv"))


DURATIONS = """async () => {
    const { duration } = await import("/page/dom.js");
    return [59.6, 5399, 7170, 7190, 36000].map(duration);
}"""


def test_what_is_typed_into_the_address_leads_somewhere(open_page: Any, make_run: Any) -> None:
    """Signs that no address has are part of a name; steps open by their key, whatever sign it makes with Alt."""
    make_run("50%")
    page = _list_of(open_page())
    page.evaluate("location.hash = '#/run/50%/compare'")
    page.wait_for_selector("#about .run:text-is('50%')")
    assert page.locator("#steps a").count() > 3
    page.dispatch_event("body", "keydown", {"key": "¡", "code": "Digit1", "altKey": True})
    _list_of(page)
    assert page.inner_text("h1") == "Runs"
    assert page.evaluate(DURATIONS) == ["60 s", "1 h 30 min", "2 h 0 min", "2 h 0 min", "10 h 0 min"]
