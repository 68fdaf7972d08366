"""Clocks of two files: by the dates in their rows or above their names, and by stamps that are a little late."""

from pathlib import Path

import numpy as np
import pandas as pd
import pytest

from labrig.log import import_guessed

N = 400
T = np.arange(N) * 0.05
P = np.repeat([0.0, 30, 10, 40, 20, 0, 50, 10], 50)
X = 60 + 0.4 * P + np.random.default_rng(5).normal(0, 0.02, N)
BEGAN = pd.Timestamp("2021-05-14 15:12:44.500")
HEADERS = {
    "qtm": "FREQUENCY\t20\nTIME_STAMP\t2021-05-14, 15:12:44.500\t5312.004\nDATA_INCLUDED\t3D\n",
    "motive": "Take Name,Take 2020-01-02 01.02.03 PM,Capture Start Time,2021-05-14 03.12.44.500 PM,Units,m\n",
    "lines": "Date;14.05.2021\nTime;15:12:44,5\n",
    "doubtful": "Recording started: 05/14/2021 15:12:44.5\n",
    "nothing": "Exported: 2021-05-14 18:00:00\n",
}


def camera(header: str = "", lead_s: float = 0.0) -> Path:
    """What a camera saw, which began some time before the commands."""
    time_s = T + lead_s
    rows = "".join(f"{t:.3f}\t{x:.3f}\n" for t, x in zip(time_s, X, strict=True))
    Path("camera.tsv").write_text(f"{header}Time (s)\ttip (mm)\n{rows}")
    return Path("camera.tsv")


def commands(began: pd.Timestamp = BEGAN, lead_s: float = 0.0, late_s: float = 0.0) -> Path:
    """What was commanded, by dates, from some time after a date on."""
    stamps = began + pd.to_timedelta(T + lead_s + late_s, unit="s")
    frame = pd.DataFrame({"time": stamps.strftime("%Y-%m-%d %H:%M:%S.%f"), "p_set_kPa": P})
    frame.to_csv("plc.csv", index=False)
    return Path("plc.csv")


@pytest.mark.parametrize("kind", ["qtm", "motive", "lines", "doubtful"])
def test_a_date_above_the_names(desk: Path, kind: str) -> None:
    """A camera that began 12 s before the commands, and says when, is not taken to begin with them."""
    run, guess, _ = import_guessed([camera(HEADERS[kind], 12.0), commands(lead_s=12.0)], Path("run"))
    assert guess.mapping["join"][0]["offset_s"] == pytest.approx(-BEGAN.timestamp(), abs=1e-3)
    assert run["commanded"].to_numpy().ravel().tolist() == P[::50].tolist()
    assert any("says that it began at 2021-05-14 15:12:44" in line for line in guess.remarks)
    assert not any("begin together" in line for line in guess.remarks)


@pytest.mark.parametrize("above", ["", "Logger: PLC\nStart time: 2021-05-14 15:12:56\n"])
def test_times_of_day_beside_a_date(desk: Path, above: str) -> None:
    """A log of times of day is on the day on which the camera says that it began."""
    frame = pd.DataFrame({"time": (BEGAN + pd.to_timedelta(T + 12, unit="s")).strftime("%H:%M:%S.%f")})
    with Path("plc.csv").open("w") as file:
        file.write(above)
        frame.assign(p_set_kPa=P).to_csv(file, index=False)
    run, guess, _ = import_guessed([camera(HEADERS["qtm"], 12.0), Path("plc.csv")], Path("run"))
    assert run["commanded"].to_numpy().ravel().tolist() == P[::50].tolist()
    assert any(
        "plc.csv has times of day in its rows: their clocks are joined by that" in r for r in guess.remarks
    )


def test_clocks_in_two_zones(desk: Path) -> None:
    """A log in UTC and a camera by the clock on the wall are joined where they then have their time in common."""
    tables = [camera(HEADERS["qtm"], 3.0), commands(BEGAN - pd.Timedelta(hours=2), 3.0)]
    run, guess, _ = import_guessed(tables, Path("run"))
    assert run["commanded"].to_numpy().ravel().tolist() == P[::50].tolist()
    assert any("in zones that are 2 h apart" in line for line in guess.remarks)


def test_dates_without_a_common_time(desk: Path) -> None:
    """Dates that have no time in common join nothing: that is said, and both are taken to begin together."""
    run, guess, _ = import_guessed(
        [camera(HEADERS["qtm"]), commands(BEGAN + pd.Timedelta(days=3))], Path("run")
    )
    assert run["commanded"].to_numpy().ravel().tolist() == P[::50].tolist()
    assert any("these have no time in common" in line for line in guess.remarks)
    assert any("begin together" in line for line in guess.remarks)


def test_a_date_in_one_file_only(desk: Path) -> None:
    """Where one file says when it began and the other does not, both clocks are taken for one, and that is said."""
    pd.DataFrame({"t_s": T, "p_set_kPa": P}).to_csv("plc.csv", index=False)
    _, guess, _ = import_guessed([camera(HEADERS["qtm"]), Path("plc.csv")], Path("run"))
    assert "offset_s" not in guess.mapping["join"][0]
    assert any("and nothing says when plc.csv did: both clocks are taken for one" in r for r in guess.remarks)


def test_when_a_file_was_exported_says_nothing(desk: Path) -> None:
    """The date of an export is no beginning: without another one both are taken to begin together."""
    _, guess, _ = import_guessed([camera(HEADERS["nothing"]), commands()], Path("run"))
    assert any("begin together" in line for line in guess.remarks)


def test_stamps_that_are_a_little_late(desk: Path) -> None:
    """A log whose stamps are less than a millisecond after the frames does not delay its command by a whole frame."""
    late_s = np.random.default_rng(1).uniform(2e-4, 9e-4, N)
    stamps = BEGAN + pd.to_timedelta(T + late_s, unit="s")
    pd.DataFrame({"time": stamps.strftime("%Y-%m-%d %H:%M:%S.%f"), "p_set_kPa": P}).to_csv(
        "plc.csv", index=False
    )
    run, _, _ = import_guessed([camera(HEADERS["qtm"]), Path("plc.csv")], Path("run"))
    assert run.sizes["time"] == 50
    first = run["observed"].isel(time=0).to_numpy().ravel()
    assert first == pytest.approx(60 + 0.4 * P[::50], abs=0.2)


def test_a_command_that_was_set_just_after_a_measurement(desk: Path) -> None:
    """A command that is written when it is set is not that of the row a moment before."""
    p = [0.0, 52.5, 10.0, 81.0, 33.0, 64.5, 20.0, 90.0, 5.0, 71.0]
    set_s = 10.0 * np.arange(10)
    seen_s = (set_s[:, None] + [4.0, 9.99]).ravel()
    pd.DataFrame({"t [s]": set_s, "p_set [kPa]": p}).to_csv("set.csv", index=False)
    pd.DataFrame({"t [s]": seen_s, "F [N]": np.repeat(p, 2) / 9}).to_csv("seen.csv", index=False)
    run, _, _ = import_guessed([Path("set.csv"), Path("seen.csv")], Path("run"))
    assert run["commanded"].to_numpy().ravel().tolist() == p
