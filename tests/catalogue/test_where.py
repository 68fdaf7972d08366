"""Conditions on runs: they compare, and can do nothing else."""

import warnings
from pathlib import Path

import pytest

from labrig import LabrigError
from labrig.catalogue import COLUMNS, Row, list_runs, runs
from labrig.catalogue._where import condition

ROW = Row(
    run="shelf/monday", started="2026-07-30 12:00:00", rig="mannequin", operator="ada", procedure="capture",
    captures=20, planned=25, length_s=61.5, size_mb=3.2, state="completed", warnings=0, model="model.yaml",
    verdict="identified", error=1.9, floor=0.1, units="mm", tags=("good", "wet day"), notes="chamber 3 leaks",
)  # fmt: skip


@pytest.mark.parametrize(
    "text",
    [
        "verdict == 'identified' and rig == 'mannequin'",
        'verdict == "identified"',
        "captures > 10 and not captures > 20",
        "captures < planned or verdict == 'unknown'",
        "0.1 < error <= 1.9",
        "error > 2 * floor + 0.5",
        "error / floor > 18 and -error < 0",
        "rig in ('bench', 'mannequin')",
        "captures in [19, 20]",
        "captures in [-1, 20] and captures not in (-20, 2)",
        "'good' in tags and 'bad' not in tags",
        "'leaks' in notes",
        "'2026-07' in started",
        "started >= '2026-07-30' and started < '2026-08'",
        "verdict != 'unknown'",
        "error != None and error is not None and 'x' not in notes",
        " True ",
        "(\nverdict == 'identified'\n)",
        "state == 'completed'  # a remark",
    ],
)
def test_what_is_true_of_a_run(text: str) -> None:
    """Comparisons, and, or, not, in, sums and products mean what they mean in Python."""
    assert condition(text)(ROW)
    assert not condition(f"not ({text.partition('#')[0]})")(ROW)


@pytest.mark.parametrize(
    "text",
    [
        "error > 0",
        "error < 99",
        "floor / error > 0",
        "error / 0 > 1",
        "started < '2027'",
        "started > ''",
        "'good' in tags",
        "verdict == 'identified'",
        "error == 0",
        "verdict is not None",
        "tags != None",
        "error in [0]",
    ],
)
def test_what_is_not_known_is_like_nothing(text: str) -> None:
    """A run without a diagnosis, a date or tags is not in the answer."""
    assert not condition(text)(Row("empty"))


def test_what_is_not_known_can_be_asked_for() -> None:
    """`verdict == None` (or '') are the runs that nobody has looked at yet."""
    for text in (
        "verdict == None",
        "verdict == ''",
        "error is None",
        "tags == None",
        "verdict != 'identified'",
    ):
        assert condition(text)(Row("empty")), text


@pytest.mark.parametrize(
    ("text", "said"),
    [
        ("verdit == 'x'", "there is no column 'verdit'; did you mean verdict? (columns: run, started, rig, "),
        ("captures > 'x'", "captures is a number and 'x' a text: they don't compare"),
        (
            "tags == 'good'",
            "tags is a list of words and 'good' a text: they don't compare; write 'good' in tags",
        ),
        ("error", "error is a number, no condition; write it like verdict == 'identified'"),
        ("error and floor", "error is a number, no condition"),
        ("rig + 'x' == 'y'", "rig + 'x': rig is a text, no number"),
        ("rig in [None]", "[None]: a list holds texts and numbers only"),
        (
            "verdict = 'identified'",
            "can't be read; write it like verdict == 'identified' and captures > 20 (== compares",
        ),
        ("verdict LIKE 'i%'", "can't be read"),
        ("", "can't be read"),
        ("rig is 'x'", "they don't compare"),
    ],
)
def test_a_condition_without_meaning_is_one_line(text: str, said: str) -> None:
    """What is wrong, and what to write instead."""
    with pytest.raises(LabrigError) as caught:
        condition(text)
    message = str(caught.value)
    assert message.startswith(f"where {text!r}: ")
    assert said in message
    assert "\n" not in message


@pytest.mark.parametrize(
    "text",
    [
        "__import__('os').system('touch HERE')",
        "open('HERE', 'w')",
        "@pd.eval('1')",
        "rig.__class__ == 'x'",
        "(lambda: 1)() == 1",
        "[x for x in tags] == 1",
        "(rig := 'x') == 'x'",
        "f'{open(1)}' == rig",
        "rig['x'] == 'y'",
        "captures ** 9 ** 9 > 1",
        "'a' * 9999999999 == rig",
        "9 ** 9 ** 9 ** 9 > 1",
        "1 << 99999999999 > 1",
        "b'x' == rig",
        "1j == error",
        "... == rig",
        "run == run; import os",
        "1) UNION SELECT * FROM runs --",
        "'x'; DROP TABLE runs",
        "rig == 'x' if open('HERE', 'w') else True",
        "lambda: 1",
        "await rig",
        "yield",
        "\x00",
        "\udcff == 1",
        "(" * 5000 + "1" + ")" * 5000,
        "not " * 50_000 + "True",
        "-" * 50_000 + "1 == 1",
        "1" * 5000 + " == captures",
        "`rig` == 'x'",
        "*rig",
        "{'a': open('HERE', 'w')} == rig",
    ],
)
def test_a_condition_never_runs_anything(text: str, tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    """What is not a comparison is refused, in one line and without being tried."""
    monkeypatch.chdir(tmp_path)
    with pytest.raises(LabrigError):
        condition(text)
    assert list(tmp_path.iterdir()) == []


def test_a_condition_makes_no_warnings() -> None:
    """What Python warns of in a source text is no matter of who types a condition."""
    with warnings.catch_warnings():
        warnings.simplefilter("error")
        assert not condition(r"'\d' in notes")(ROW)


def test_every_column_can_be_asked_for(shelf: Path) -> None:
    """Each name of the table is one of a condition, and the table holds those that fit."""
    for name in COLUMNS:
        list_runs(shelf, f"{name} != None")
    assert list(runs(shelf, "captures > 2")["run"]) == ["tuesday"]


@pytest.mark.parametrize(
    ("text", "true"),
    [
        ("started == '2026-07-30'", True),
        ("started == '2026-07'", True),
        ("started != '2026-07-30'", False),
        ("started <= '2026-07-30'", True),
        ("started > '2026-07-30'", False),
        ("started > '2026-07-29'", True),
        ("started == '2026-07-30 12'", True),
        ("'2026-07-30' < started", False),
        ("'2026-07' <= started <= '2026-07'", True),
        ("started >= '2026-07-30T12:00Z'", True),
        ("started >= '2026-07-30T11:59:59'", True),
        ("started > '2026-07-30 12:00'", False),
        ("started < '2026-07-30T13:00'", True),
    ],
)
def test_a_moment_is_as_exact_as_it_is_written(text: str, true: bool) -> None:
    """A day is all of that day, however it is compared, and a moment may be written with its T."""
    assert condition(text)(ROW) is true


@pytest.mark.parametrize("moment", ["2026-7", "2026-7-3", "30.07.2026", "July", "30/07/2026"])
def test_what_is_no_moment_is_refused(moment: str) -> None:
    """Compared letter by letter it would list other runs than were meant, or none."""
    with pytest.raises(LabrigError) as caught:
        condition(f"started >= '{moment}'")
    assert f"{moment!r} is no moment: write it like '2026-07', '2026-07-30' or" in str(caught.value)
