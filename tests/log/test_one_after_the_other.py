"""Recordings one after the other, in several files or in one: their order, and the time between them."""

from pathlib import Path

import numpy as np
import pandas as pd
import pytest

from labrig import LabrigError
from labrig.log import import_guessed

N = 40
P = np.repeat([10.0, 30.0, 20.0, 0.0], 10)


def write(name: str, start: str, form: str = "%d.%m.%Y %H:%M:%S.%f") -> Path:
    """A table of N rows, half a second apart from `start` on, with a pressure in four holds and a force."""
    clock = pd.Timestamp(start) + pd.to_timedelta(0.5 * np.arange(N), unit="s")
    frame = pd.DataFrame({"time": clock.strftime(form), "p1_kPa": P, "force_N": 0.5 * P + 1.0})
    frame.to_csv(name, index=False)
    return Path(name)


def test_files_that_are_named_in_another_order_than_they_were_recorded(desk: Path) -> None:
    """Sessions are in the order of their dates, with the time between them, whatever files are called; it is said."""
    days = {"run10.csv": "2026-05-04 11:00:00", "run2.csv": "2026-05-04 09:00:00"}
    tables = [write(name, day) for name, day in days.items()]
    run, _, _ = import_guessed(tables, Path("run"))
    assert list(dict.fromkeys(run["session"].to_numpy().tolist())) == ["run2", "run10"]
    assert float(run["time_s"][4, 0]) == pytest.approx(7200)
    said = "the files are in the order of their clocks, not as they were named: run2.csv is first"
    assert said in run.attrs["import_remarks"]


def test_files_on_both_sides_of_midnight(desk: Path) -> None:
    """A time of day without a date says no order: the files stay as they were named."""
    times = {"a.csv": "23:50:00", "b.csv": "00:05:00"}
    tables = [write(name, f"2026-05-04 {time}", "%H:%M:%S.%f") for name, time in times.items()]
    run, _, _ = import_guessed(tables, Path("run"))
    assert list(dict.fromkeys(run["session"].to_numpy().tolist())) == ["a", "b"]


def test_recordings_one_below_the_other(desk: Path) -> None:
    """Where a clock begins anew, nobody is told to sort by it: that would mix two recordings."""
    one = pd.read_csv(write("t.csv", "2026-05-04")).drop(columns="time")
    one.insert(0, "t_s", 0.5 * np.arange(N))
    both = pd.concat([one] * 2)
    both.to_csv("t.csv", index=False)
    with pytest.raises(
        LabrigError, match=r"line 42: time goes backward.*; its clock begins anew there, .*'session:'"
    ) as error:
        import_guessed([Path("t.csv")], Path("run"))
    assert "sort" not in str(error.value)
    both.assign(take=np.repeat([1, 2], N)).to_csv("t.csv", index=False)
    run, _, _ = import_guessed([Path("t.csv")], Path("run"), replace=True)
    assert len(set(run["session"].to_numpy().tolist())) == 2
