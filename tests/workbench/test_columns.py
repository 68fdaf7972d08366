"""What the columns of a dropped table mean, chosen one by one."""

from typing import Any

import pytest
import yaml

from labrig._errors import LabrigError
from labrig.log import read_run_yaml
from labrig.workbench._columns import changed, fault_of, mapping_of, meanings
from tests.workbench.test_page import _at

HEADER = ["t [min]", "valve", "gauge", "tip x", "tip y", "room", "day"]
MAPPING: dict[str, Any] = {
    "table": "arm.csv",
    "time": {"column": "t [min]", "unit": "min"},
    "capture": {"per": "segment"},
    "actuation": [{"column": "gauge", "name": "p1", "unit": "kPa", "scale": 2.0, "min": 0.0, "max": 80.0}],
    "observables": [{"column": "tip x", "name": "x", "unit": "mm"}],
    "covariates": [{"name": "payload", "unit": "g"}],
}


def chosen(**other: dict[str, str]) -> list[Any]:
    """What the page shows of this mapping, with other choices for some columns."""
    return [m | other.get(str(m["column"]).replace(" ", "_"), {}) for m in meanings(MAPPING, HEADER)]


def test_each_column_is_shown_as_the_mapping_has_it():
    """A clock with its unit, an input with its limits, a measurement; what is not there is not used."""
    shown = {m.pop("column"): m for m in meanings(MAPPING, HEADER)}
    assert shown["t [min]"] == {"part": "time", "unit": "min"}
    assert shown["gauge"] == {"part": "actuation", "name": "p1", "unit": "kPa", "min": "0.0", "max": "80.0"}
    assert shown["tip x"] == {"part": "observables", "name": "x", "unit": "mm"}
    assert shown["room"] == {"part": ""}


def test_nothing_chosen_changes_nothing():
    """What the page shows, put back, is the same mapping."""
    assert changed(MAPPING, chosen()) == MAPPING


def test_columns_change_places():
    """The valve is the input and the gauge its sensor; a marker's coordinates, a temperature and days are said."""
    out = changed(
        MAPPING,
        chosen(
            valve={"part": "actuation", "name": "p1", "unit": "kPa", "min": "0", "max": "70,5"},
            gauge={"part": "measured", "name": "p1", "unit": "kPa"},
            tip_x={"part": "observables", "name": "x", "unit": "mm", "marker": "tip", "axis": "x"},
            tip_y={"part": "observables", "unit": "mm", "marker": "tip", "axis": "y"},
            room={"part": "covariates", "name": "temperature", "unit": "degC"},
            day={"part": "session"},
        ),
    )
    assert out["actuation"] == [{"column": "valve", "name": "p1", "unit": "kPa", "min": 0.0, "max": 70.5}]
    assert out["measured"] == [{"column": "gauge", "name": "p1", "unit": "kPa"}]
    assert [(o["name"], o["marker"], o["axis"]) for o in out["observables"]] == [
        ("x", "tip", "x"),
        ("tip.y", "tip", "y"),
    ]
    assert out["covariates"] == [
        {"name": "payload", "unit": "g"},
        {"column": "room", "name": "temperature", "unit": "degC"},
    ]
    assert out["session"] == {"column": "day"}
    assert (out["table"], out["capture"], fault_of(out)) == ("arm.csv", {"per": "segment"}, "")


def test_what_else_is_said_of_a_column_stays():
    """A scale that only the text can say is there after a unit was typed."""
    out = changed(MAPPING, chosen(gauge={"part": "actuation", "name": "p1", "unit": "bar"}))
    assert out["actuation"][0]["scale"] == 2.0
    assert out["actuation"][0]["unit"] == "bar"


def test_there_is_one_clock():
    """Of two columns that are the time, the one that was chosen last is."""
    out = changed(MAPPING, chosen(day={"part": "time", "unit": "s"}))
    assert out["time"] == {"column": "day", "unit": "s"}
    assert [m["part"] for m in meanings(out, ["t [min]", "day"])] == ["", "time"]


def test_time_since_the_set_point_takes_the_place_of_a_settling_time():
    """Both say the same, and a mapping may say it once."""
    out = changed(MAPPING | {"settle_s": 3}, chosen(day={"part": "hold", "unit": "s"}))
    assert "settle_s" not in out
    assert out["hold"] == {"column": "day", "unit": "s"}


def test_a_new_place_is_called_as_its_column_is():
    """Without its unit, which is the entry's."""
    out = changed(
        {}, [{"column": "force left [N]", "part": "observables"}, {"column": "t [min]", "part": "time"}]
    )
    assert out["observables"] == [{"column": "force left [N]", "name": "force left", "unit": "N"}]
    assert out["time"] == {"column": "t [min]", "unit": "min"}


def test_columns_without_names_are_counted():
    """A table without a header has its columns by number."""
    mapping = {
        "actuation": [{"column": 0, "name": "p", "unit": "kPa"}],
        "observables": [{"column": 1, "name": "x", "unit": "mm"}],
    }
    assert [m["column"] for m in meanings(mapping, ["a", "b", "c"])] == [0, 1, 2]
    assert changed(mapping, meanings(mapping, ["a", "b", "c"])) == mapping


@pytest.mark.parametrize(
    ("other", "said"),
    [
        ({"gauge": {"part": ""}}, "the mapping: actuation: name at least one commanded value"),
        ({"tip_x": {"part": ""}}, "the mapping: say which columns were measured"),
        (
            {"gauge": {"part": "measured", "name": "p2", "unit": "kPa"}},
            "the mapping: actuation: name at least",
        ),
    ],
)
def test_what_a_run_still_lacks_is_said(other, said):
    """A choice may leave a mapping incomplete, which is kept, with what is wrong."""
    assert fault_of(changed(MAPPING, chosen(**other))).startswith(said)


@pytest.mark.parametrize(
    "typed", [3, "p1", {"column": "valve"}, [3], [["valve"]], [{"column": ["a", "b"]}], [None]]
)
@pytest.mark.parametrize("part", ["time", "actuation", "observables"])
def test_what_is_half_typed_is_told_and_the_page_goes_on(part: str, typed: Any):
    """A part that is not what it is to be, yet, has no columns; a column can be chosen into it all the same."""
    mapping = {**MAPPING, part: typed}
    shown = meanings(mapping, HEADER)
    assert [m["column"] for m in shown] == HEADER
    if part != "time" or typed != {"column": "valve"}:
        assert not any(m["part"] == part for m in shown)
        assert fault_of(mapping).startswith("the mapping: ")
    valve = next(m for m in shown if m["column"] == "valve")
    again = meanings(changed(mapping, [{**valve, "part": part}]), HEADER)
    assert [m["column"] for m in again if m["part"] == part] == ["valve"]


def test_a_limit_that_is_no_number_is_refused():
    """By its column and what was typed."""
    with pytest.raises(LabrigError, match=r"^gauge: most \(max\): 'high' is no number$"):
        changed(MAPPING, chosen(gauge={"part": "actuation", "max": "high"}))


@pytest.mark.parametrize("typed", ["1e400", "-inf", "nan"])
def test_a_limit_without_end_is_refused(typed: str):
    """As the form of a rig does: no chamber holds an infinite pressure, and what is not limited is left empty."""
    with pytest.raises(LabrigError, match=r"^gauge: least \(min\): '.+' is not finite; leave it empty"):
        changed(MAPPING, chosen(gauge={"part": "actuation", "min": typed}))


@pytest.mark.parametrize(
    ("text", "said"),
    [
        ("a: [", "the mapping, line 1: this is no YAML; undo what was changed last"),
        ("- a", "the mapping: there are no 'actuation:' and 'observables:' in it"),
    ],
)
def test_text_that_is_no_mapping(text, said):
    """In one line, with its own line."""
    with pytest.raises(LabrigError) as error:
        mapping_of(text)
    assert str(error.value) == said


def test_the_page_asks_with_text_and_choices(ask):
    """Text alone says what its columns mean; with choices it comes back changed."""
    text = yaml.safe_dump(MAPPING)
    status, said = ask("/api/columns", {"mapping": text, "header": HEADER})
    assert (status, said["mapping"], said["fault"]) == (200, text, "")
    assert said["columns"][2]["part"] == "actuation"
    said = ask("/api/columns", {"mapping": text, "header": HEADER, "chosen": chosen(tip_x={"part": ""})})[1]
    assert "observables" not in yaml.safe_load(said["mapping"])
    assert said["fault"] == "the mapping: say which columns were measured"


@pytest.mark.usefixtures("browser")
def test_columns_are_chosen_by_clicks(open_page, bench, tmp_path):
    """A run comes from lists alone; while something is missing, what it is stands there and no run can be made."""
    rows = "".join(
        f"{5 * i},{10 * (i % 4)},{0.3 * (i % 4) + 0.01 * i:.2f},{21 + 0.1 * i:.1f}\n" for i in range(24)
    )
    (tmp_path / "odd.csv").write_text("a,b [kPa],c [mm],d\n" + rows)
    page = open_page()
    page.goto(page.url.split("#")[0] + "#/choose")
    page.set_input_files("input[type=file]", tmp_path / "odd.csv")
    page.select_option("[aria-label='what c [mm] is']", "")
    page.select_option("[aria-label='what d is']", "covariates")
    page.wait_for_selector("text=say which columns were measured")
    assert page.is_disabled("[data-import]")
    page.select_option("[aria-label='what a is']", "time")
    page.select_option("[aria-label='what c [mm] is']", "observables")
    page.fill("[aria-label='most, of b [kPa]']", "40")
    page.press("[aria-label='most, of b [kPa]']", "Tab")
    page.wait_for_selector("[aria-label='most, of b [kPa]'][value='40.0']")
    page.wait_for_selector("[data-import]:not([disabled])")
    held: list[Any] = []
    page.route("**/api/columns", lambda route: held.append(route))
    page.fill("[aria-label='called, of d']", "temperature")
    page.click("[data-import]")  # before the answer, which is what it makes a run of
    _let_go(page, held)
    _at(page, "#/run/odd/compare")
    made = read_run_yaml(bench.desk.folder / "odd")["mapping"]
    (b,) = made["actuation"]
    assert (b["column"], b["name"], b["unit"], b["max"], b.get("min")) == ("b [kPa]", "b", "kPa", 40.0, None)
    assert [o["column"] for o in made["observables"]] == ["c [mm]"]
    assert [c["name"] for c in made["covariates"]] == ["temperature"]
    assert not list(bench.desk.folder.glob(".workbench/dropped/*"))  # the run holds it


def _let_go(page: Any, held: list[Any]) -> None:
    """Let the request that was held go on, once it is there, and those that follow."""
    while not held:
        page.wait_for_timeout(10)
    held.pop().continue_()
    page.unroute("**/api/columns")


@pytest.mark.usefixtures("browser")
def test_what_is_typed_outlives_an_answer(open_page, tmp_path):
    """An answer that comes while somebody types takes neither what is typed nor what is selected."""
    rows = "".join(f"{5 * i},{10 * (i % 4)},{0.3 * (i % 4) + 0.01 * i:.2f}\n" for i in range(24))
    (tmp_path / "odd.csv").write_text("time [s],b [kPa],c [mm]\n" + rows)
    page = open_page()
    page.goto(page.url.split("#")[0] + "#/choose")
    page.set_input_files("input[type=file]", tmp_path / "odd.csv")
    called, most = (
        page.locator("[aria-label='called, of c [mm]']"),
        page.locator("[aria-label='most, of b [kPa]']"),
    )
    assert called.input_value()
    held: list[Any] = []
    page.route("**/api/columns", lambda route: held.append(route))
    most.fill("40")
    called.select_text()  # the field before is left, and its answer is still to come
    _let_go(page, held)
    page.wait_for_selector("[aria-label='most, of b [kPa]'][value='40.0']")
    page.keyboard.type("ti")  # over what was selected
    assert called.input_value() == "ti"
    page.route("**/api/columns", lambda route: held.append(route))
    page.keyboard.press("Enter")
    page.keyboard.type("p")
    _let_go(page, held)
    page.wait_for_selector("[aria-label='called, of c [mm]'][value='ti']")
    assert called.input_value() == "tip"
    with page.expect_response("**/api/columns"):
        page.keyboard.press("Tab")
    page.wait_for_selector("[aria-label='called, of c [mm]'][value='tip']")
