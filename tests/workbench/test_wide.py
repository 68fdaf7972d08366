"""What fits a window of 1280 pixels, which every page of the tests has."""

import pytest

pytestmark = pytest.mark.usefixtures("browser")

LONG = "models/the-arm-with-the-new-silicone-and-its-payload"
OUTSIDE = """() => [...document.querySelectorAll("main table, main .command code")].filter((each) => {
    const room = each.closest(".card, .command").getBoundingClientRect();
    return each.scrollWidth > each.clientWidth + 1 || each.getBoundingClientRect().right > room.right + 1;
}).map((each) => each.textContent)"""


def test_no_table_and_no_command_is_cut_where_names_are_long(open_page, make_run, bench):
    """Two models with long names are compared: the table of where they differ, and the command, lie within their card;
    the table says in which unit they differ.
    """
    run = make_run("a-run-of-the-long-night-of-measurements", captures=12, rows=2)
    (bench.desk.folder / "models").mkdir()
    for kind, degree in (("straight", 1), ("bent", 2)):
        path = bench.desk.folder / f"{LONG}-{kind}-and-a-second-payload.yaml"
        path.write_text(f"base: {{kind: static, degree: {degree}}}\n", encoding="utf-8")
    page = open_page()
    first, second = (f"{LONG}-{kind}-and-a-second-payload.yaml" for kind in ("straight", "bent"))
    page.evaluate("hash => location.hash = hash", f"#/run/{run}/watch?a={first}&b={second}")
    page.click("#compare-two")
    page.wait_for_selector("table.differ")
    heads = page.locator("table.differ th").all_inner_texts()
    assert [head.rpartition(", ")[2] for head in heads[2:5]] == ["mm", "mm", "mm"]
    assert page.evaluate(OUTSIDE) == []


def test_the_way_of_the_error_has_units(open_page, make_run, ask, bench):
    """In Add, what each effect takes off the error is said in the unit of the error."""
    run = make_run(captures=14, rows=2)
    ask("/api/which", {"run": run, "model": "model.yaml"})
    bench.desk.jobs.wait(120)
    page = open_page()
    page.evaluate("hash => location.hash = hash", f"#/run/{run}/add?effects=creep")
    page.wait_for_selector("[data-refined=true]")
    assert page.inner_text(".waterfall .added .fell").endswith(" mm")
