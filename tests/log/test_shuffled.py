"""Tables whose rows are not in the order of their time."""

from pathlib import Path

import numpy as np
import pandas as pd
import pytest

from labrig import LabrigError
from labrig.log import import_guessed, import_table

HOLDS, READ = 30, 3


def _table() -> pd.DataFrame:
    """Holds of different lengths at random pressures, each read three times."""
    random = np.random.default_rng(0)
    length = random.choice([4.0, 8.0, 20.0], HOLDS)
    begin = np.cumsum(length) - length
    p = np.repeat(random.uniform(5, 100, (HOLDS, 2)).round(2), READ, axis=0)
    share = np.tile([0.3, 0.6, 0.9], HOLDS)
    time_s = (np.repeat(begin, READ) + share * np.repeat(length, READ)).round(2)
    z = (0.2 * p[:, 0] + 0.1 * p[:, 1] + random.normal(0, 0.02, HOLDS * READ)).round(4)
    return pd.DataFrame({"t_s": time_s, "p1_kPa": p[:, 0], "p2_kPa": p[:, 1], "z_mm": z})


def _shuffled(table: pd.DataFrame) -> pd.DataFrame:
    return table.sample(frac=1, random_state=1)


def _written(table: pd.DataFrame, path: Path) -> Path:
    table.to_csv(path, index=False)
    return path


def _same(one, other) -> bool:
    return all(
        np.array_equal(one[v].values, other[v].values, equal_nan=True) for v in ("observed", "commanded")
    )


@pytest.mark.parametrize("dated", [False, True])
def test_shuffled_rows_are_sorted_by_time_and_it_is_said(tmp_path, dated):
    """Rows that are merely shuffled make the same run as sorted ones, with a note, and again by the mapping."""
    table = _table()
    if dated:
        table["t_s"] = pd.to_datetime("2026-05-04 10:00") + pd.to_timedelta(table["t_s"].to_numpy(), unit="s")
        table = table.rename(columns={"t_s": "when"})
    right, *_ = import_guessed([_written(table, tmp_path / "right.csv")], tmp_path / "right")
    run, guess, path = import_guessed([_written(_shuffled(table), tmp_path / "t.csv")], tmp_path / "run")
    assert any("sorted by time" in line for line in guess.remarks)
    assert _same(run, right)
    import_table(path, tmp_path / "again")
    assert (tmp_path / "again").is_dir()


@pytest.mark.parametrize("change", ["twice", "captures", "sessions", "nothing goes on"])
def test_rows_that_cannot_be_sorted_safely_are_refused(tmp_path, change):
    """Where sorting by time may be wrong, one line says to sort by time, and there is no run."""
    table = _table()
    if change == "twice":
        table.loc[1, "t_s"] = table.loc[0, "t_s"]
    elif change == "captures":
        table["capture"] = np.arange(len(table)) % HOLDS
    elif change == "sessions":
        table["session"] = np.where(np.arange(len(table)) % 2, "a", "b")
    else:
        table = table.iloc[::READ]
    path = _written(_shuffled(table), tmp_path / "t.csv")
    with pytest.raises(LabrigError, match=r"'t_s' goes back and forth; sort the rows by time") as refused:
        import_guessed([path], tmp_path / "run")
    assert "\n" not in str(refused.value)
    assert not (tmp_path / "run").exists()


def test_a_clock_that_begins_again_is_not_sorted(tmp_path):
    """Sessions whose clocks begin again are sessions still, one after the other."""
    table = pd.concat([_table().assign(session=name) for name in ("a", "b", "c")])
    run, guess, _ = import_guessed([_written(table, tmp_path / "t.csv")], tmp_path / "run")
    assert guess.mapping["time"] == {"column": "t_s", "unit": "s"}
    assert len(set(run["session"].values.tolist())) == 3


def test_a_time_that_is_left_out_is_no_observable(tmp_path):
    """The time within each hold, called a time, is left out as the note says, and is not taken for measured."""
    table = _table()
    table["t_s"] = np.tile([1.0, 2.0, 3.0], HOLDS)
    _, guess, _ = import_guessed([_written(table, tmp_path / "t.csv")], tmp_path / "run")
    assert any("'t_s' is called a time but goes back: left out" in line for line in guess.remarks)
    assert [o["column"] for o in guess.mapping["observables"]] == ["z_mm"]


@pytest.mark.parametrize("capture", [False, True])
def test_a_mapping_of_shuffled_rows_is_refused_with_what_to_do(tmp_path, capture):
    """With a mapping, time that goes back is refused with the advice to sort by time, which `sort: true` does."""
    table = _table().assign(n=np.repeat(np.arange(HOLDS), READ))
    _written(_shuffled(table), tmp_path / "t.csv")
    rest = (
        "actuation: [{column: p1_kPa, name: p1, unit: kPa}]\n"
        "observables: [{column: z_mm, name: z, unit: mm}]\n"
    ) + ("capture: {column: n}\n" if capture else "")
    mapping = tmp_path / "map.yaml"
    mapping.write_text("table: t.csv\ntime: {column: t_s, unit: s}\n" + rest)
    with pytest.raises(LabrigError, match=r"line \d+: .*sort them by time: 'sort: true' under 'time:'"):
        import_table(mapping, tmp_path / "run")
    mapping.write_text("table: t.csv\ntime: {column: t_s, unit: s, sort: true}\n" + rest)
    run = import_table(mapping, tmp_path / "run")
    assert len(run["capture"]) == (HOLDS if capture else HOLDS * READ)


def test_a_complaint_about_sorted_rows_names_the_line_of_the_file(tmp_path):
    """After sorting, a mistake is still named by its line in the file."""
    table = _shuffled(_table().astype({"p1_kPa": object}))
    table.iloc[4, 1] = "oops"
    _written(table, tmp_path / "t.csv")
    mapping = tmp_path / "map.yaml"
    mapping.write_text(
        "table: t.csv\ntime: {column: t_s, unit: s, sort: true}\n"
        "actuation: [{column: p1_kPa, name: p1, unit: kPa}]\nobservables: [{column: z_mm, name: z, unit: mm}]\n"
    )
    with pytest.raises(LabrigError, match="line 6: column 'p1_kPa'"):
        import_table(mapping, tmp_path / "run")
