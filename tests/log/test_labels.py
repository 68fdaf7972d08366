"""What numbers days, runs and repeats, in the languages of the people who write it, and where no name says so."""

import json
from pathlib import Path

import numpy as np
import pandas as pd
import pytest

from labrig.log import Guess, guess_mapping, import_table

HOLDS = np.random.default_rng(2).choice([0.0, 10.0, 20.0, 30.0], 60)
P = np.repeat(HOLDS, 3)
F = (0.3 * P + np.random.default_rng(3).normal(0, 0.05, 180)).round(3)
DAYS = np.repeat([1, 2, 4], 60)
SAID = "is a whole number that never falls and stands still in holds: taken for"


def guess(folder: Path, **columns: object) -> Guess:
    """The guess for a table of one pressure and one force with these columns."""
    frame = pd.DataFrame({"t_s": np.arange(180) * 4.0, "p_set_kPa": P, "force_N": F, **columns})
    frame.to_csv(folder / "t.csv", index=False)
    return guess_mapping(folder / "t.csv")


def test_words_that_stand_together_may_be_sessions(tmp_path: Path) -> None:
    """Words that are the same in rows one behind the other are left out, and what they may be is said; words
    that come and go are left out.
    """
    found = guess(tmp_path, body=np.repeat(["long", "short", "wide"], 60), way=np.tile(["up", "down"], 90))
    assert "session" not in found.mapping
    hint = " (if it names specimens or days, 'session: {column: body}' says so)"
    said = [
        f"column {name!r} holds no numbers{more} and is left out"
        for name, more in (("body", hint), ("way", ""))
    ]
    assert found.remarks == said


def test_what_counts_the_rows_of_each_hold_was_not_measured(tmp_path: Path) -> None:
    """A number that begins anew with each set-point is left out, whatever it is called, with a clock or without; what
    was measured and rises within holds is not.
    """
    steps = np.repeat([0, 10, 20, 5], 12)
    told = np.tile(np.arange(0, 48, 4), 4)
    force = (0.3 * steps + 0.01 * told + np.random.default_rng(1).normal(0, 0.002, 48)).round(3)
    for clock in ({}, {"t_s": np.arange(48) * 0.5}):
        frame = pd.DataFrame({**clock, "command_psi": steps, "sample_idx": told, "force_N": force})
        frame.to_csv(tmp_path / "t.csv", index=False)
        found = guess_mapping(tmp_path / "t.csv")
        assert observables(found) == ["force_N"]
        assert "column 'sample_idx' counts the rows of each hold and is left out" in found.remarks


PLACES = np.random.default_rng(4).uniform(0, 2, (15, 2)).round(3)
PLACES[[0, 5]] = 0.0
POINT = np.r_[np.arange(15), np.random.default_rng(5).permutation(15), np.arange(15)]
SEEN = (PLACES[POINT].sum(axis=1) + np.random.default_rng(6).normal(0, 0.01, 45)).round(3)


@pytest.mark.parametrize("rows", [1, 3])
@pytest.mark.parametrize("commands", [("p_A soll [bar]", "p_B soll [bar]"), ("p1_bar", "p2_bar")])
@pytest.mark.parametrize("name", ["Sollpunkt", "setpoint_no", "point", "k", "Punkt Nr", "pose", "Messstelle"])
def test_a_number_for_each_set_point_says_what_repeats(
    tmp_path: Path, name: str, commands: tuple[str, str], rows: int
) -> None:
    """Whole numbers that always have the same commands are no measurement, whatever they are called: they label what
    was repeated, in files of one row each as well, though all that is vented has two of them.
    """
    u, n = PLACES[POINT], len(POINT) * rows
    noise = np.random.default_rng(7).normal(0, 0.01, n)
    columns = {commands[0]: u[:, 0].repeat(rows), commands[1]: u[:, 1].repeat(rows)}
    frame = pd.DataFrame({"t_s": np.arange(n) * 4.0, **columns, name: POINT.repeat(rows) + 1})
    frame.assign(force_N=SEEN.repeat(rows) + noise).to_csv(tmp_path / "t.csv", index=False)
    found = guess_mapping(tmp_path / "t.csv")
    assert found.mapping["repeat"] == {"column": name}
    assert [a["column"] for a in found.mapping["actuation"]] == [*commands]
    assert observables(found) == ["force_N"]
    assert found.remarks == [
        f"column {name!r} has one number for each set-point and says which captures repeat each other"
    ]


@pytest.mark.parametrize("change", ["one of them elsewhere", "a gap", "not from one on"])
def test_whole_numbers_that_are_no_labels(tmp_path: Path, change: str) -> None:
    """A number that has other commands once, or leaves some out, was measured."""
    numbers = POINT.copy()
    numbers[20] = (numbers[20] + 1) % 15 if change == "one of them elsewhere" else numbers[20]
    numbers = {"a gap": np.where(numbers > 7, numbers + 1, numbers), "not from one on": numbers + 4}.get(
        change, numbers
    )
    u = PLACES[POINT]
    frame = pd.DataFrame({"t_s": np.arange(45) * 4.0, "p1_set_bar": u[:, 0], "p2_set_bar": u[:, 1]})
    frame.assign(seen=numbers, force_N=SEEN).to_csv(tmp_path / "t.csv", index=False)
    found = guess_mapping(tmp_path / "t.csv")
    assert "repeat" not in found.mapping
    assert observables(found) == ["seen", "force_N"]


def observables(found: Guess) -> list[str]:
    """The columns that a guess takes for what was measured."""
    return [each["column"] for each in found.mapping["observables"]]


@pytest.mark.parametrize(
    "name", ["Tag", "Versuch", "Prüfling Nr", "jour", "Séance", "día", "ensayo", "giorno", "prova"]
)
def test_a_day_is_a_session_in_other_languages(tmp_path: Path, name: str) -> None:
    """German, French, Spanish and Italian words for days, runs and specimens mean what the English ones do."""
    found = guess(tmp_path, **{name: DAYS})
    assert found.mapping["session"] == {"column": name}
    assert (observables(found), found.remarks) == (["force_N"], [])


@pytest.mark.parametrize("name", ["Wiederholung", "répétition", "repetición", "ripetizione"])
def test_a_repeat_in_other_languages(tmp_path: Path, name: str) -> None:
    """So do those for repeats."""
    assert guess(tmp_path, **{name: np.tile([1, 2, 3], 60)}).mapping["repeat"] == {"column": name}


@pytest.mark.parametrize("name", ["Tag", "jour", "día", "giorno"])
def test_dates_of_days_are_a_clock(tmp_path: Path, name: str) -> None:
    """A column of dates is the clock, though it is called a day."""
    stamps = pd.date_range("2026-05-04 09:00", periods=180, freq="5s").strftime("%d.%m.%Y %H:%M:%S")
    frame = pd.DataFrame({name: stamps, "p_set_kPa": P, "force_N": F})
    frame.to_csv(tmp_path / "t.csv", index=False)
    found = guess_mapping(tmp_path / "t.csv").mapping
    assert found["time"]["column"] == name
    assert "session" not in found


@pytest.mark.parametrize(("unit", "a_second"), [("s", 1.0), ("ms", 1000.0), ("min", 1 / 60)])
def test_what_goes_with_the_clock_in_each_hold_is_the_time_since_the_set_point(
    tmp_path: Path, unit: str, a_second: float
) -> None:
    """A column called hold without a unit is no measurement where it goes as the clock does and begins anew."""
    found = guess(tmp_path, hold=(np.tile([1.5, 5.5, 9.5], 60) * a_second).round(4))
    assert found.mapping["hold"] == {"column": "hold", "unit": unit}
    assert observables(found) == ["force_N"]
    assert any(f"taken for the time since the set-point, in {unit}" in said for said in found.remarks)


def test_what_only_is_called_a_hold_is_no_time(tmp_path: Path) -> None:
    """A force that holds goes with no clock: it was measured."""
    found = guess(tmp_path, hold=(5 - F**2).round(3))
    assert "hold" not in found.mapping
    assert observables(found) == ["force_N", "hold"]


def test_words_in_a_column_of_tags_name_no_session(tmp_path: Path) -> None:
    """A tag in English is a label: of words that come again and again it makes no sessions."""
    assert "session" not in guess(tmp_path, tag=np.tile(["up", "down"], 90)).mapping


@pytest.mark.parametrize("levels", [3, 10])
def test_a_number_that_never_falls_is_the_session(tmp_path: Path, levels: int) -> None:
    """Few whole numbers in blocks of several holds are the session, whatever they are called, and that is said."""
    found = guess(tmp_path, Messreihe=np.repeat(np.arange(levels), 180 // levels))
    assert found.mapping["session"] == {"column": "Messreihe"}
    assert (observables(found), len(found.mapping["actuation"])) == (["force_N"], 1)
    assert found.remarks == [f"column 'Messreihe' {SAID} the session"]


def test_a_second_number_that_never_falls_is_a_counter(tmp_path: Path) -> None:
    """Beside a session, or with another number every hold or two, it is left out, and that is said."""
    found = guess(tmp_path, day=DAYS, Messreihe=np.repeat(np.arange(6), 30), Bild=np.repeat(np.arange(30), 6))
    assert found.mapping["session"] == {"column": "day"}
    assert observables(found) == ["force_N"]
    assert [
        f"column {n!r} {SAID} a counter, and is left out" in found.remarks for n in ("Messreihe", "Bild")
    ] == [
        True,
        True,
    ]


@pytest.mark.parametrize("kind", ["falls", "in a hold", "fractions", "far apart"])
def test_what_was_measured_is_no_counter(tmp_path: Path, kind: str) -> None:
    """What falls once, steps within holds, has fractions or is far apart is no number of anything."""
    values = {
        "falls": np.repeat([1, 2, 1], 60),
        "in a hold": np.repeat([1, 2, 3], [61, 60, 59]),
        "fractions": DAYS / 2,
        "far apart": np.repeat([150, 160, 200], 60),
    }
    found = guess(tmp_path, reading=values[kind])
    assert observables(found) == ["force_N", "reading"]
    assert "session" not in found.mapping


@pytest.mark.parametrize("name", ["session", "specimen", "operator", "firmware_version"])
def test_one_whole_number_in_all_rows_is_a_label(tmp_path: Path, name: str) -> None:
    """What is one number without a unit all through was not measured: a model needs no column for it, and it is said.

    A force that stands still is kept: it was measured.
    """
    found = guess(tmp_path, **{name: 3, "force_2": 0})
    assert observables(found) == ["force_N", "force_2"]
    assert f"column {name!r} is 3 in all rows: taken for a label, and is left out" in found.remarks


def test_what_numbers_repeats_does_not_say_which_repeat_each_other(tmp_path: Path) -> None:
    """A column that is 1, 2, 3 for the visits of each set-point makes no repeats of different set-points."""
    visit = np.repeat(pd.Series(HOLDS).groupby(HOLDS).cumcount().to_numpy() + 1, 3)
    found = guess(tmp_path, rep=visit, hold_no=np.repeat(np.arange(60), 3))
    assert found.mapping["repeat"] == {"column": "rep"}
    mapping = {**found.mapping, "table": "t.csv"}
    (tmp_path / "map.yaml").write_text(json.dumps(mapping), encoding="utf-8")
    run = import_table(tmp_path / "map.yaml", tmp_path / "run")
    assert set(run["repeat"].values.tolist()) == {""}
    (said,) = (line for line in run.attrs["import_remarks"] if "repeat" in line)
    assert said.startswith("column 'rep' says '1' at different set-points")


@pytest.mark.parametrize("name", ["t since set (s)", "time after set-point [s]"])
def test_the_time_since_the_set_point_is_no_input(tmp_path: Path, name: str) -> None:
    """A time that says what it is counted from, and goes with the clock in each hold, is the time in the hold."""
    found = guess(tmp_path, **{name: np.tile([2.0, 6.0, 10.0], 60)})
    assert found.mapping["hold"] == {"column": name, "unit": "s"}
    assert [each["column"] for each in found.mapping["actuation"]] == ["p_set_kPa"]


def test_ts_is_a_time(tmp_path: Path) -> None:
    """Milliseconds since 1970 that are called ts, as programs write them, are the clock."""
    frame = pd.DataFrame({"ts": 1773216731000.0 + 4000 * np.arange(180), "p_set_kPa": P, "force_N": F})
    frame.to_json(tmp_path / "t.jsonl", orient="records", lines=True)
    assert guess_mapping(tmp_path / "t.jsonl").mapping["time"] == {"column": "ts", "unit": "ms"}


NUMBER = np.repeat(np.arange(60), 3) + 1
TAKEN = "is another at each set-point: taken for the number of the capture, and for no session or repeat"


@pytest.mark.parametrize("name", ["idx", "i", "take", "Aufnahme", "cycle [-]"])
def test_what_counts_up_with_each_set_point_is_its_number(tmp_path: Path, name: str) -> None:
    """A column that goes up by one with each set-point numbers the captures, whatever it is called."""
    found = guess(tmp_path, **{name: NUMBER})
    assert found.mapping["capture"] == {"column": name}
    assert observables(found) == ["force_N"]


@pytest.mark.parametrize("name", ["Lauf", "Versuch", "run", "rep_no"])
def test_a_session_holds_many_set_points(tmp_path: Path, name: str) -> None:
    """What is called a run or a repeat and is another at each set-point numbers captures, which is said; a day beside
    it is the session.
    """
    found = guess(tmp_path, **{name: NUMBER, "mounting": DAYS})
    assert found.mapping["capture"] == {"column": name}
    assert (found.mapping["session"], found.mapping.get("repeat")) == ({"column": "mounting"}, None)
    assert f"column {name!r} {TAKEN}" in found.remarks


def test_a_few_runs_of_one_hold_each_are_sessions(tmp_path: Path) -> None:
    """Five records of one hold each are sessions, where they are called so."""
    frame = pd.DataFrame({"t_s": np.arange(180), "run": np.repeat(np.arange(5), 36)})
    frame["p_set_kPa"], frame["force_N"] = np.repeat([10.0, 30, 20, 40, 15], 36), F
    frame.to_csv(tmp_path / "t.csv", index=False)
    assert guess_mapping(tmp_path / "t.csv").mapping["session"] == {"column": "run"}


def test_a_whole_number_that_was_measured_is_no_counter(tmp_path: Path) -> None:
    """Counts of an encoder, which go up and down, are a measurement."""
    found = guess(tmp_path, encoder=np.round(F * 7))
    assert observables(found) == ["force_N", "encoder"]


@pytest.mark.parametrize("name", ["set_no", "setpoint_nr", "cmd index"])
def test_the_number_of_what_is_set_is_no_command(tmp_path: Path, name: str) -> None:
    """What is called the number of a set-point and counts them is the capture beside inputs that are not called set."""
    frame = pd.DataFrame(
        {"t_s": np.arange(180) * 4.0, name: 1 + np.arange(180) // 3, "u1 (kPa)": P, "force_N": F}
    )
    frame.to_csv(tmp_path / "t.csv", index=False)
    mapping = guess_mapping(tmp_path / "t.csv").mapping
    assert mapping["capture"] == {"column": name}
    assert [entry["column"] for entry in mapping["actuation"]] == ["u1 (kPa)"]
    assert [entry["column"] for entry in mapping["observables"]] == ["force_N"]


def test_a_command_that_is_numbered_and_steps_up_by_more_is_one(tmp_path: Path) -> None:
    """What is called the first of several commands and goes up and down is commanded."""
    frame = pd.DataFrame({"t_s": np.arange(180) * 4.0, "set_no_1": P, "force_N": F})
    frame.to_csv(tmp_path / "t.csv", index=False)
    assert [entry["column"] for entry in guess_mapping(tmp_path / "t.csv").mapping["actuation"]] == [
        "set_no_1"
    ]
