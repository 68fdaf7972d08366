"""Fitted values chamber by chamber and place by place."""

import re

import pytest

from labrig.diagnosis import improve, prepared, rows_from
from labrig.effects import Fitted, library, weighable
from labrig.view._places import place_tables
from labrig.view._report import report_html
from labrig.view._values import values_words

CHAMBERS = ["left", "middle", "right"]


def test_gains_of_each_chamber_by_name():
    """Every chamber has a row with all of its values, and by how much its pressure changes."""
    gain = {"value": [0.1, -0.2, 0.0], "sd": [0.01, 0.02, 0.01], "unit": "1", "per": CHAMBERS}
    offset = {"value": [1.0, 2.0, 3.0], "sd": [0.1, 0.2, 0.3], "unit": "kPa", "per": CHAMBERS}
    changed = {"left": (0.12, 4.0), "middle": (-0.15, 5.0), "right": (0.05, 2.0)}
    ((kind, header, rows),) = place_tables({"gain": gain, "offset": offset}, changed, "kPa", {})
    assert kind == "chamber"
    assert header == [
        "chamber",
        "gain",
        "offset\u00a0kPa",
        "as a change of pressure, %",
        "root mean square, kPa",
    ]
    assert rows[1] == ["middle", "-0.200 ± 0.020", "2.00 ± 0.20", "-15.0", "5"]
    assert [row[0] for row in rows] == CHAMBERS


def test_one_value_for_all_still_names_the_chambers():
    """A leak as the sensors measured it has one value, and yet each chamber's loss."""
    sensor = {"value": 0.97, "sd": 0.01, "unit": "1"}
    changed = {name: (-0.05 * k, 1.0 * k) for k, name in enumerate(CHAMBERS)}
    ((_, _, rows),) = place_tables({"sensor": sensor}, changed, "kPa", {})
    assert [row[:2] for row in rows] == [["left", "-0.0"], ["middle", "-5.0"], ["right", "-10.0"]]


def test_a_rest_shape_place_by_place():
    """Every marker has a row with its offset along each axis and the chamber that moves it most, the largest first."""
    per = [f"{m}.{a}" for m in ("m1", "m2") for a in "xyz"]
    offset = {"value": [0.1, 0.2, 0.3, -2.0, 0.0, 1.0], "sd": [0.01] * 6, "unit": "mm", "per": per}
    ((kind, header, rows),) = place_tables({"offset": offset}, {}, "kPa", {"m1": "left", "m2": "right"})
    assert kind == "marker"
    assert header == ["offset", "most moved by", "x, mm", "y, mm", "z, mm"]
    assert rows == [["m2", "right", "-2", "0", "1"], ["m1", "left", "0.1", "0.2", "0.3"]]


def test_weights_belong_to_functions():
    """Where a family's weights were fitted, a row is a function, whatever it acts on."""
    weights = {"value": [0.1, 0.2], "sd": [0.01, 0.01], "unit": "1", "per": ["lost 2.0", "lost 2.0 of left"]}
    ((kind, header, rows), *_) = place_tables({"weights": weights}, {}, "kPa", {})
    assert (kind, header[0]) == ("function", "function")
    assert [row[0] for row in rows] == ["lost 2.0", "lost 2.0 of left"]


def test_a_number_that_stands_for_a_chamber_is_no_table():
    """Which chamber alone is stopped is one value with a name, and has no rows."""
    which = {"value": 1.0, "unit": "1", "per": ["middle"]}
    assert place_tables({"chamber": which}, {}, "kPa", {}) == []


def test_patterns_have_a_column_each():
    """Where each chamber moves the sensors in a pattern of its own, every sensor has a row with all of them."""
    pattern = {
        "value": [[1.0, 2.0], [3.0, 4.0]],
        "sd": [[0.1, 0.1], [0.1, 0.1]],
        "unit": "deg/N",
        "per": ["angle", "force"],
    }
    ((kind, header, rows), *_) = place_tables({"pattern": pattern}, {}, "kPa", {})
    assert kind == "observable"
    assert header == ["observable", "pattern 1\u00a0deg/N", "pattern 2\u00a0deg/N"]
    assert rows == [["angle", "1.00 ± 0.10", "3.00 ± 0.10"], ["force", "2.00 ± 0.10", "4.00 ± 0.10"]]


def test_values_of_sessions_are_called_so():
    """A gain that is another on each day has the days' names under `session`."""
    gain = {"value": [0.1, 0.2], "sd": [0.01, 0.01], "unit": "1", "per": ["monday", "tuesday"]}
    ((kind, _, rows), *_) = place_tables({"gain_in_session": gain}, {}, "kPa", {})
    assert (kind, [row[0] for row in rows]) == ("session", ["monday", "tuesday"])


def test_each_cell_has_the_unit_of_its_row_where_they_differ():
    """An angle and a resistance in one column have each their own unit, as shifts and turns of a frame have."""
    units = {"angle": "deg", "r1": "ohm"}
    pattern = {"value": [1.0, 2.0], "unit": "(deg or ohm)", "per": [*units]}
    ((kind, header, rows),) = place_tables({"pattern": pattern}, {}, "kPa", {}, units)
    assert (kind, header) == ("observable", ["observable", "pattern"])
    assert rows == [["angle", "1\u00a0deg"], ["r1", "2\u00a0ohm"]]
    shift = {"value": [1.0, 0.01], "unit": "mm, rad", "per": ["a: x", "a: about x"]}
    ((_, header, rows),) = place_tables({"shift_in_session": shift}, {}, "kPa", {})
    assert header == ["session", "shift in session"]
    assert rows == [["a: x", "1\u00a0mm"], ["a: about x", "0.01\u00a0rad"]]


def test_an_offset_in_each_session_has_a_column_for_each_observable():
    """Every session has a row with the offsets of all observables, in their units."""
    units = {"angle": "deg", "r1": "ohm"}
    offset = {
        "value": [[1.0, 2.0], [3.0, 4.0], [5.0, 6.0]],
        "sd": [[0.1, 0.2]] * 3,
        "unit": "(deg or ohm)",
        "per": ["mon", "tue", "wed"],
    }
    ((_, header, rows),) = place_tables({"offset_in_session": offset}, {}, "kPa", {}, units)
    assert header == ["session", "offset in session angle\u00a0deg", "offset in session r1\u00a0ohm"]
    assert rows[2] == ["wed", "5.00 ± 0.10", "6.00 ± 0.20"]


def test_a_turned_frame_is_turned_in_rad():
    """The three rotations of a frame are no lengths."""
    per = ["x", "y", "z", "about x", "about y", "about z"]
    shift = {
        "value": [1.0, 2.0, 3.0, 0.01, 0.02, 0.03],
        "sd": [0.1] * 3 + [0.001] * 3,
        "unit": "mm",
        "per": per,
    }
    said = values_words({"shift": shift})
    assert "about x 0.0100 ± 0.0010\u00a0rad, about y 0.0200 ± 0.0010\u00a0rad" in said
    assert place_tables({"shift": shift}, {}, "kPa", {}) == []


def test_the_report_has_them(make_lab):
    """The change of each chamber's pressure in the report is the one that was put in."""
    lab = make_lab(captures=40)
    u = lab.u * [1.1, 0.9, 1.0]
    result = improve(lab.dataset(lab.predict(u) + lab.noise()), lab.model(), ["regulator"])
    shares = {name: share for name, (share, _) in result.signatures[0].chambers.items()}
    assert shares == pytest.approx({"c1": 0.1, "c2": -0.1, "c3": 0.0}, abs=0.02)
    html = report_html(result)
    assert all(f"<td>{name}</td>" in html for name in shares)


@pytest.mark.parametrize(
    ("unit", "name", "shown"),
    [
        ("s", "lost 60.0 square of c1", "lost 60 s square of c1"),
        ("s", "skin 600.0 by place 1", "skin 600 s by place 1"),
        ("%", "play 0.06 of -1.00 to 0.33", "play 6 % of -100 % to 33 %"),
        ("%", "last turn 0 at 1", "last turn 0 at 1"),
        ("", "mine 2.0", "mine 2.0"),
    ],
)
def test_functions_have_units_in_their_names(unit, name, shown):
    """What is a time or a share in the name of a family's function is shown with its unit; the model file stays."""
    weights = {"value": [0.2], "sd": [0.01], "unit": "1", "per": [name]}
    one = Fitted("leak", "family, lost", {"weights": weights}, unit_in_names=unit)
    ((_, _, rows),) = place_tables(one.shown, {}, "kPa", {})
    assert rows == [[shown, "0.200 ± 0.010"]]
    assert one.parameters["weights"]["per"] == [name]


def test_every_number_in_a_functions_name_has_a_unit(make_lab):
    """Of each effect whose functions are named with decimals it is said what these are."""
    lab = make_lab(captures=24, long_s=(3.0, 5.0, 10.0, 30.0))
    context = prepared(rows_from(lab.dataset(lab.predict(lab.u) + lab.noise())), lab.model()).context
    bare = {
        effect.name
        for effect in library().values()
        for space in weighable(effect, context)
        for each in space.features
        if re.search(r"\d\.\d", each.name) and not effect.unit_in_names
    }
    assert bare == set()
