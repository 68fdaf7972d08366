"""Tables without a clock, whose first lines say how many rows a second they have."""

from pathlib import Path

import numpy as np
import pytest

from labrig.log import guess_mapping, import_guessed

P = np.repeat([10.0, 30.0, 20.0, 40.0, 0.0, 25.0], 10)
NO_CLOCK = "no column is a time: rows are taken as 1 s apart; say so under 'time:' if not"


def write(path: str, above: list[str], names: str, separator: str = ",", frame: bool = False) -> None:
    """Write a table of 60 rows below some lines: perhaps a counter, a pressure, a length, a force."""
    rows = [
        separator.join([*([f"{i + 1}"] if frame else []), f"{p:.1f}", f"{12 + 0.1 * p:.3f}", f"{2 * p:.2f}"])
        for i, p in enumerate(P)
    ]
    Path(path).write_text("\n".join([*above, names.replace(",", separator), *rows]) + "\n")


@pytest.mark.parametrize(
    ("above", "rate_hz", "line"),
    [
        (["NO_OF_FRAMES\t60", "FREQUENCY\t50", "DATA_INCLUDED\t3D"], 50.0, 2),
        (["# Logger 3", "# Sample Rate: 20 Hz"], 20.0, 2),
        (["Device;X", "Sampling interval [ms];50"], 20.0, 2),
        (["sampling frequency = 1.5 kHz"], 1500.0, 1),
        (["Capture Frame Rate,200.0,Export Frame Rate,100.0"], 100.0, 1),
    ],
)
def test_the_rate_above_the_names_is_the_clock(
    desk: Path, above: list[str], rate_hz: float, line: int
) -> None:
    """A frequency, a rate or an interval, with its unit in its own place: what was exported, of several."""
    separator = next((s for s in "\t;" if any(s in one for one in above)), ",")
    write("t.txt", above, "p_kPa,x_mm,f_N", separator)
    run, guess, _ = import_guessed([Path("t.txt")], Path("run"))
    assert guess.mapping["time"] == {"rate_hz": rate_hz}
    assert f"no column is a time: {rate_hz:g} rows a second, as line {line} says" in guess.remarks
    assert NO_CLOCK not in guess.remarks
    assert run["time_s"].to_numpy().ravel() == pytest.approx(np.arange(60) / rate_hz)


def test_frames_that_are_counted_at_a_rate_that_is_said(desk: Path) -> None:
    """Of an export of Nexus the second line is the rate of its frames, not a row of numbers."""
    write("t.csv", ["Trajectories", "100", ",,Arm:tip,"], "Frame,p_kPa,x_mm,f_N", frame=True)
    run, guess, _ = import_guessed([Path("t.csv")], Path("run"))
    assert guess.mapping["time"] == {"column": "Frame", "rate_hz": 100.0}
    assert guess.remarks == ["'Frame' counts 100 rows a second, as line 2 says"]
    assert np.ptp(run["time_s"].to_numpy()) == pytest.approx(0.59)


def test_frames_are_joined_by_their_rate(desk: Path) -> None:
    """A take without a clock stands beside a log of pressures that has one."""
    rows = "\n".join(f"{0.1 * i:.1f},{p:.0f}" for i, p in enumerate(P))
    Path("rig.csv").write_text(f"t_s,p_set_kPa\n{rows}\n")
    take = "\n".join(f"{i + 1},{12 + 0.1 * P[i // 10]:.3f},{P[i // 10] / 50:.3f}" for i in range(600))
    Path("take.csv").write_text(f"Trajectories\n100\nFrame,tip X,tip Y\n,mm,mm\n{take}\n")
    run, guess, _ = import_guessed([Path("rig.csv"), Path("take.csv")], Path("run"))
    assert guess.mapping["time"] == {"column": "Frame", "rate_hz": 100.0}
    assert guess.mapping["join"][0]["time"] == {"column": "t_s", "unit": "s"}
    assert run["commanded"].to_numpy()[:, 0] == pytest.approx(P[::10])


@pytest.mark.parametrize("above", [["rate of turn: fast"], ["heart rate,60"], ["FREQUENCY\t0"], ["Rate, Hz"]])
def test_what_is_no_rate_is_none(desk: Path, above: list[str]) -> None:
    """Words, another rate, a zero: rows stay a second apart, which is said."""
    write("t.csv", above, "p_kPa,x_mm,f_N")
    guess = guess_mapping("t.csv")
    assert "time" not in guess.mapping
    assert NO_CLOCK in guess.remarks


def test_a_clock_in_a_column_comes_first(desk: Path) -> None:
    """Where a column says the time, a rate above the names is not needed, and not believed."""
    rows = "\n".join(f"{0.1 * i:.1f},{p:.0f},{2 * p:.1f}" for i, p in enumerate(P))
    Path("t.csv").write_text(f"Capture Frame Rate,120\nt_s,p_kPa,f_N\n{rows}\n")
    assert guess_mapping("t.csv").mapping["time"] == {"column": "t_s", "unit": "s"}
