"""What a guess takes columns for in tables of testing machines, motor drivers and fits: what was set, what was not."""

from collections.abc import Sequence
from pathlib import Path

import numpy as np
import pandas as pd
import pytest

from labrig.log import Guess, guess_mapping

N = 60
T = np.arange(N) * 0.1
UP = np.r_[np.linspace(0, 6, 40), np.linspace(5.8, 2, 20)]
NOISE = np.random.default_rng(8).normal(size=(N, 6))
PULL = 4 * UP + 0.3 * UP**2 + 0.05 * NOISE[:, 0]
DUTY = np.repeat([0, 190, 60, 255, 120, 30], 10)


def guess(folder: Path, **columns: Sequence[float] | np.ndarray) -> Guess:
    """The guess for a table with these columns."""
    pd.DataFrame(columns).to_csv(folder / "t.csv", index=False)
    return guess_mapping(folder / "t.csv")


def taken(found: Guess, kind: str) -> list[str]:
    """The columns that a guess takes for something."""
    return [one["column"] for one in found.mapping.get(kind, []) if "column" in one]


@pytest.mark.parametrize("strain", ["Strain (%)", "AVE2 (%)", "Ext.1 [mm]"])
@pytest.mark.parametrize("travel", ["Displacement (mm)", "Stroke [mm]", "Extension (mm)"])
def test_a_testing_machine_sets_its_travel_and_no_strain(tmp_path: Path, travel: str, strain: str) -> None:
    """A strain in percent is no duty cycle, and an extensometer that stands still in its last digit was not set."""
    seen = np.round(0.1 * UP**2 + 0.01 * NOISE[:, 1], 1)
    found = guess(tmp_path, **{"Time (s)": T, "Load (N)": PULL, strain: seen, travel: UP})
    assert taken(found, "actuation") == [travel]
    assert taken(found, "observables") == ["Load (N)", strain]
    said = f"no column is called a pressure, a set-point or an input: {travel!r} is taken for it"
    assert said in found.remarks


def test_a_duty_cycle_is_set_before_a_current_and_a_voltage(tmp_path: Path) -> None:
    """A program sets a duty cycle; a current that is whole, and a potentiometer's volts, stand still as well."""
    pot = np.round(np.cumsum(DUTY - 100) / 4000, 2)
    found = guess(
        tmp_path, t_s=T, current_a1=np.round(DUTY / 40), PWMi=DUTY, PWMe=DUTY[::-1], **{"pot (V)": pot}
    )
    assert taken(found, "actuation") == ["PWMi", "PWMe"]
    assert taken(found, "observables") == ["current_a1", "pot (V)"]


def test_of_two_readings_of_a_current_none_was_set_beside_a_duty_cycle(tmp_path: Path) -> None:
    current = np.round(0.55 * DUTY) * 10  # a motor says its own in steps
    both = {"Current internal": current, "Current external": np.round(current + 2 * NOISE[:, 3])}
    found = guess(tmp_path, t_s=T, **both, PWM=DUTY, Load=-4 * DUTY + NOISE[:, 4])
    assert taken(found, "actuation") == ["PWM"]
    assert taken(found, "observables") == [*both, "Load"]


def test_a_joint_angle_that_is_called_q_was_not_set(tmp_path: Path) -> None:
    angle = 0.1 * UP + 0.01 * NOISE[:, 1]
    found = guess(tmp_path, t_s=T, q_rad=angle, dq_rad_s=NOISE[:, 2], current_A=0.1 * DUTY + NOISE[:, 3])
    assert taken(found, "actuation") == ["current_A"]


def test_of_sensors_that_are_alike_none_was_set(tmp_path: Path) -> None:
    cells = {f"lc{k}": 10 * k + NOISE[:, k] for k in range(1, 5)}
    found = guess(tmp_path, t_s=T, **cells)
    assert taken(found, "actuation") == []
    assert taken(found, "observables") == [*cells]
    assert "nothing looks like an input: name what was commanded under 'actuation:'" in found.remarks


def test_what_was_computed_was_not_measured(tmp_path: Path) -> None:
    """Not even where it follows the command as a sensor does; alone in a table it is kept, as of a simulation."""
    weights = np.linspace(0, 50, 12)
    counts = np.round(900 + 460 * weights + 90 * NOISE[:12, 4])
    fit = (counts - 900) / 460
    found = guess(tmp_path, reference_N=weights, raw=counts, predicted_N=fit, residual_N=fit - weights)
    assert taken(found, "actuation") == ["reference_N"]
    assert taken(found, "measured") == []
    assert taken(found, "observables") == ["raw"]
    assert "column 'predicted_N' was computed, not measured, and is left out" in found.remarks
    alone = guess(tmp_path, t_s=T, p_kPa=DUTY, **{"simulated angle (deg)": UP})
    assert taken(alone, "observables") == ["simulated angle (deg)"]


def side_by_side(folder: Path, head: str, slower: float) -> Guess:
    """The guess for a table with two records of a clock, a stroke and a force, the second `slower` than the first."""
    columns = [T, UP, PULL, slower * T, 1.1 * UP, 0.9 * PULL + 0.1 * NOISE[:, 5]]
    rows = "\n".join(",".join(f"{v:.4f}" for v in row) for row in np.column_stack(columns))
    (folder / "t.csv").write_text(f"{head}\n{rows}\n")
    return guess_mapping(folder / "t.csv")


@pytest.mark.parametrize(
    "head",
    [
        "Time,Stroke,Force,Time,Stroke,Force",
        "Time_1,Stroke_1,Force_1,Time_2,Stroke_2,Force_2",
        "A3 Time [s],A3 Stroke [mm],A3 Force [N],B1 Time [s],B1 Stroke [mm],B1 Force [N]",
    ],
)
def test_of_records_side_by_side_one_is_taken(tmp_path: Path, head: str) -> None:
    """Rows of two specimens with a clock each are not of one time; with one clock for both they are."""
    first = head.split(",")[:3]
    found = side_by_side(tmp_path, head, 1.07)
    assert found.mapping["time"]["column"] == first[0]
    assert taken(found, "actuation") == [first[1]]
    assert taken(found, "observables") == [first[2]]
    assert sum("is the clock of another record" in line for line in found.remarks) == 1
    both = side_by_side(tmp_path, head, 1.0)
    assert len(taken(both, "actuation") + taken(both, "measured") + taken(both, "observables")) == 4


def test_of_records_side_by_side_the_shorter_may_come_first(tmp_path: Path) -> None:
    """The clock of a shorter record is empty at its end: the longer one is taken."""
    short = np.where(np.arange(N) < 45, 1.0, np.nan)
    found = guess(
        tmp_path,
        Time_1=T * short,
        Stroke_1=UP * short,
        Force_1=PULL * short,
        Time_2=1.1 * T,
        Stroke_2=UP,
        Force_2=PULL,
    )
    assert found.mapping["time"]["column"] == "Time_2"
    assert taken(found, "actuation") + taken(found, "observables") == ["Stroke_2", "Force_2"]


def test_a_clock_that_comes_again_for_each_channel_is_no_measurement(tmp_path: Path) -> None:
    """LabVIEW may write the time beside each channel, and calls it X_Value."""
    found = guess(tmp_path, X_Value=T, valve=DUTY, **{"X_Value.2": T}, force_N=PULL)
    assert taken(found, "actuation") == ["valve"]
    assert taken(found, "observables") == ["force_N"]


def test_the_time_in_a_cycle_is_no_measurement(tmp_path: Path) -> None:
    cycle = T % 2.0
    found = guess(
        tmp_path,
        **{"Total Time (s)": T, "Cycle Elapsed Time (s)": cycle, "Stroke (mm)": UP, "Force (N)": PULL},
    )
    assert taken(found, "observables") == ["Force (N)"]
    assert "column 'Cycle Elapsed Time (s)' is a clock as well and is left out" in found.remarks


@pytest.mark.parametrize("step", [[1.0, 2.0], [0.143] * 10 + [0.03]])
def test_a_file_without_names_may_have_a_time_that_rises_nearly_evenly(
    tmp_path: Path, step: list[float]
) -> None:
    """A logger that writes whole seconds, or in blocks, has steps of two sizes."""
    rises = np.r_[0, np.cumsum(np.resize(step, N - 1))]
    np.savetxt(tmp_path / "t.csv", np.column_stack([rises, DUTY, PULL]), delimiter=",", fmt="%.3f")
    found = guess_mapping(tmp_path / "t.csv")
    assert found.mapping["time"]["column"] == 0
    assert taken(found, "actuation") == [1]


def test_lines_of_numbers_that_are_not_read_are_said(tmp_path: Path) -> None:
    """A sheet of which some rows have empty cells behind: those of another length are left out with the names."""
    rows = [f"old;{k};10;{v:.2f};" + ";;;;" * (k > 6) for k, v in enumerate(PULL[:40])]
    (tmp_path / "t.csv").write_text("\n".join(["type;trial;force input;force output;", *rows]))
    found = guess_mapping(tmp_path / "t.csv")
    assert "7 lines of numbers above have another number of cells, and are left out" in found.remarks


@pytest.mark.parametrize(
    ("name", "unit"),
    [
        ("Timestamp (millisec since midnight today)", "ms"),
        ("Time [s since start]", "s"),
        ("time (us from boot)", "us"),
    ],
)
def test_a_unit_may_say_from_when_it_counts(tmp_path: Path, name: str, unit: str) -> None:
    found = guess(tmp_path, **{name: 36_000_000 + np.arange(N) * 20, "p_kPa": DUTY, "angle_deg": UP})
    assert found.mapping["time"] == {"column": name, "unit": unit}
