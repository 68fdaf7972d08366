"""What a guess takes columns for in tables as rigs of other kinds write them: drives, tendons, loads, twins, turns."""

from collections.abc import Sequence
from pathlib import Path

import numpy as np
import pandas as pd
import pytest

from labrig import LabrigError
from labrig.log import Guess, guess_mapping

N = 120
T = np.arange(N) * 0.5
DUTY = np.repeat([0.0, 180, 60, 240, 120, 0, 255, 60, 180, 240, 0, 120], 10)
NOISE = np.random.default_rng(4).normal(size=(N, 6))


def lagging(command: np.ndarray, rate: float) -> np.ndarray:
    """What follows a command by a part of the way in each row."""
    out = np.zeros(len(command))
    for i in range(1, len(command)):
        out[i] = out[i - 1] + rate * (command[i] - out[i - 1])
    return out


P = 0.2 * lagging(DUTY, 0.3) + 0.2 * NOISE[:, 0]
ANGLE = 1.1 * P + 0.01 * P**2 + 0.1 * NOISE[:, 1]


def guess(folder: Path, **columns: Sequence[float] | np.ndarray) -> Guess:
    """The guess for a table with these columns."""
    pd.DataFrame(columns).to_csv(folder / "t.csv", index=False)
    return guess_mapping(folder / "t.csv")


def taken(found: Guess, kind: str) -> list[str]:
    """The columns that a guess takes for something."""
    return [one["column"] for one in found.mapping.get(kind, []) if "column" in one]


@pytest.mark.parametrize("drive", ["PWM", "duty_cycle", "valve", "Voltage_V"])
def test_a_drive_that_stands_still_beside_a_pressure_that_moves_on(tmp_path: Path, drive: str) -> None:
    """The drive is what was commanded, and a remark says by what."""
    found = guess(tmp_path, Time_s=T, Pressure=P, **{drive: DUTY}, Angle_deg=ANGLE)
    assert taken(found, "actuation") == [drive]
    assert taken(found, "covariates") == ["Pressure"]  # of another size: it can't be compared
    assert taken(found, "observables") == ["Angle_deg"]
    assert (
        f"'{drive}' stands still in holds and 'Pressure' moves on: the first is taken for what was commanded"
        in found.remarks
    )


def test_a_pressure_that_has_nothing_of_a_drive(tmp_path: Path) -> None:
    """Which of both was commanded can't be told: the pressure is taken, and a remark names the drive."""
    smooth = 30 + 20 * np.sin(T / 7)
    found = guess(tmp_path, Time_s=T, pressure_kpa=smooth, PWM=DUTY, angle_deg=smooth**1.1)
    assert taken(found, "actuation") == ["pressure_kpa"]
    assert (
        "'pressure_kpa' is taken for what was commanded, though 'PWM' stands still in holds: put that under "
        "'actuation:' if the pressure was measured" in found.remarks
    )


def test_a_supply_is_no_drive(tmp_path: Path) -> None:
    """A voltage that stands still but for its last digit is no command beside a duty cycle."""
    volts = 12 + 0.05 * np.repeat(np.arange(12) % 3, 10)
    found = guess(tmp_path, Time_s=T, Volts=volts, PWM=DUTY, angle_deg=ANGLE)
    assert taken(found, "actuation") == ["PWM"]


def test_a_duty_cycle_and_its_percents_are_one_command(tmp_path: Path) -> None:
    """Of two columns that are one in two units the first is taken, and the other one is said to be left out."""
    found = guess(tmp_path, Time_s=T, PWM=DUTY, PWM_pct=np.round(DUTY / 2.55, 1), angle_deg=ANGLE)
    assert taken(found, "actuation") == ["PWM"]
    assert taken(found, "observables") == ["angle_deg"]
    assert "column 'PWM_pct' is 'PWM' in another unit and is left out" in found.remarks


def test_what_is_called_a_sensor_is_measured(tmp_path: Path) -> None:
    """A voltage of a sensor is measured, beside the voltage that drives."""
    columns = {"Time [s]": T, "Voltage source [V]": DUTY / 25, "Voltage current sensor [V]": ANGLE**2 / 900}
    found = guess(tmp_path, **columns)
    assert taken(found, "actuation") == ["Voltage source [V]"]
    assert taken(found, "observables") == ["Voltage current sensor [V]"]


@pytest.mark.parametrize("stem", ["dl", "motor", "tendon_", "servo", "cable"])
def test_what_pulls_together_is_commanded_together(tmp_path: Path, stem: str) -> None:
    """Columns that differ by a number have one role, also where nothing is called an input and nothing is held."""
    pulls = {f"{stem}{i + 1}": 5 + NOISE[:, i] for i in range(3)}
    places = {f"tip_{a}": 50 + NOISE[:, :3] @ np.roll([3.0, 1.0, -2.0], i) for i, a in enumerate("xyz")}
    found = guess(tmp_path, **pulls, **places)
    assert taken(found, "actuation") == list(pulls)


def test_readings_are_no_commands(tmp_path: Path) -> None:
    """Where markers stand beside readings alone, nothing is taken for a command, and that is said."""
    readings = {f"adc0_data{i}": 300 + 9 * NOISE[:, i] for i in range(3)}
    places = {f"tip_{a}": 50 + NOISE[:, i] for i, a in enumerate("xyz")}
    found = guess(tmp_path, time_s=T, **readings, **places)
    assert taken(found, "actuation") == []
    assert "nothing looks like an input: name what was commanded under 'actuation:'" in found.remarks


def test_a_load_that_moves_was_measured(tmp_path: Path) -> None:
    """A load that follows the input is an observable; one that stands still is what hung on the body."""
    found = guess(tmp_path, t_s=T, p_set_kpa=DUTY / 5, displacement_mm=ANGLE, load_N=P + 1)
    assert taken(found, "observables") == ["displacement_mm", "load_N"]
    hung = np.repeat([0.0, 50, 100], N // 3)
    found = guess(tmp_path, t_s=T, p_set_kpa=DUTY / 5, displacement_mm=ANGLE, load_g=hung)
    assert (taken(found, "observables"), taken(found, "covariates")) == (["displacement_mm"], ["load_g"])


def test_an_extension_that_was_imposed(tmp_path: Path) -> None:
    """Of an extension and a load the extension is the input."""
    found = guess(tmp_path, t_s=T, Load_N=P, Extension_mm=T / 6)
    assert (taken(found, "actuation"), taken(found, "observables")) == (["Extension_mm"], ["Load_N"])


def test_what_never_changes_is_no_input(tmp_path: Path) -> None:
    """A column of zeros is neither an input nor a capture, and no place of rest follows from it."""
    places = {
        f"{m}_{a}": 50 + 9 * NOISE[:, i] for i, (m, a) in enumerate((m, a) for m in "AB" for a in "xyz")
    }
    found = guess(tmp_path, time_s=T, sub_frame=np.zeros(N), pose_w=np.zeros(N), **places)
    assert taken(found, "actuation") == []
    assert found.mapping["capture"] == {"per": "segment"}
    assert "markers" not in found.mapping


def test_a_second_clock(tmp_path: Path) -> None:
    """A time that goes as the clock does is no measurement; a stroke that goes with the time is one."""
    dates = pd.Timestamp("2026-03-04 09:00") + pd.to_timedelta(T, unit="s")
    columns = {"stamp": dates, "reltime": T + 3, "ms_time": 1e3 * T, "p_set_kpa": DUTY, "stroke_mm": T}
    found = guess(tmp_path, **columns)
    assert taken(found, "observables") == ["stroke_mm"]
    assert "column 'reltime' is a clock as well and is left out" in found.remarks


@pytest.mark.parametrize("name", ["trial", "cycle", "table"])
def test_where_the_clock_begins_anew_is_a_session(tmp_path: Path, name: str) -> None:
    """A column that changes where the clock goes back, and nowhere else, numbers the sessions."""
    columns = {name: np.repeat([1, 2, 3], N // 3), "t_s": np.tile(T[: N // 3], 3), "p_set_kpa": DUTY}
    found = guess(tmp_path, **columns, angle_deg=ANGLE)
    assert found.mapping["session"] == {"column": name}


def test_a_step_that_counts_rows_is_no_capture(tmp_path: Path) -> None:
    """Where the inputs stand still from row to row, what is another number in each row numbers no captures."""
    found = guess(tmp_path, step_id=np.arange(N), t_s=T, p_set_kpa=DUTY, angle_deg=ANGLE)
    assert found.mapping["capture"] == {"per": "segment"}


def test_rows_that_are_counted_beside_the_time(tmp_path: Path) -> None:
    """Of two columns without names that rise, the one that counts rows is not the time."""
    frame = pd.DataFrame([np.arange(N), 0.17 * np.arange(N) + 0.05, DUTY, ANGLE]).T
    frame = frame.astype({0: int})
    frame.to_csv(tmp_path / "t.csv", index=False, header=False)
    found = guess_mapping(tmp_path / "t.csv")
    assert found.mapping["time"] == {"column": 1, "unit": "s"}
    assert (taken(found, "actuation"), taken(found, "observables")) == ([2], [3])
    assert "column '0' counts rows and is left out" in found.remarks


def test_markers_of_one_table_have_one_unit(tmp_path: Path) -> None:
    """A marker that hardly moves is in the unit of the others."""
    columns = {"base_x": 0.4 + 0 * T, "base_y": 0.2 + 0 * T, "tip_x": 80 + ANGLE, "tip_y": 10 + ANGLE}
    found = guess(tmp_path, t_s=T, p_set_kpa=DUTY, **columns)
    assert {one["unit"] for one in found.mapping["observables"]} == {"mm"}
    assert "the unit of 'base, tip' is not said: taken as mm" in "".join(found.remarks)


def test_sensors_that_take_turns_are_refused(tmp_path: Path) -> None:
    """A row for each sensor, while the command stands still, is to be made one row."""
    p = np.repeat(np.arange(30.0), 4)
    columns = {"command_psi": p, "sensor_idx": np.tile(range(4), 30), "raw": 300 + p + NOISE[:, 0]}
    with pytest.raises(LabrigError) as error:
        guess(tmp_path, **columns)
    assert str(error.value) == (
        f"{tmp_path / 't.csv'}: has 4 rows for each measurement, which column 'sensor_idx' tells apart; make it one "
        "row (pivot it), with a column for each of 0, 1, 2, ..."
    )


def test_a_staircase_that_comes_again_is_no_turn(tmp_path: Path) -> None:
    """A target that runs through the same levels in each cycle is commanded, also where the cycles are numbered."""
    levels = np.tile([0.0, 20, 40, 60], 30)
    found = guess(
        tmp_path, cycle=np.repeat(np.arange(30), 4), target_p=levels, angle_deg=levels / 3 + NOISE[:, 0]
    )
    assert taken(found, "actuation") == ["target_p"]


@pytest.mark.parametrize(
    ("command", "sensor"),
    [("p{}", "p{}m"), ("p{}", "p{}_real"), ("p{}d", "p{}"), ("u{}", "p{}"), ("p{}_in", "p{}_out")],
)
@pytest.mark.parametrize("decimals", [0, 2])
def test_a_sensor_beside_its_command_where_each_row_is_a_capture(
    tmp_path: Path, command: str, sensor: str, decimals: int
) -> None:
    """What follows a column of nearly the same name is its sensor, whether or not it has more decimals."""
    rng = np.random.default_rng(0)
    set_kpa = np.round(60.0 * rng.random((40, 3)), decimals)
    read_kpa = np.round(0.98 * set_kpa + 0.4 + rng.normal(0, 0.25, set_kpa.shape), 2)
    columns = {command.format(k + 1): set_kpa[:, k] for k in range(3)}
    columns |= {sensor.format(k + 1): read_kpa[:, k] for k in range(3)}
    found = guess(tmp_path, **columns, bend_mm=set_kpa @ [0.3, 0.2, 0.1] + rng.normal(0, 0.05, 40))
    assert taken(found, "actuation") == [command.format(k + 1) for k in range(3)]
    assert sorted(taken(found, "measured")) == [sensor.format(k + 1) for k in range(3)]
    assert taken(found, "observables") == ["bend_mm"]


def test_what_trembles_is_no_drive_where_others_are_set(tmp_path: Path) -> None:
    """A current that trembles was measured: what stands still in holds beside it was set."""
    sets = {"pc1": 0.3 * DUTY, "pc2": 0.2 * np.roll(DUTY, 30)}
    found = guess(tmp_path, t=T, **sets, current=0.1 * sets["pc1"] - 0.2 * sets["pc2"] + NOISE[:, 1], tau=P)
    assert taken(found, "actuation") == ["pc1", "pc2"]
    assert taken(found, "observables") == ["current", "tau"]
    assert (
        "'current' trembles and 'pc1' does not: the second is taken for what was commanded" in found.remarks
    )


def test_a_current_that_trembles_beside_a_day_is_the_drive(tmp_path: Path) -> None:
    """What never falls, as the number of a day, was not set in its place."""
    found = guess(tmp_path, t=T, mounting=np.repeat([1, 2, 3, 4, 5, 6], 20), current=P, angle_deg=ANGLE)
    assert taken(found, "actuation") == ["current"]
