"""What a guess takes for an input though nothing calls it so: what is still where all else trembles."""

from pathlib import Path

import numpy as np
import pandas as pd
import pytest

import labrig
from labrig.log import guess_mapping

RANDOM = np.random.default_rng(1)
HOLD = np.repeat(np.arange(60), 3)
VOLUME = RANDOM.uniform(0, 25, 60)[HOLD]
LENGTH = RANDOM.uniform(150, 200, 60)[HOLD]
TIME = HOLD * 9.0 + np.tile([0, 2, 4], 60)
SWING = 35 + 20 * np.sin(0.015 * np.arange(1200)) + 10 * np.sin(0.055 * np.arange(1200))
LAG = np.convolve(3 * SWING, np.exp(-np.arange(100) / 20) / 20)[:1200]


def noisy(values: np.ndarray, size: float) -> np.ndarray:
    """As a sensor reads them."""
    return (values + RANDOM.normal(0, size, len(values))).round(3)


def inputs(folder: Path, columns: dict[str, np.ndarray]) -> tuple[set[str], list[str]]:
    """Which columns a guess takes for inputs, and its remarks."""
    pd.DataFrame(columns).to_csv(folder / "t.csv", index=False)
    found = guess_mapping(folder / "t.csv")
    return {each["column"] for each in found.mapping["actuation"]}, found.remarks


@pytest.mark.parametrize("name", ["pump volume [ml]", "Vol (ml)", "piston position (mm)", "syringe steps"])
def test_what_a_pressure_follows_was_commanded(tmp_path: Path, name: str) -> None:
    """A syringe that stands still in holds drives the line whose pressure trembles, whatever it is called."""
    columns = {"t_s": TIME, name: VOLUME, "p_line [kPa]": noisy(1.2 * VOLUME, 0.15)}
    found, remarks = inputs(tmp_path, columns | {"height [mm]": noisy(35 + 1.6 * VOLUME, 0.08)})
    assert found == {name}
    assert (
        f"'p_line [kPa]' trembles and {name!r} does not: the second is taken for what was commanded"
        in remarks
    )


@pytest.mark.parametrize("name", ["Valve PWM (%)", "u (V)", "Valve opening (%)"])
def test_a_valve_that_moves_all_the_time_drives_what_trembles(tmp_path: Path, name: str) -> None:
    """In a record without holds, too: the pressure lags behind it, and is noisy."""
    found, _ = inputs(
        tmp_path, {"Time (s)": np.arange(1200) * 0.05, name: SWING.round(2), "p (kPa)": noisy(LAG, 1.0)}
    )
    assert found == {name}


@pytest.mark.parametrize("digits", [1, 2])
def test_a_valve_in_ramps_drives_what_trembles(tmp_path: Path, digits: int) -> None:
    """What rounding does to a ramp is no noise; a gauge that trembles by its last digit does."""
    corners = np.arange(0, 70, 10)
    ramps = np.interp(np.arange(1200) * 0.05, corners, [3.1, 71.7, 12.3, 48.8, 0.9, 66.2, 20.4]).round(digits)
    lag = np.convolve(3 * ramps, np.exp(-np.arange(100) / 20) / 20)[:1200]
    gauge = (lag + RANDOM.normal(0, 0.1, 1200)).round(1)
    found, _ = inputs(
        tmp_path, {"Time (s)": np.arange(1200) * 0.05, "Valve PWM (%)": ramps, "p (kPa)": gauge}
    )
    assert found == {"Valve PWM (%)"}


def test_two_valves_that_move_all_the_time_are_both_inputs(tmp_path: Path) -> None:
    """An inlet and an outlet, which have no name in common."""
    other = (40 + 25 * np.sin(0.023 * np.arange(1200))).round(2)
    columns = {"Time (s)": np.arange(1200) * 0.05, "inlet PWM (%)": SWING.round(2), "bleed duty (%)": other}
    assert inputs(tmp_path, columns | {"p (kPa)": noisy(LAG, 1.0)})[0] == {"inlet PWM (%)", "bleed duty (%)"}


def test_a_stage_beside_a_pressure_is_an_input_too(tmp_path: Path) -> None:
    """A length, and the places of a table, that no pressure says; what is read once a hold, and follows it, is none."""
    columns = {"t_s": TIME, "pressure (kPa)": VOLUME, "length (mm)": LENGTH}
    columns |= {"x stage (mm)": LENGTH[::-1], "y stage (mm)": np.roll(LENGTH, 30)}
    columns |= {"height (mm)": (0.3 * VOLUME).round(1), "force (N)": noisy(2 * VOLUME, 0.5)}
    found, remarks = inputs(tmp_path, columns)
    assert found == {"pressure (kPa)", "length (mm)", "x stage (mm)", "y stage (mm)"}
    said = "column 'length (mm)' stands still in holds, and not where the inputs say: taken for an input, too"
    assert said in remarks


@pytest.mark.parametrize("kind", ["few", "jumps"])
def test_what_is_no_stage(tmp_path: Path, kind: str) -> None:
    """A number of three specimens, and what jumps while the pressure is held, were not set with it."""
    column = np.repeat([1.5, 2.5, 3.5], 60) if kind == "few" else np.roll(LENGTH, 1)
    columns = {
        "t_s": TIME,
        "pressure (kPa)": VOLUME,
        "gauge (mm)": column,
        "force (N)": noisy(2 * VOLUME, 0.5),
    }
    assert inputs(tmp_path, columns)[0] == {"pressure (kPa)"}


def test_inputs_of_two_units_have_both(tmp_path: Path) -> None:
    """A pressure and a length are in kPa or mm, not both in the first one's."""
    columns = {"p_set [kPa]": VOLUME, "L_set [mm]": LENGTH, "F [N]": noisy(2 * VOLUME, 0.5)}
    run = labrig.import_table(pd.DataFrame(columns), tmp_path / "run")
    assert run["commanded"].attrs["units"] == "kPa or mm"


def test_a_table_without_noise_says_nothing_of_stages(tmp_path: Path) -> None:
    """One row for each set-point, or means filled down: what was measured stands as still as what was set."""
    found, _ = inputs(tmp_path, {"pressure (kPa)": VOLUME, "length (mm)": LENGTH, "force (N)": 2 * VOLUME})
    assert found == {"pressure (kPa)"}


PLACES = {"nine": np.linspace(0, 40, 9), "three": np.array([5.0, 10.0, 20.0])}


def factorial(places: np.ndarray, seed: int) -> tuple[np.ndarray, np.ndarray]:
    """Pressures and places of 96 holds of three rows: each of nine pressures comes at several places, some in a row."""
    random = np.random.default_rng(seed)
    pressure = random.choice(np.linspace(0, 30, 9), 96)
    pressure[5::12] = pressure[4::12]
    place = random.choice(places, 96)
    place[5::12] = np.where(place[4::12] == places[-1], places[0], places[-1])
    return np.repeat(pressure, 3), np.repeat(place, 3)


@pytest.mark.parametrize("kind", PLACES)
@pytest.mark.parametrize("seed", range(3))
def test_a_stage_that_moves_while_the_pressure_stays_is_an_input(
    tmp_path: Path, kind: str, seed: int
) -> None:
    """A campaign that sets each pressure at each of a few places: every jump of the place begins a hold."""
    pressure, place = factorial(PLACES[kind], seed)
    columns = {"t_s": np.arange(288) * 4.0, "p_kPa": pressure, "stage_mm": place}
    columns["F (N)"] = noisy(2 * pressure + 0.1 * place, 0.5)
    assert inputs(tmp_path, columns)[0] == {"p_kPa", "stage_mm"}
    run = labrig.import_table(tmp_path / "t.csv", tmp_path / "run")
    begins = (np.diff(pressure) != 0) | (np.diff(place) != 0)
    assert run.sizes["capture"] == begins.sum() + 1


def test_a_stage_that_two_columns_say_is_both(tmp_path: Path) -> None:
    """A place in mm and in turns of the spindle was set in both: neither was measured."""
    pressure, place = factorial(PLACES["nine"], 0)
    columns = {"t_s": np.arange(288) * 4.0, "p_kPa": pressure, "stage_mm": place, "spindle": place / 4 + 0.5}
    found, _ = inputs(tmp_path, columns | {"F (N)": noisy(2 * pressure + 0.1 * place, 0.5)})
    assert found == {"p_kPa", "stage_mm", "spindle"}


def test_a_force_is_no_stage(tmp_path: Path) -> None:
    """What is in N was measured, in whatever steps it is read, and though it follows what no column says."""
    pressure, place = factorial(PLACES["nine"], 0)
    columns = {"t_s": np.arange(288) * 4.0, "p_kPa": pressure, "Kraft [N]": np.round(0.3 * place) / 2}
    assert inputs(tmp_path, columns | {"height (mm)": noisy(pressure, 0.5)})[0] == {"p_kPa"}


@pytest.mark.parametrize("seed", range(5))
@pytest.mark.parametrize("beside", ["a pressure", "a stage"])
def test_a_coarse_sensor_is_no_stage(tmp_path: Path, beside: str, seed: int) -> None:
    """What is read in steps of a half creeps within holds, or follows what was set: it was measured."""
    pressure, place = factorial(PLACES["nine"], seed)
    columns = {"t_s": np.arange(288) * 4.0, "p_kPa": pressure}
    creep = 0.3 * np.tile([0.0, 0.6, 1.0], 96) if beside == "a pressure" else 0.0
    if beside == "a stage":
        columns["stage_mm"] = place
    exact = np.maximum(0.1 * (pressure - 12) + 0.06 * (place - 15), 0) + creep
    columns |= {"gauge (mm)": np.round(2 * exact) / 2, "F (N)": noisy(2 * pressure + 0.1 * place, 0.5)}
    expected = {"p_kPa", "stage_mm"} if beside == "a stage" else {"p_kPa"}
    assert inputs(tmp_path, columns)[0] == expected


@pytest.mark.parametrize("name", ["Syringe vol (ml)", "Pump volume [mL]"])
def test_a_volume_of_which_each_row_is_a_set_point(tmp_path: Path, name: str) -> None:
    """A volume that comes again to the last digit is the input beside a pressure that trembles, without holds, too."""
    volume = np.r_[0.0, np.random.default_rng(1).permutation(np.tile(np.arange(6.0), 10))]
    noise = np.random.default_rng(5).normal(0, 0.1, (61, 2))
    frame = {"t (s)": 10 * np.arange(61.0), name: volume, "Pressure (kPa)": 11 * volume + noise[:, 0]}
    pd.DataFrame({**frame, "curvature (1/m)": 3 * volume + noise[:, 1]}).to_csv(
        tmp_path / "t.csv", index=False
    )
    mapping = guess_mapping(tmp_path / "t.csv").mapping
    assert [a["column"] for a in mapping["actuation"]] == [name]
    assert [o["column"] for o in mapping["observables"]] == ["Pressure (kPa)", "curvature (1/m)"]


def test_a_volume_that_was_measured_is_no_input(tmp_path: Path) -> None:
    """A volume that trembles as the pressure does was measured."""
    p = np.tile([0.0, 10, 20, 30, 20, 10], 10)
    noise = np.random.default_rng(5).normal(0, 0.1, (60, 2))
    frame = {
        "t (s)": 10 * np.arange(60.0),
        "vol (ml)": p / 9 + noise[:, 0],
        "pressure (kPa)": p + noise[:, 1],
    }
    pd.DataFrame(frame).to_csv(tmp_path / "t.csv", index=False)
    mapping = guess_mapping(tmp_path / "t.csv").mapping
    assert [a["column"] for a in mapping["actuation"]] == ["pressure (kPa)"]
