"""The list of runs in a real browser: what somebody is in the middle of stays, and every name has room."""

from typing import Any

import pytest

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
