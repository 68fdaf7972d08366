"""Columns whose names look like something that their numbers, or what stands beside them, say they are not."""

from pathlib import Path

import numpy as np
import pandas as pd
import pytest

from labrig import LabrigError
from labrig.log import Guess, guess_mapping, import_table

N = 60
T = np.arange(N) * 5.0
P = np.random.default_rng(4).choice([0.0, 10.0, 20.0, 30.0], N)
X = (0.2 * P + np.random.default_rng(5).normal(0, 0.05, N)).round(3)


def guess(folder: Path, columns: dict[str, object]) -> Guess:
    """The guess for a table of these columns."""
    pd.DataFrame(columns).to_csv(folder / "t.csv", index=False)
    return guess_mapping(folder / "t.csv")


def with_word(values: object, word: str) -> list[object]:
    """The values, with a word in the fourth row."""
    out = list(np.asarray(values, dtype=object))
    out[3] = word
    return out


@pytest.mark.parametrize("start", [45000.123456, 745000.12345])
def test_a_clock_of_a_computer_counts_seconds(tmp_path: Path, start: float) -> None:
    """Seconds since midnight, or since a computer was switched on, with many decimals, are no numbered days."""
    clock = start + 0.1 * np.arange(N)
    assert guess(tmp_path, {"time": clock, "p_set_kPa": P, "x_mm": X}).mapping["time"]["unit"] == "s"


@pytest.mark.parametrize("apart_s", [10.0, 60.0, 1800.0])
def test_a_spreadsheets_days_are_days_however_far_apart(tmp_path: Path, apart_s: float) -> None:
    """Rows that are whole seconds apart as days, and no round number as seconds, are days."""
    clock = (46000.25 + np.arange(N) * apart_s / 86400).round(7)
    assert guess(tmp_path, {"time": clock, "p_set_kPa": P, "x_mm": X}).mapping["time"]["unit"] == "excel days"


@pytest.mark.parametrize("name", ["exposure_time_ms", "cumulative_time_min", "settling_time_s"])
def test_a_time_of_something_else_is_no_gap_in_the_clock(tmp_path: Path, name: str) -> None:
    """What is called the time of something may be empty, or hold words, in some rows: rows are captures then."""
    rising = with_word(np.arange(N) * 2.0 + 1, "")
    assert "time" not in guess(tmp_path, {"p_set_kPa": P, "x_mm": X, name: rising}).mapping
    worded = with_word(np.arange(N) * 2.0 + 1, "timeout")
    assert (
        "time"
        not in guess(tmp_path, {"capture": np.arange(N), "p_set_kPa": P, "x_mm": X, name: worded}).mapping
    )


def test_a_gap_in_the_clock_says_what_to_do(tmp_path: Path) -> None:
    """The line, and that a mapping helps where it cannot be filled."""
    with pytest.raises(LabrigError, match=r"line 5: column 'time_s' .*: fill it, or write a mapping"):
        guess(tmp_path, {"time_s": with_word(T, ""), "p_set_kPa": P, "x_mm": X})


def test_another_clock_is_enough(tmp_path: Path) -> None:
    """A first column that rises evenly is the clock, also beside one that ends early."""
    early = np.where(np.arange(N) < 50, T + 3, np.nan)
    assert (
        guess(tmp_path, {"": T / 50, "p_set_kPa": P, "x_mm": X, "time": early}).mapping["time"]["column"]
        == "column.0"
    )


def test_a_label_called_set_is_no_command(tmp_path: Path) -> None:
    """Names of sets, one of them with a letter, are left out beside a pressure that is the input."""
    label = ["3b" if k // 6 == 3 else k // 6 for k in range(N)]
    found = guess(tmp_path, {"time_s": T, "p_kPa": P, "x_mm": X, "set": label})
    assert [entry["column"] for entry in found.mapping["actuation"]] == ["p_kPa"]
    with pytest.raises(LabrigError, match="'set_kPa' is called an input"):
        guess(
            tmp_path,
            {
                "time_s": T,
                "p_kPa": P,
                "x_mm": X,
                "set_kPa": ["oops" if k % 5 == 2 else v for k, v in enumerate(P)],
            },
        )


@pytest.mark.parametrize("name", ["p_abs_error_kPa", "p [kPa (a)]", "p_abs_kPa"])
def test_what_falls_to_nothing_is_no_absolute_pressure(tmp_path: Path, name: str) -> None:
    """An absolute error, chamber a, and a pressure that is 0 where the chamber is vented have no air taken off."""
    found = guess(tmp_path, {"time_s": T, name: P, "x_mm": X})
    assert all("offset" not in entry for entry in found.mapping["actuation"])


def test_a_name_that_ends_like_an_absolute_unit(tmp_path: Path) -> None:
    """The unit in the row of units counts: volts of a sensor called p_psia are volts."""
    rows = ["time,p_psia,x", "s,V,mm", *(f"{t},{p},{x}" for t, p, x in zip(T, P + 1, X, strict=True))]
    (tmp_path / "t.csv").write_text("\n".join(rows) + "\n", encoding="utf-8")
    (entry,) = guess_mapping(tmp_path / "t.csv").mapping["actuation"]
    assert (entry["unit"], "offset" in entry) == ("V", False)


def test_a_flag_behind_each_row(tmp_path: Path) -> None:
    """Words in a last cell that has no name do no harm; numbers there do, and R's way out is named."""
    rows = [f"{t},{p},{x}" for t, p, x in zip(T, P, X, strict=True)]
    head = "time_s,p_set_kPa,x_mm"
    (tmp_path / "t.csv").write_text(
        "\n".join([head, *(f"{row},OK" for row in rows)]) + "\n", encoding="utf-8"
    )
    assert [e["column"] for e in guess_mapping(tmp_path / "t.csv").mapping["observables"]] == ["x_mm"]
    numbered = [head, *(f"{i},{row}" for i, row in enumerate(rows))]
    (tmp_path / "t.csv").write_text("\n".join(numbered) + "\n", encoding="utf-8")
    with pytest.raises(LabrigError, match=r"has 4 cells under 3 names: .*row\.names=FALSE"):
        guess_mapping(tmp_path / "t.csv")


def test_an_absolute_error_is_no_absolute_pressure(tmp_path: Path) -> None:
    """What says how far a pressure is off is left as it is, also where it is never 0."""
    found = guess(tmp_path, {"time_s": T, "p_abs_error_kPa": P + 1, "x_mm": X})
    assert all("offset" not in entry for entry in found.mapping["actuation"])


@pytest.mark.parametrize("cell", ["", "late"])
def test_rows_that_are_numbered_need_no_clock(tmp_path: Path, cell: str) -> None:
    """A gap, or words, in the time of captures that have numbers is left out with a note."""
    clock = [cell if k % 5 == 2 else t for k, t in enumerate(T)]
    found = guess(tmp_path, {"capture": np.arange(N), "time_s": clock, "p_set_kPa": P, "x_mm": X})
    assert "time" not in found.mapping
    assert any("'time_s'" in line and "left out" in line for line in found.remarks)


@pytest.mark.parametrize(("least", "said"), [(0.0, 0), (101.3, 1)])
def test_a_mapping_that_takes_no_air_off_is_told(tmp_path: Path, least: float, said: int) -> None:
    """A pressure called absolute, mapped as it is, is said, unless it falls to 0 and so is none."""
    pd.DataFrame({"p_abs": P + least, "x": X}).to_csv(tmp_path / "t.csv", index=False)
    entries = (
        "actuation: [{column: p_abs, name: p, unit: kPa}]\nobservables: [{column: x, name: x, unit: mm}]\n"
    )
    (tmp_path / "map.yaml").write_text(f"table: t.csv\n{entries}", encoding="utf-8")
    run = import_table(tmp_path / "map.yaml", tmp_path / "run")
    assert sum("absolute pressure" in line for line in run.attrs["warnings"]) == said
