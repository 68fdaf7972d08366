"""Clocks as instruments write them: dates, times of day, durations, several columns, rows that are counted."""

import datetime
from pathlib import Path
from typing import Any

import numpy as np
import pandas as pd
import pytest
import yaml

import labrig
from labrig import LabrigError
from labrig.log import guess_mapping, import_guessed, import_table

STEP_S = 0.5
N = 40
T = STEP_S * np.arange(N)
P = np.repeat([10.0, 30.0, 20.0, 0.0], 10)


@pytest.fixture(autouse=True)
def desk(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> Path:
    """The current folder of the test."""
    monkeypatch.chdir(tmp_path)
    return tmp_path


def stamps(form: str, start: str, step_s: float = STEP_S) -> list[str]:
    """The times of N rows from `start` on, as `strftime` and then with three digits behind the seconds at ``%%``."""
    begin = datetime.datetime.fromisoformat(start)
    each = [begin + datetime.timedelta(seconds=step_s * i) for i in range(N)]
    return [f"{t.strftime(form)}".replace("~", f"{t.microsecond // 1000:03d}") for t in each]


def write(clock: dict[str, Any], name: str = "t.csv", **options: Any) -> Path:
    """A table of a clock, a pressure in four holds and a force."""
    pd.DataFrame({**clock, "p1_kPa": P, "force_N": 0.5 * P + 1.0}).to_csv(name, index=False, **options)
    return Path(name)


def mapped(time: dict[str, Any], *others: str, **more: Any) -> Any:
    """The run of ``t.csv`` (and others) by a mapping that says its clock."""
    content = {
        "table": ["t.csv", *others],
        "time": time,
        "capture": {"per": "segment"},
        "actuation": [{"column": "p1_kPa", "name": "p1", "unit": "kPa"}],
        "observables": [{"column": "force_N", "name": "force", "unit": "N"}],
        **more,
    }
    Path("map.yaml").write_text(yaml.safe_dump(content), encoding="utf-8")
    return import_table(Path("map.yaml"), Path("mapped"))


def times(run: Any) -> Any:
    """The time of each row of a run, s."""
    found = run["time_s"].to_numpy()
    return np.sort(found[np.isfinite(found)])


def guessed(path: Path) -> tuple[Any, Any, list[str]]:
    """The run by a guess alone, its clock and what was remarked."""
    run, guess, written = import_guessed([path], Path("run"))
    again = import_table(written, Path("again"))
    np.testing.assert_array_equal(times(again), times(run))
    return run, guess.mapping.get("time"), [*guess.remarks, *run.attrs.get("import_remarks", [])]


CELLS: dict[str, tuple[list[str], dict[str, Any]]] = {
    "dotted": (stamps("%d.%m.%Y %H:%M:%S.~", "2026-05-04 23:59:50"), {"unit": "date"}),
    "dotted, two digits": (stamps("%d.%m.%y %H:%M:%S,~", "2026-05-04 23:59:50"), {"unit": "date"}),
    "ISO": (stamps("%Y-%m-%d %H:%M:%S.~", "2026-05-04 23:59:50"), {"unit": "date"}),
    "zone": (stamps("%Y-%m-%dT%H:%M:%S.~+02:00", "2026-05-04 23:59:50"), {"unit": "date"}),
    "day first": (stamps("%d/%m/%Y %H:%M:%S.~", "2026-05-04 23:59:50"), {"unit": "date", "day_first": True}),
    "day first, back": (
        stamps("%d/%m/%Y %H:%M:%S.~", "2026-11-12 23:59:50"),
        {"unit": "date", "day_first": True},
    ),
    "month first": (
        stamps("%m/%d/%Y %I:%M:%S.~ %p", "2026-05-04 23:59:50"),
        {"unit": "date", "day_first": False},
    ),
    "no order": (stamps("%m/%d/%Y %H:%M:%S.~", "2026-05-04 13:05:02"), {"unit": "date"}),
    "name of month": (stamps("%d-%b-%Y %H:%M:%S.~", "2026-11-26 13:05:02"), {"unit": "date"}),
    "compact": (stamps("%Y%m%dT%H%M%S.~", "2026-11-26 23:59:50"), {"unit": "date"}),
    "underscores": (stamps("%Y_%m_%d_%H_%M_%S.~", "2026-11-26 23:59:50"), {"unit": "date"}),
    "as in a file's name": (stamps("%Y-%m-%d_%H-%M-%S.~", "2026-11-26 23:59:50"), {"unit": "date"}),
    "time of day": (stamps("%H:%M:%S.~", "2026-11-26 23:59:50"), {"unit": "date"}),
    "morning and evening": (stamps("%I:%M:%S.~ %p", "2026-11-26 23:59:50"), {"unit": "date"}),
    "colon": (stamps("%H:%M:%S:~", "2026-11-26 13:05:02"), {"unit": "date"}),
    "hundredths": ([f"0:00:{int(t):02d}:{100 * (t % 1):02.0f}" for t in 1.4 * T], {"unit": "date"}),
    "minutes": ([f"{int(t) // 60}:{t % 60:04.1f}" for t in 50.0 + T], {"unit": "min:s"}),
    "over a day": (
        [f"{30 + i // 7200}:{i // 120 % 60:02d}:{i % 120 / 2:04.1f}" for i in range(N)],
        {"unit": "date"},
    ),
    "sec": ([f"{t:g} sec" for t in T], {"unit": "date"}),
    "s": ([f"{t:g}s" for t in T], {"unit": "date"}),
    "days": ([f"1 days 00:00:{t:04.1f}" for t in T], {"unit": "date"}),
}


@pytest.mark.parametrize("name", list(CELLS))
def test_one_column_of_text(name: str) -> None:
    """A row each half second, in whichever way it is written; a mapping with `unit: date` reads the same."""
    cells, said = CELLS[name]
    step = 1.4 if name == "hundredths" else 1.0
    run, time, _ = guessed(write({"time": cells}))
    assert times(run) == pytest.approx(step * T, abs=1e-5)
    assert time == {"column": "time", **said}
    assert times(mapped({"column": "time", "unit": "date"})) == pytest.approx(step * T, abs=1e-5)


def test_an_order_of_dates_that_is_not_known_is_said() -> None:
    """Within one day month first and day first do alike: month first is taken, and a mapping can say it is not."""
    early = [f"04/05/2026 00:00:{t:04.1f}" for t in T[:20]]
    late = [f"05/05/2026 00:00:{t:04.1f}" for t in T[:20]]
    _, _, remarks = guessed(write({"time": stamps("%m/%d/%Y %H:%M:%S.~", "2026-05-04 13:05:02")}))
    assert "dates such as '05/04/2026' are read month first: write 'day_first: true' if not" in remarks
    write({"time": early + late})
    run = mapped({"column": "time", "unit": "date", "day_first": False})
    assert times(run)[20] == pytest.approx(30 * 86400.0, abs=1e-5)


def test_minutes_and_seconds() -> None:
    """Whole minutes and seconds are told by the header, by repeats from 0 on, or by the mapping, else remarked on."""
    whole = [f"{int(t) // 60}:{int(t) % 60:02d}" for t in T]
    assert guess_mapping(write({"Elapsed (mm:ss)": whole})).mapping["time"]["unit"] == "min:s"
    guess = guess_mapping(write({"time": whole}))
    assert guess.mapping["time"]["unit"] == "min:s"
    assert "times such as '0:19' repeat: taken as minutes and seconds" in guess.remarks
    guess = guess_mapping(write({"time": [f"1:{i:02d}" for i in range(N)]}))
    assert guess.mapping["time"]["unit"] == "date"
    assert any("taken as hours and minutes" in remark for remark in guess.remarks)
    assert times(mapped({"column": "time", "unit": "date"}))[1] == pytest.approx(60.0)
    labrig.import_table(Path("map.yaml"), Path("mapped"), replace=True)
    text = Path("map.yaml").read_text().replace("unit: date", "unit: min:s")
    Path("map.yaml").write_text(text)
    assert times(import_table(Path("map.yaml"), Path("other")))[1] == pytest.approx(1.0)


def test_midnight_and_summer_time() -> None:
    """A time of day goes on past midnight, with a remark; a date that goes back an hour is an error."""
    _, _, remarks = guessed(write({"time": CELLS["time of day"][0]}))
    assert any("t.csv, line 22: the time of day passes midnight" in remark for remark in remarks)
    before = stamps("%Y-%m-%d %H:%M:%S.~", "2026-10-25 02:59:50")[:20]
    back = stamps("%Y-%m-%d %H:%M:%S.~", "2026-10-25 01:59:50")[20:]
    write({"time": before + back})
    with pytest.raises(
        LabrigError,
        match=r"line 22: time goes backward.*about an hour, .* end of summer time: write .* offset",
    ):
        mapped({"column": "time", "unit": "date"})
    ahead = stamps("%Y-%m-%d %H:%M:%S.~", "2026-10-25 03:59:50")[20:]
    write({"time": before + ahead})
    remarks = mapped({"column": "time", "unit": "date"}).attrs["import_remarks"]
    assert any("line 22: an hour is missing in the time" in remark for remark in remarks)


@pytest.mark.parametrize(
    ("day", "zone", "said"),
    [
        ("2025-03-30", "", True),
        ("2025-03-09", "", True),
        ("2025-10-05", "", True),
        ("2025-03-23", "", False),
        ("2025-03-30", "+00:00", False),
    ],
)
def test_the_begin_of_summer_time_in_a_pause(day: str, zone: str, said: bool) -> None:
    """A local clock that jumps over the hour which a day of change leaves out is said to, once, however long it is."""
    before = stamps("%Y-%m-%d %H:%M:%S.~", f"{day} 01:59:50")[:20]
    after = stamps("%Y-%m-%d %H:%M:%S.~", f"{day} 03:09:50")[20:]
    write({"time": [text + zone for text in before + after]})
    remarks = mapped({"column": "time", "unit": "date"}).attrs["import_remarks"]
    assert sum("hour" in remark for remark in remarks) == int(said)
    assert any("line 22: time goes ahead over the hour" in remark for remark in remarks) == said


def test_the_end_of_summer_time_between_two_holds() -> None:
    """It is seen where the rows beside it are as far apart as others of the record are; a counter has no summer time,
    and dates are no counter of 32 bits.
    """
    t = np.cumsum(np.tile([30.0] * 9 + [210.0], 4))
    back = np.where(np.arange(N) < 30, t, t - 3600.0)
    dates = pd.Timestamp("2026-10-25 02:35:50") + pd.to_timedelta(back, unit="s")
    days = (dates - pd.Timestamp("1899-12-30")) / pd.Timedelta(days=1)
    for cells, unit, dated in (
        (dates.astype(str), "date", True),
        (days, "excel days", True),
        (back, "s", False),
    ):
        write({"time": list(cells)})
        with pytest.raises(LabrigError, match="line 32: time goes backward") as error:
            mapped({"column": "time", "unit": unit})
        assert ("end of summer time" in str(error.value)) == dated
        assert "32 bits" not in str(error.value)
    zoned = pd.DatetimeIndex(dates).tz_localize("Europe/Berlin", ambiguous=np.arange(N) < 30)
    write({"time": list(zoned.astype(str))})
    assert np.diff(times(mapped({"column": "time", "unit": "date"}))) == pytest.approx(np.diff(t))


SECOND = (T // 1).astype(int)
SEVERAL: dict[str, tuple[dict[str, Any], list[str], Any]] = {
    "ROS": (
        {"h.stamp.sec": 1795698302 + SECOND, "h.stamp.nanosec": (T % 1 * 1e9).astype(int)},
        ["h.stamp.sec", "h.stamp.nanosec"],
        ["s", "ns"],
    ),
    "milliseconds": (
        {"Time": stamps("%H:%M:%S", "2026-11-26 13:05:02"), "Milliseconds": (T % 1 * 1e3).astype(int)},
        ["Time", "Milliseconds"],
        ["date", "ms"],
    ),
    "date and time": (
        {
            "Date": stamps("%d.%m.%Y", "2026-05-04 23:59:50"),
            "Time": stamps("%H:%M:%S.~", "2026-05-04 23:59:50"),
        },
        ["Date", "Time"],
        "date",
    ),
    "six": (
        {
            "Year": [2026] * N,
            "Month": [5] * N,
            "Day": [4] * N,
            "Hour": [9] * N,
            "Minute": [7] * N,
            "Second": T,
        },
        ["Year", "Month", "Day", "Hour", "Minute", "Second"],
        "date",
    ),
}


@pytest.mark.parametrize("name", list(SEVERAL))
def test_a_clock_in_several_columns(name: str) -> None:
    """Parts of a time are added, and none of them is taken for a measurement."""
    columns, keys, unit = SEVERAL[name]
    run, time, _ = guessed(write(columns))
    assert times(run) == pytest.approx(T, abs=1e-5)
    assert time == {"column": keys, "unit": unit}
    assert run["observable"].to_numpy().tolist() == ["force"]


def test_cells_of_workbooks() -> None:
    """Times of day, spans of time, and a date beside a time, as Excel has them."""
    from openpyxl import Workbook

    begin = datetime.datetime(2026, 5, 4, 13, 5, 2)
    each = [begin + datetime.timedelta(seconds=t) for t in T]
    clocks: list[dict[str, Any]] = [
        {"Time": [t.time() for t in each]},
        {"Elapsed": [datetime.timedelta(hours=25, seconds=t) for t in T]},
        {"Date": [datetime.datetime(2026, 5, 4)] * N, "Time": [t.time() for t in each]},
    ]
    for i, clock in enumerate(clocks):
        book = Workbook()
        sheet: Any = book.active
        sheet.append([*clock, "p1_kPa", "force_N"])
        for row in zip(*clock.values(), P, P + 1.0, strict=True):
            sheet.append(row)
        for cell in sheet["A"][1:]:
            cell.number_format = "[h]:mm:ss.000" if "Elapsed" in clock else cell.number_format
        book.save(f"t{i}.xlsx")
        run, guess, _ = import_guessed([Path(f"t{i}.xlsx")], Path(f"run{i}"))
        assert times(run) == pytest.approx(T, abs=1e-5)
        assert guess.mapping["time"]["unit"] == "date"


def test_rows_that_are_counted() -> None:
    """A rate without a column: row i is at i / rate, in the table and in a joined file."""
    write({"number": range(N)})
    pd.DataFrame({"x": np.arange(2.0 * N)}).to_csv("cam.csv", index=False)
    run = mapped(
        {"rate_hz": 2},
        join=[{"name": "cam", "file": "cam.csv", "time": {"rate_hz": 4}}],
        observables=[{"column": "cam.x", "name": "x", "unit": "mm"}],
    )
    assert times(run) == pytest.approx(T)
    assert run["observed"].to_numpy().ravel() == pytest.approx(2.0 * np.arange(N))


@pytest.mark.parametrize(
    ("column", "numbers", "unit"),
    [
        ("Date", 46352.5 + T / 86400, "excel days"),
        ("time", 740311.5 + T / 86400, "datenum"),
        ("Ticks", 639000000000000000 + (T * 1e7).astype(np.int64), "ticks"),
        ("time", 46352.5 + T, "s"),
        ("time", 46352.5 + 20 * T + 1e-4 * np.sin(T), "s"),
    ],
)
def test_numbers_that_are_dates(column: str, numbers: Any, unit: str) -> None:
    """Days of Excel and of MATLAB and ticks of .NET are known by their size; seconds of that size stay seconds, with
    few decimals or over more than a month.
    """
    run, time, remarks = guessed(write({column: numbers}))
    assert times(run) == pytest.approx(T if unit != "s" else numbers - numbers[0], abs=1e-4)
    assert time == {"column": column, "unit": unit}
    assert f"the unit of the time {column!r} is not said: taken as {unit}" in remarks


@pytest.mark.parametrize("step_s", [8.0, 10.0, 60.0, 3600.0])
@pytest.mark.parametrize(("first", "unit"), [(45637.5, "excel days"), (740311.5, "datenum")])
def test_numbered_days_may_be_far_apart(first: float, unit: str, step_s: float) -> None:
    """Days are days however far apart the rows are, as a program writes them; a name that says seconds is believed."""
    days = first + np.round(step_s * np.arange(N) / 86400, 8)
    run, time, _ = guessed(write({"time": days}))
    assert time["unit"] == unit
    assert times(run) == pytest.approx(step_s * np.arange(N), abs=1e-3)
    assert guess_mapping(write({"time_s": days})).mapping["time"]["unit"] == "s"


@pytest.mark.parametrize(("unit", "number"), [("excel days", 46146.5), ("datenum", 740106.5)])
def test_numbered_days_are_dates(unit: str, number: float) -> None:
    """Days that are numbered are joined to dates that are written: noon of 4 May 2026 in each."""
    write({"day": number + T / 86400})
    other = pd.DataFrame({"time": stamps("%Y-%m-%d %H:%M:%S.~", "2026-05-04 12:00:00"), "x": T})
    other.to_csv("cam.csv", index=False)
    run = mapped(
        {"column": "day", "unit": unit},
        join=[
            {"name": "cam", "file": "cam.csv", "time": {"column": "time", "unit": "date"}, "within_s": 0.01}
        ],
        observables=[{"column": "cam.x", "name": "x", "unit": "mm"}],
    )
    assert run["observed"].to_numpy().ravel()[1:-1] == pytest.approx(T[1:-1], abs=1e-3)


def test_clocks_that_run_backward() -> None:
    """The newest row first is refused by the guess and by a mapping; a counter that began anew is named."""
    for clock in ({"time_s": T[::-1]}, {"time": CELLS["ISO"][0][::-1]}):
        with pytest.raises(LabrigError, match="runs backward through the whole file; sort its rows by time"):
            guess_mapping(write(clock))
    with pytest.raises(LabrigError, match="backward within session 't'; it runs backward through the whole"):
        mapped({"column": "time", "unit": "date"})
    write({"millis": (4294960000 + 500 * np.arange(N)) % 2**32})
    with pytest.raises(
        LabrigError, match=r"line 17: time goes backward.*32 bits began anew at 4294967295 ms"
    ):
        mapped({"column": "millis", "unit": "ms"})


def test_what_can_not_be_read() -> None:
    """Frames in a time code, a cell that is no time, and a clock that says nothing, in one line each."""
    write({"time": [f"0:00:{i // 25:02d}:{i % 25:02d}" for i in range(N)]})
    with pytest.raises(LabrigError, match=r"'0:00:01:14'.*frames or in hundredths of a second is not known"):
        mapped({"column": "time", "unit": "date"})
    write({"time": [*CELLS["time of day"][0][:-1], "later"]})
    with pytest.raises(LabrigError, match=r"line 41: column 'time' \(time\) holds 'later', not a date"):
        mapped({"column": "time", "unit": "date"})
    for wrong, complaint in (
        ({"unit": "s"}, "time: name the column of the clock, or the rate_hz of the rows"),
        ({"column": ["a", "b"], "unit": ["s"]}, "time: give one unit, or one for each column"),
        ({"column": ["a", "b"], "rate_hz": 2}, "time: frames at a rate_hz are counted in one column"),
        ({"column": [], "unit": []}, "time: name at least one column"),
    ):
        with pytest.raises(LabrigError, match=complaint):
            mapped(wrong)


@pytest.mark.parametrize("kind", ["dates", "seconds", "rows"])
def test_parquet_with_its_time_in_the_index(kind: str) -> None:
    """An index without a name is the time, unless it numbers the rows."""
    index: Any = {
        "dates": pd.Timestamp("2026-05-04") + pd.to_timedelta(T, unit="s"),
        "seconds": pd.Index(T),
        "rows": pd.Index(np.arange(N) + 7),
    }[kind]
    pd.DataFrame({"p1_kPa": P, "force_N": P + 1.0}, index=index).to_parquet("t.parquet")
    guess = guess_mapping(Path("t.parquet"))
    said = {
        "dates": {"column": "time", "unit": "date"},
        "seconds": {"column": "time", "unit": "s"},
        "rows": None,
    }
    assert guess.mapping.get("time") == said[kind]


def test_a_session_that_is_a_date_is_no_clock() -> None:
    """Dates in a column called a session number the sessions; the clock is the time beside it."""
    days = ["2026-05-04"] * 20 + ["2026-05-05"] * 20
    cells = CELLS["time of day"][0][:20]
    guess = guess_mapping(write({"session": days, "time": cells + cells}))
    assert guess.mapping["time"] == {"column": "time", "unit": "date"}
    assert guess.mapping["session"] == {"column": "session"}


def test_a_time_of_day_as_a_share_of_it(desk: Path) -> None:
    """A sheet's cells of times, saved as plain numbers (0.3333 is 8 o'clock), are days and not some us."""
    run, guess, _ = import_guessed([write({"Time": 1 / 3 + T / 86400})], Path("run"))
    assert guess.mapping["time"] == {"column": "Time", "unit": "day"}
    assert "the unit of the time 'Time' is not said: taken as day" in guess.remarks
    assert np.nanmax(run["time_s"].to_numpy()) == pytest.approx(T[-1], abs=1e-3)
