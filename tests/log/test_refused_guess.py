"""Mistakes in a table that nobody described are refused with their line, or said: a guess goes on over none."""

from pathlib import Path

import numpy as np
import pandas as pd
import pytest

from labrig import LabrigError
from labrig.log import guess_mapping, import_guessed

N = 40
P = np.repeat([10.0, 30.0, 20.0, 0.0], 10)
FORCE = 0.5 * P + 0.01 * np.arange(N)


@pytest.fixture(autouse=True)
def desk(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> Path:
    """The current folder of the test."""
    monkeypatch.chdir(tmp_path)
    return tmp_path


def write(name: str = "t.csv", **columns: object) -> Path:
    """A table of a clock, a pressure in four holds and a force, and whatever else is given."""
    frame = {"time_s": np.arange(N), "p_set_kPa": P, "force_N": FORCE.round(3), **columns}
    pd.DataFrame(frame).to_csv(name, index=False)
    return Path(name)


def with_words(values: object, words: dict[int, str]) -> list[str]:
    """Numbers as text, with words in some rows."""
    return [words.get(i, str(v)) for i, v in enumerate(np.asarray(values).tolist())]


@pytest.mark.parametrize("blank", ["", "NaN", "err"])
def test_a_clock_with_a_blank_is_refused(blank: str) -> None:
    """A gap in the clock is refused with its line, as with a mapping: rows are not taken for 1 s apart."""
    path = write(time_s=with_words(2 * np.arange(N), {17: blank, 30: blank}))
    with pytest.raises(LabrigError, match=r"line 19: column 'time_s' \(time\) is empty or NaN"):
        guess_mapping(path)


@pytest.mark.parametrize(("decimals", "cells"), [({"force_N"}, 4), ({"p_set_kPa", "force_N"}, 5)])
def test_decimal_commas_between_commas_are_refused(decimals: set[str], cells: int) -> None:
    """Commas in the numbers and between the cells make more cells than names: refused, with what may be the reason."""
    frame = pd.DataFrame({"time_s": np.arange(N), "p_set_kPa": P + 0.5, "force_N": FORCE.round(2) + 1.001})
    if "p_set_kPa" not in decimals:
        frame["p_set_kPa"] = P.astype(int)
    lines = [",".join(str(v).replace(".", ",") for v in row) for row in frame.to_numpy(dtype=object).tolist()]
    Path("t.csv").write_text("\n".join([",".join(frame.columns), *lines]) + "\n")
    with pytest.raises(
        LabrigError,
        match=rf"^t.csv, line 2: has {cells} cells under 3 names: if its decimal signs are commas",
    ):
        guess_mapping("t.csv")


def test_a_column_without_a_name_is_refused_where_it_is_filled() -> None:
    """Names that are one too few (of row names, of a date in two cells) stand over the wrong columns."""
    rows = "".join(
        f"2026-05-04 12:00:{i:02d} {p:g} {f:.2f}\n" for i, (p, f) in enumerate(zip(P, FORCE, strict=True))
    )
    Path("t.txt").write_text("time p_kPa force_N\n" + rows)
    with pytest.raises(
        LabrigError, match=r"^t.txt, line 2: has 4 cells under 3 names: .*; else give each column a name$"
    ):
        guess_mapping("t.txt")


def test_an_index_and_a_last_separator_are_no_such_cells() -> None:
    """What pandas writes of an index has an empty name, and a separator behind each row makes an empty cell."""
    frame = pd.DataFrame({"time_s": np.arange(N), "p_set_kPa": P, "force_N": FORCE})
    frame.to_csv("index.csv")
    text = frame.to_csv(index=False)
    Path("last.csv").write_text(text.replace("\n", ",\n").replace("force_N,", "force_N", 1))
    for name in ("index.csv", "last.csv"):
        mapping = guess_mapping(name).mapping
        assert [mapping["time"]["column"]] + [o["column"] for o in mapping["observables"]] == [
            "time_s",
            "force_N",
        ]


@pytest.mark.parametrize(
    ("column", "values", "said"),
    [
        (
            "time_s",
            np.arange(N),
            "column 'time_s' is called a time, and holds numbers, but in 4 of 40 cells words",
        ),
        (
            "p_set_kPa",
            P,
            "column 'p_set_kPa' is called an input, and holds numbers, but in 4 of 40 cells words",
        ),
        ("force_N", FORCE, "nothing is left that was measured and changes .* but in 4 of 40 cells words"),
    ],
)
def test_words_in_what_can_not_be_left_out_are_refused(column: str, values: object, said: str) -> None:
    """No other column takes the place of the clock, the command or the measurement because some of its cells hold
    words; beside others that were measured, such a column is left out, which is said.
    """
    given = {column: with_words(values, {3: "abc", 9: "abc", 20: "abc", 30: "abc"})}
    with pytest.raises(LabrigError, match=rf"^t.csv: {said}, first 'abc' in line 5 "):
        guess_mapping(write(room=21, pressure_supply_kPa=500.0, **given))
    other = guess_mapping(write(stretch_mm=2 * FORCE, status=with_words(P, {3: "abc", 9: "abc"})))
    assert [o["column"] for o in other.mapping["observables"]] == ["force_N", "stretch_mm"]
    assert any("column 'status' holds numbers, but in 2 of 40 cells words" in line for line in other.remarks)


@pytest.mark.parametrize(("word", "stands"), [("err", " ('err')"), ("#DIV/0!", " ('#DIV/0!')"), ("", "")])
def test_cells_without_a_number_are_counted(word: str, stands: str) -> None:
    """How many cells of what was measured hold no number is said, whatever stands there, and where the first is."""
    force = with_words(FORCE, dict.fromkeys(range(2, N, 3), word))
    room = with_words(21 + 0.01 * np.arange(N), {5: word})
    run, _, _ = import_guessed([write(force_N=force, room_degC=room)], Path("run"))
    said = "no number stands in 13 of 40 rows for observable force, in 1 for covariate room; first in line 4"
    assert f"t.csv: {said}{stands}" in run.attrs["import_remarks"]
    assert not any(
        "no number" in line for line in import_guessed([write()], Path("all"))[0].attrs["import_remarks"]
    )
