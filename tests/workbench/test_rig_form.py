"""The form of a rig: what is typed becomes a rig file, and a rig file fills the form, with nothing lost on the way."""

import json
from pathlib import Path
from typing import Any

import pytest
import yaml
from hypothesis import given

from labrig import LabrigError
from labrig._yaml import load_yaml
from labrig.rig import check_rig
from labrig.workbench._rig_fields import CHAMBER, DEVICES, SECTIONS
from labrig.workbench._rig_form import content_of, form_of, fresh_form, same, text_of
from labrig_drivers import SETTINGS
from tests.workbench.rig_contents import contents

GOOD: dict[str, Any] = {
    "name": "bench",
    "chambers": [{"name": "c1", "max_kpa": 60}, {"name": "c2", "max_kpa": 50}],
    "pressure": {"kind": "openpneu", "port": "COM3"},
    "mocap": {"kind": "vicon"},
}


def everything(content: dict[str, Any]) -> dict[str, Any]:
    """A rig with every default written out, of its devices as well."""
    config = check_rig(content, "rig", Path())
    out = config.to_dict()
    for role, device in config.devices.items():
        if device is not None and device.kind in SETTINGS:
            out[role] = {
                "kind": device.kind,
                **SETTINGS[device.kind].model_validate(device.options).model_dump(),
            }
    if "outputs" in out["pressure"] and out["pressure"]["outputs"] is None:
        out["pressure"]["outputs"] = tuple(range(len(config.chambers)))
    return out


@given(contents())
def test_what_the_form_holds_comes_back_as_it_was(content: dict[str, Any]) -> None:
    """Through the form, the page's JSON and the text of the file a rig stays the same rig, whatever it is called."""
    form = json.loads(json.dumps(form_of(content)))
    back = load_yaml(text_of(content_of(form)))
    assert everything(back) == everything(content)
    assert same(check_rig(back, "rig", Path()), check_rig(content, "rig", Path()))
    again = form_of(back)
    assert content_of(again) == content_of(form)


def test_the_form_says_what_the_file_says() -> None:
    """Every setting that a kind of device has in its rig file, and nothing else, is a field or known to be none."""
    without = {"vicon": {"rename"}, "artec": {"formats", "size_mm"}}
    extra = {"modbus": {"by"}}
    for kinds in DEVICES.values():
        for kind in kinds:
            if kind.kind in SETTINGS:
                own = set(SETTINGS[kind.kind].model_fields) - {"outputs"} - without.get(kind.kind, set())
                assert {field.key for field in kind.fields} - extra.get(kind.kind, set()) == own, kind.kind


def test_what_is_as_labrig_has_it_is_left_out() -> None:
    """A new form whose gaps are filled is a file as short as the one in the documentation."""
    form = fresh_form() | {"name": "bench", "pressure": {"kind": "openpneu", "port": " COM3 "}}
    row = {"min_kpa": 0, "max_kpa": 60, "slew_kpa_s": 100}
    assert content_of(form) == {
        "name": "bench",
        "chambers": [{"name": f"c{n}", **row} for n in range(1, 5)],
        "pressure": {"kind": "openpneu", "port": "COM3"},
    }


def test_a_comma_is_a_decimal_point() -> None:
    """As on a German keyboard, in every number."""
    form = form_of(GOOD)
    form["chambers"][0]["max_kpa"] = "12,5"
    form["safety"]["heartbeat_s"] = "1,5"
    made = content_of(form)
    assert (made["chambers"][0]["max_kpa"], made["safety"]["heartbeat_s"]) == (12.5, 1.5)


def test_markers_stand_in_lines_or_between_commas() -> None:
    """Pasted out of a rig file or typed one a line; three numbers behind a name are its resting place."""
    form = form_of(GOOD) | {"markers": "m1, m2,m3, m4\n\n m5 , 1, 2.5, -3 \nm6"}
    made = content_of(form)
    assert made["markers"] == ["m1", "m2", "m3", "m4", "m5", "m6"]
    assert made["rest_mm"] == {"m5": [1, 2.5, -3]}


@pytest.mark.parametrize("line", ["m01, 1, 2", "m01, 1, 2, 3, 4", "m01, 1, 2, x"])
def test_a_resting_place_has_three_numbers(line: str) -> None:
    """Two or four are no markers with numbers for names: the line is told, and what belongs there."""
    with pytest.raises(LabrigError, match=rf"^markers: {line}: a resting place has three numbers"):
        content_of(form_of(GOOD) | {"markers": f"m0, 1, 2, 3\n{line}"})


@pytest.mark.parametrize(
    ("change", "said"),
    [
        ({"pressure": {"kind": "python", "file": "mine.py", "class": "Mine"}}, "pressure of kind 'python'"),
        ({"mocap": {"kind": "vicon", "rename": {"a": "b"}}}, "mocap.rename"),
        ({"scanner": {"kind": "artec", "folder": "x", "unit": "mm", "formats": ["ply"]}}, "scanner.formats"),
        ({"scanner": {"kind": "simulated", "takes_s": 1}}, "scanner.takes_s"),
        ({"simulated": {"hidden": "sealed.json"}}, "simulated.hidden"),
        ({"simulated": {"plant": {"seed": 1}}}, "simulated.plant"),
        ({"simulated": {"shell": {"name": "x"}}}, "simulated.shell with content of its own"),
        ({"colour": "red"}, "colour"),
        ({"rest_mm": {"m1": [0, 0, 0]}}, "a resting place of m1"),
        ({"markers": "m1"}, "markers other than a list"),
        ({"markers": [["m1"]]}, "markers other than a list of names"),
        ({"pressure": {"kind": [1]}}, "what pressure.kind is"),
        ({"pressure": {"kind": "openpneu", "port": "COM3", "outputs": [1]}}, "pressure.outputs"),
        ({"pressure": {"kind": "openpneu", "port": "COM3", "boot_s": True}}, "what pressure.boot_s is"),
        ({"safety": {"vents_alone": "a relay\nof the laboratory"}}, "safety.vents_alone of several lines"),
        ({"safety": ["a"]}, "safety"),
        ({"chambers": [{"name": f"c{n}", "max_kpa": 1} for n in range(65)]}, "more than 64 chambers"),
        ({"chambers": [{"name": "c1", "max_kpa": 1, "colour": "red"}]}, "chambers.0.colour"),
    ],
)
def test_what_the_form_has_no_field_for_is_named(change: dict[str, Any], said: str) -> None:
    """Rather than lost without a word."""
    with pytest.raises(LabrigError, match=r"^the form has no field for ") as caught:
        form_of({**GOOD, **change})
    assert said in str(caught.value)


@pytest.mark.parametrize(
    "change",
    [
        {"markers": ["m1, 1, 2, 3"]},
        {"simulated": {"surface": "membrane"}},
        {"pressure": {"kind": "modbus", "map": "festo-vtem.yaml", "host": "a", "parity": "E"}},
        {"pressure": {"kind": "modbus", "map": "festo-vtem.yaml", "host": "a", "serial": "COM3"}},
    ],
)
def test_what_would_be_lost_all_the_same_is_noticed(change: dict[str, Any]) -> None:
    """A name that reads like a place, a section of no use, a setting of the other link: not the same rig."""
    before = check_rig({**GOOD, **change}, "rig", Path())
    assert not same(before, check_rig(content_of(form_of({**GOOD, **change})), "rig", Path()))


@pytest.mark.parametrize(
    ("form", "said"),
    [
        ({}, "chambers: there is room for 64"),
        ({"chambers": [{}] * 65}, "chambers: there is room for 64"),
        ({"chambers": ["c1"]}, "chambers.0: a row of the table is needed"),
        ({"chambers": [{"name": ["c1"]}]}, "chambers.0.name: a text is needed"),
        ({"name": "a" * 200_000, "chambers": []}, "name: a text is needed, of at most"),
        ({"name": "a\0", "chambers": []}, "name: 'a\\x00' holds a sign that cannot be printed"),
        ({"name": "\ud800", "chambers": []}, "holds a sign that cannot be printed"),
        ({"chambers": [], "pressure": {"kind": "python"}}, "pressure: the form has no kind 'python'"),
        ({"chambers": [], "pressure": {"kind": ["x"]}}, "pressure.kind: a text is needed"),
        (
            {
                "chambers": [],
                "pressure": {"kind": "simulated"},
                "mocap": {"kind": "vicon"},
                "markers": "a,b," * 501,
            },
            "markers: there is room for 1000",
        ),
    ],
)
def test_what_no_page_sends_is_refused(form: dict[str, Any], said: str) -> None:
    """In one line, at once."""
    with pytest.raises(LabrigError) as caught:
        content_of(form)
    assert said in str(caught.value)
    assert "\n" not in str(caught.value)


def test_names_are_those_of_the_file() -> None:
    """The sections and columns of the form are called as a rig file calls them, so that a fault finds its field."""
    fields = check_rig(GOOD, "rig", Path()).to_dict()
    assert {field.key for field in CHAMBER} - {"output"} == set(fields["chambers"][0])
    for name in ("safety", "follow"):
        assert {field.key for field in SECTIONS[name]} == set(fields[name])


def test_the_text_is_yaml_that_a_person_reads() -> None:
    """A row a chamber, and where to read what it means."""
    text = text_of(content_of(form_of(GOOD)))
    assert text.startswith("# Set up in labrig's workbench.")
    assert "\n- {name: c1, min_kpa: 0, max_kpa: 60, slew_kpa_s: 100}\n" in text
    assert yaml.safe_load(text)["mocap"] == {"kind": "vicon"}
