"""What is wrong with a file of somebody's own: the file, the line, the name of the entry, and the near miss."""

from pathlib import Path
from typing import Any, Literal

import pytest
from pydantic import BaseModel, ConfigDict, Field

from labrig import LabrigError
from labrig._fields import check_fields
from labrig._yaml import line_of, read_yaml


class Strict(BaseModel):
    """No other fields than those."""

    model_config = ConfigDict(extra="forbid")


class Bag(Strict):
    """An entry with a name."""

    name: str
    volume_ml: float = Field(gt=0)


class Box(Strict):
    """A file of every sort of field."""

    lid: str
    bags: list[Bag] = []
    table: str | list[str | Bag] | None = None
    colour: Literal["red", "blue"] = "red"
    size_mm: tuple[float, float] = (1.0, 1.0)


def complaint(folder: Path, text: str) -> str:
    """What is said of a file with this text, behind its name."""
    path = folder / "box.yaml"
    path.write_text(text, encoding="utf-8")
    with pytest.raises(LabrigError) as caught:
        check_fields(Box, read_yaml(path, "box"), str(path), path)
    message = str(caught.value)
    assert "\n" not in message
    assert message.startswith(str(path))
    return message.removeprefix(str(path))


@pytest.mark.parametrize(
    ("text", "message"),
    [
        (
            "lid: x\nbags: [{name: a, volume_ml: true}]\n",
            ", line 2: bags: a: volume_ml: should be a valid number, not True",
        ),
        ("lid: x\nsize_mm: [1, no]\n", ", line 2: size_mm: entry 2: should be a valid number, not False"),
        (
            "lid: x\nbags: [{name: a, volume_ml: 060}]\n",
            ", line 2: 060 is 48 to YAML: write 60, or '060' in quotes, if it is a name",
        ),
        (
            "lid: x\nbags: [{name: a, volume_ml: 1:30}]\n",
            ", line 2: 1:30 is 90 to YAML: '1:30' in quotes, if it is a name",
        ),
    ],
)
def test_a_number_is_the_number_that_was_written(tmp_path: Path, text: str, message: str) -> None:
    """What pydantic or YAML would take for another number (yes is 1, 060 is 48) is refused with its line."""
    assert complaint(tmp_path, text) == message


@pytest.mark.parametrize(
    ("text", "message"),
    [
        ("lib: x\n", ", line 1: lib: there is no such field; did you mean lid, which is missing?"),
        (
            "lid: x\nbags:\n- name: a\n  volume_ml: 1\n- name: b\n  volum_ml: 2\n",
            ", line 6: bags: b: volum_ml: there is no such field; did you mean volume_ml, which is missing?",
        ),
        ("lid: x\ncolor: red\n", ", line 2: color: there is no such field; did you mean colour?"),
        (
            "lid: x\nweight: 3\n",
            ", line 2: weight: there is no such field; there are lid, bags, table, colour, size_mm",
        ),
        ("bags: []\n", ": lid: is missing"),
        ("lid: x\nsize_mm: [1]\n", ", line 2: size_mm: entry 2: is missing"),
        ("lid: x\nbags: 3\n", ", line 2: bags: should be a list, not 3"),
        ("lid: x\nbags:\n- volume_ml: 1\n", ", line 3: bags: entry 1: name: is missing"),
        (
            "lid: x\nbags: [{name: a, volume_ml: much}]\n",
            ", line 2: bags: a: volume_ml: should be a valid number, not 'much'",
        ),
        ("lid: x\nbags: [small]\n", ", line 2: bags: entry 1: should hold fields (name: value), not 'small'"),
        ("lid:\n", ", line 1: lid: should be a valid string, not nothing"),
        ("lid: [x]\n", ", line 1: lid: should be a valid string, not a list"),
        (
            "lid: x\ntable:\n- one\n- {name: a, volume_mm: 3, volume_ml: 2}\n",
            ", line 4: table: a: volume_mm: there is no such field; did you mean volume_ml?",
        ),
        (
            "lid: x\ncolour: green\nbags: [{name: a, volume_ml: 0}]\n",
            ", line 3: bags: a: volume_ml: should be greater than 0, not 0 (and 1 more)",
        ),
    ],
)
def test_a_wrong_field_is_named_with_its_line(tmp_path: Path, text: str, message: str) -> None:
    """The line as an editor counts it, entries by their names, and for a misspelt name the one that was meant."""
    assert complaint(tmp_path, text) == message


@pytest.mark.parametrize(
    ("text", "message"),
    [
        (
            "lid: x\nbags: [\n",
            ", line 3: is not YAML (expected the node content, but found '<stream end>')",
        ),
        (
            "lid: x\nbags:\n\t- name: a\n",
            ", line 3: is not YAML (found character '\\t' that cannot start any token; "
            "indent with spaces, not with a tab)",
        ),
        ("lid: a\x07b\n", ": is not YAML (special characters are not allowed)"),
        (
            "lid: !secret x\n",
            ", line 1: is not YAML (could not determine a constructor for the tag '!secret')",
        ),
        ("- lid\n", " is not a box: it should begin with `name: ...`"),
    ],
)
def test_what_is_no_yaml_is_named_with_its_line(tmp_path: Path, text: str, message: str) -> None:
    """The file and the line, never a string without a name."""
    assert complaint(tmp_path, text) == message


@pytest.mark.parametrize(
    ("text", "message"),
    [
        ("lid: x\ncolour: red\nlid: y\n", ", line 3: lid is given twice (first in line 1); keep one of them"),
        (
            "lid: x\nbags:\n- {name: a, volume_ml: 20, volume_ml: 60}\n",
            ", line 3: volume_ml is given twice; keep one of them",
        ),
    ],
)
def test_a_key_that_is_given_twice_is_refused(tmp_path: Path, text: str, message: str) -> None:
    """Of two limits the last is not taken silently: file, line and key are named."""
    assert complaint(tmp_path, text) == message


def test_what_is_merged_may_be_given_again(tmp_path: Path) -> None:
    """An entry that takes another's values by `<<` may replace some of them: that is no key given twice."""
    path = tmp_path / "box.yaml"
    path.write_text("a: &a {name: a, volume_ml: 1}\nb: {<<: *a, name: b}\nc: *a\n")
    assert read_yaml(path, "box")["b"] == {"name": "b", "volume_ml": 1}


def test_bytes_are_no_yaml(tmp_path: Path) -> None:
    """A model of another kind, a picture or a log in place of a YAML file is told apart."""
    path = tmp_path / "box.yaml"
    path.write_bytes(b"\x89PNG\xff")
    with pytest.raises(LabrigError) as caught:
        read_yaml(path, "box")
    assert str(caught.value) == f"{path} is not a text file; a box is YAML"


def test_a_line_is_as_near_as_it_can_be(tmp_path: Path) -> None:
    """What does not stand in the file is at the line of what holds it; for the file itself there is none."""
    path = tmp_path / "box.yaml"
    path.write_text("lid: x\nbags:\n- name: a\n- name: b\n")

    def line(*place: Any) -> int | None:
        return line_of(path, place)

    assert [line("lid"), line("bags"), line("bags", 1), line("bags", 1, "name")] == [1, 2, 4, 4]
    assert [line("bags", 1, "volume_ml"), line("none"), line(), line("lid", "more")] == [4, None, None, 1]
    assert line_of(tmp_path / "none.yaml", ("lid",)) is None
