"""What a guess takes columns for, where names say little: commands and sensors, side channels, clocks, markers."""

from collections.abc import Sequence
from pathlib import Path

import numpy as np
import pandas as pd
import pytest

from labrig import LabrigError
from labrig.log import Guess, guess_mapping
from labrig.tables import guess_together

N = 120
T = np.arange(N) * 0.5
C1 = np.repeat([0.0, 30, 10, 40, 20, 0, 50, 10, 30, 40, 0, 20], 10)
C2 = np.repeat([0.0, 10, 40, 20, 50, 30, 0, 40, 10, 20, 50, 0], 10)
NOISE = np.random.default_rng(3).normal(0, 0.05, (N, 4))
P1, P2 = C1 + NOISE[:, 0], C2 + NOISE[:, 1]
F = 0.08 * P1 + 0.05 * P2 + 0.1 * NOISE[:, 2]


def guess(folder: Path, **columns: Sequence[float] | np.ndarray) -> Guess:
    """The guess for a table with these columns."""
    pd.DataFrame(columns).to_csv(folder / "t.csv", index=False)
    return guess_mapping(folder / "t.csv")


def taken(found: Guess, kind: str) -> list[str]:
    """The columns that a guess takes for something."""
    return [one["column"] for one in found.mapping.get(kind, []) if "column" in one]


@pytest.mark.parametrize(
    ("commands", "sensors"),
    [
        (("SP1", "SP2"), ("PV1", "PV2")),
        (("Pset1", "Pset2"), ("Pact1", "Pact2")),
        (("Sollwert 1 [mbar]", "Sollwert 2 [mbar]"), ("Istwert 1 [mbar]", "Istwert 2 [mbar]")),
        (("consigne_1", "consigne_2"), ("mesure_1", "mesure_2")),
        (("goal_p1", "goal_p2"), ("present_p1", "present_p2")),
        (("target_1", "target_2"), ("current_1", "current_2")),
        (("setpoint1", "setpoint2"), ("pressure1", "pressure2")),
        (("pd1", "pd2"), ("p1", "p2")),
        (("p_c_1", "p_c_2"), ("p_s_1", "p_s_2")),
        (("u1", "u2"), ("y1", "y2")),
        (("设定1", "设定2"), ("实测1", "实测2")),
    ],
)
def test_a_command_and_its_sensor(
    tmp_path: Path, commands: tuple[str, str], sensors: tuple[str, str]
) -> None:
    """Of two chambers, what stands still in holds is commanded and what follows it is its sensor, by word or number."""
    u = dict(zip(commands, (C1, C2), strict=True))
    p = dict(zip(sensors, (P1, P2), strict=True))
    for columns in (u | p, p | u):
        found = guess(tmp_path, t_s=T, **columns, force_N=F)
        assert sorted(taken(found, "actuation")) == sorted(commands)
        names = {one["column"]: one["name"] for one in found.mapping["actuation"]}
        pairs = {one["column"]: one["name"] for one in found.mapping["measured"]}
        assert pairs == {s: names[c] for c, s in zip(commands, sensors, strict=True)}
        assert taken(found, "observables") == ["force_N"]


@pytest.mark.parametrize(
    ("commands", "sensors"),
    [
        (("pd_3", "pd_6"), ("pm_3_1", "pm_3_2", "pm_6_1", "pm_6_2")),
        (
            ("desired_p_3", "desired_p_6"),
            ("measured_p_3_1", "measured_p_3_2", "measured_p_6_1", "measured_p_6_2"),
        ),
    ],
)
def test_several_sensors_of_a_chamber(
    tmp_path: Path, commands: tuple[str, str], sensors: tuple[str, str, str, str]
) -> None:
    """Where each chamber has two sensors, one is compared with its command, and none is what the chamber moves."""
    rng = np.random.default_rng(5)
    read = [c + rng.normal(0, 0.05, N) for c in (C1, C1, C2, C2)]
    found = guess(tmp_path, t_s=T, **dict(zip(commands, (C1, C2), strict=True)),
                  **dict(zip(sensors, read, strict=True)), force_N=F)  # fmt: skip
    pairs = {one["column"]: one["name"] for one in found.mapping["measured"]}
    assert list(pairs.values()) == [one["name"] for one in found.mapping["actuation"]]
    assert all(column.split("_")[-2] == name.split("_")[-1] for column, name in pairs.items())
    assert taken(found, "observables") == ["force_N"]
    assert sum("is another sensor of" in line for line in found.remarks) == 2


def test_two_outputs_that_follow_one_input_are_no_sensors_of_it(tmp_path: Path) -> None:
    """What two columns measure of one body is kept, though both follow the only input."""
    rng = np.random.default_rng(5)
    one, other = (C1 + rng.normal(0, 0.3, N) for _ in range(2))
    found = guess(tmp_path, t_s=T, p=C1, angle_1=one, angle_2=other)
    assert taken(found, "observables") == ["angle_1", "angle_2"]
    found = guess(
        tmp_path, t_s=T, p=C1, s1=one, s2=other
    )  # names that say nothing: one may be its sensor, not both
    assert "s2" in taken(found, "observables")


def test_what_follows_by_its_numbers_is_said(tmp_path: Path) -> None:
    """Where numbers alone tell a command from its sensor, a remark says so."""
    found = guess(tmp_path, t_s=T, pd1=C1, p1=P1, force_N=F)
    assert (
        "column 'p1' follows 'pd1': taken for its sensor, and 'pd1' for what was commanded" in found.remarks
    )


def test_a_command_in_volts(tmp_path: Path) -> None:
    """A pressure that follows volts is no input; it can't be compared with them and is a covariate, as is said."""
    found = guess(tmp_path, t_s=T, valve1_V=0.05 * C1, pressure1_kPa=P1, force_N=F)
    assert taken(found, "actuation") == ["valve1_V"]
    assert taken(found, "covariates") == ["pressure1_kPa"]
    assert any("give it a scale to V and put it under 'measured:'" in r for r in found.remarks)


def test_a_sensor_in_another_unit_of_pressure(tmp_path: Path) -> None:
    """A sensor in bar of a command in kPa is converted, as both are compared in the command's unit."""
    found = guess(tmp_path, t_s=T, p1_set_kPa=C1, p1_meas_bar=0.01 * P1, force_N=F)
    assert found.mapping["measured"] == [
        {"column": "p1_meas_bar", "name": "p1_set", "unit": "kPa", "scale": 100.0}
    ]


def test_what_is_measured_on_the_tip_is_no_sensor(tmp_path: Path) -> None:
    """A force with the numbers of the pressure is still measured, not the sensor of the chamber."""
    found = guess(tmp_path, t_s=T, p1_set_kPa=C1, force_N=P1)
    assert "measured" not in found.mapping
    assert taken(found, "observables") == ["force_N"]


@pytest.mark.parametrize(
    "names",
    [
        ("pression_1", "pression_2"),
        ("压力1", "压力2"),
        ("kPa_1", "kPa_2"),
        ("vacuum 1 (inHg)", "vacuum 2 (inHg)"),
    ],
)
def test_what_differs_by_a_number_has_one_role(tmp_path: Path, names: tuple[str, str]) -> None:
    """If one of several columns that differ by a number is an input, all are."""
    found = guess(tmp_path, t_s=T, **{names[0]: C1, names[1]: C2}, force_N=F)
    assert taken(found, "actuation") == list(names)
    assert taken(found, "observables") == ["force_N"]


def test_columns_without_names(tmp_path: Path) -> None:
    """In a table without a header, columns that stand still in holds are the input, and what follows is its sensor."""
    np.savetxt(tmp_path / "t.csv", np.c_[T, C1, C2, P1, F], delimiter=",", fmt="%.4f")
    found = guess_mapping(tmp_path / "t.csv")
    assert taken(found, "actuation") == [1, 2]
    assert taken(found, "measured") == [3]
    assert taken(found, "observables") == [4]


def test_what_is_beside_the_measurement(tmp_path: Path) -> None:
    """Supply, barometer, pump, battery, a valve that is open or closed and a room are covariates; a flow is not."""
    beside = {
        "supply_pressure_kPa": 600 + NOISE[:, 3],
        "barometer_hPa": 1013 + NOISE[:, 2],
        "pump_current_A": 0.5 + NOISE[:, 1],
        "valve_state": (C1 > 20).astype(int),
        "battery_V": 12 + NOISE[:, 0],
        "room_temp_C": 21 + NOISE[:, 3],
    }
    found = guess(tmp_path, t_s=T, p1_set_kPa=C1, **beside, flow_l_min=F)
    assert taken(found, "actuation") == ["p1_set_kPa"]
    assert taken(found, "covariates") == list(beside)
    assert [(o["column"], o["unit"]) for o in found.mapping["observables"]] == [("flow_l_min", "l/min")]
    units = [c["unit"] for c in found.mapping["covariates"]]
    assert units == ["kPa", "hPa", "A", "1", "V", "degC"]


def test_a_tilt_that_follows_the_inputs_was_measured(tmp_path: Path) -> None:
    """The angle of a bending body is no covariate; how a table is tilted is."""
    found = guess(tmp_path, t_s=T, p1_set_kPa=C1, length_mm=80 + F, tilt_deg=0.4 * C1 + NOISE[:, 0])
    assert taken(found, "observables") == ["length_mm", "tilt_deg"]
    assert "column 'tilt_deg' follows the inputs: taken for what was measured" in found.remarks
    found = guess(tmp_path, t_s=T, p1_set_kPa=C1, length_mm=80 + F, tilt_deg=np.repeat([0.0, 15.0], N // 2))
    assert taken(found, "covariates") == ["tilt_deg"]


@pytest.mark.parametrize("name", ["cap", "k", "pose"])
def test_what_goes_up_with_every_set_point_is_its_number(tmp_path: Path, name: str) -> None:
    """A column that is 0, 1, 2 ... from set-point to set-point numbers the captures, whatever it is called."""
    number = np.concatenate([[0], np.cumsum(np.diff(C1) != 0)])
    found = guess(tmp_path, t_s=T, **{name: number}, p1_set_kPa=C1, force_N=F)
    assert found.mapping["capture"] == {"column": name}
    assert taken(found, "observables") == ["force_N"]


@pytest.mark.parametrize("first", [0, 1])
@pytest.mark.parametrize("name", ["", "#", "Index", "No.", "Unnamed: 0"])
def test_numbers_of_rows_are_left_out(tmp_path: Path, name: str, first: int) -> None:
    """A column without a name, or called an index, that is 0, 1, 2 ... or 1, 2, 3 ... is no measurement."""
    frame = pd.DataFrame({name: np.arange(N) + first, "p1_set_kPa": C1, "force_N": F})
    frame.to_csv(tmp_path / "t.csv", index=False)
    found = guess_mapping(tmp_path / "t.csv")
    assert taken(found, "observables") == ["force_N"]
    assert "time" not in found.mapping
    assert any("counts rows and is left out" in r for r in found.remarks)


def test_only_what_counts_rows_is_said_to(tmp_path: Path) -> None:
    """An id that comes again is left out, but not as one that counts rows."""
    found = guess(tmp_path, t_s=T, id=np.tile([7, 9, 8], 40), p1_set_kPa=C1, force_N=F)
    assert "column 'id' is a number or a name, no measurement, and is left out" in found.remarks


def test_parts_of_the_clock_are_left_out(tmp_path: Path) -> None:
    """Milliseconds beside a clock, and years to seconds, are no measurements, and a remark says so."""
    found = guess(tmp_path, t_s=T, Milliseconds=np.tile([0, 500], 60), p1_set_kPa=C1, force_N=F)
    assert taken(found, "observables") == ["force_N"]
    parts = {"Year": [2026] * N, "Month": [11] * N, "Day": [26] * N, "Hour": [1] * N, "Minute": [2] * N}
    found = guess(tmp_path, clock_s=T, **parts, p1_set_kPa=C1, force_N=F)
    assert taken(found, "observables") == ["force_N"]
    assert "column 'Hour' is a part of the clock, no measurement, and is left out" in found.remarks


@pytest.mark.parametrize("owner", ["accel_", "gyro.", "mag_", "torque.", "tip_rot_", "vel_", "wrench/"])
def test_what_has_axes_and_is_no_place(tmp_path: Path, owner: str) -> None:
    """x, y and z of accelerations, torques, rotations and velocities are measured, and no markers in mm."""
    own = {f"{owner}{axis}": NOISE[:, i] for i, axis in enumerate("xyz")}
    place = {f"tip_{axis}_mm": 10 + NOISE[:, i] for i, axis in enumerate("xyz")}
    found = guess(tmp_path, t_s=T, p1_set_kPa=C1, **own, **place)
    seen = found.mapping["observables"]
    assert {o["marker"] for o in seen if "marker" in o} == {"tip"}
    assert {o["column"]: o["unit"] for o in seen if "marker" not in o} == dict.fromkeys(own, "1")


def test_the_unit_or_a_fourth_number_tells_that_it_is_no_place(tmp_path: Path) -> None:
    """x, y, z in m/s2, or with a w beside them, are no markers."""
    own = {f"imu {axis} (m/s2)": NOISE[:, i] for i, axis in enumerate("xyz")}
    turn = {f"base_{axis}": NOISE[:, i] for i, axis in enumerate("xyzw")}
    found = guess(tmp_path, t_s=T, p1_set_kPa=C1, **own, **turn)
    assert {(o["unit"], o.get("marker")) for o in found.mapping["observables"]} == {
        ("m/s**2", None),
        ("1", None),
    }


def test_places_called_tx_or_px(tmp_path: Path) -> None:
    """TX, TY, TZ are places, but torques beside forces; px, py, pz are places."""
    three = NOISE.T[:3] + 10
    for names, forces, marker in (
        ("TXTYTZ", {}, "marker"),
        ("pxpypz", {}, "marker"),
        ("TxTyTz", {"Fx": F}, None),
    ):
        own = {names[i : i + 2]: three[i // 2] for i in (0, 2, 4)}
        found = guess(tmp_path, t_s=T, p1_set_kPa=C1, **forces, **own)
        seen = {o["column"]: o.get("marker") for o in found.mapping["observables"]}
        assert {seen[name] for name in own} == {marker}


@pytest.mark.parametrize(
    ("column", "labels", "wanted"),
    [("id", [1, 2, 3], "m1.x, m1.y, m1.z"), ("marker", ["a", "b", "c"], "a.x, a.y, a.z")],
)
def test_a_long_table_is_refused(
    tmp_path: Path, column: str, labels: list[int] | list[str], wanted: str
) -> None:
    """A table with a row for each marker and time is not merged into one marker: the line says what to do."""
    rows = {"time_s": np.repeat(T, 3), "p1_set_kPa": np.repeat(C1, 3), column: labels * N}
    places = {axis: np.repeat(P1, 3) for axis in "xyz"}
    with pytest.raises(LabrigError) as error:
        guess(tmp_path, **rows, **places)
    assert str(error.value).endswith(
        f"has 3 rows at one time, which column '{column}' tells apart; make it one row of each time (pivot it), with "
        f"columns such as {wanted}"
    )


def test_two_rows_in_one_second_are_no_long_table(tmp_path: Path) -> None:
    """A clock that counts whole seconds has several rows at one time, and is read."""
    found = guess(tmp_path, time_s=np.floor(T), Milliseconds=np.tile([0, 500], 60), p1_set_kPa=C1, force_N=F)
    assert taken(found, "observables") == ["force_N"]


def test_words_among_numbers_are_said(tmp_path: Path) -> None:
    """Of a column of numbers with a few words, the remark says how many, which, and what to do."""
    force = ["saturated" if i % 20 == 3 else f"{f:.3f}" for i, f in enumerate(F)]
    found = guess(tmp_path, t_s=T, p1_set_kPa=C1, force_N=force, stretch_mm=F)
    assert (
        "column 'force_N' holds numbers, but in 6 of 120 cells words, first 'saturated' in line 5 (missing: "
        "['saturated'] under 'format:' makes them missing), and is left out"
    ) in found.remarks
    with pytest.raises(
        LabrigError, match=r"nothing is left .*first 'saturated' in line 5 \(missing: \['saturated'\]"
    ):
        guess(tmp_path, t_s=T, p1_set_kPa=C1, force_N=force)


def test_an_unknown_unit_is_said_once(tmp_path: Path) -> None:
    """What stands where a unit stands and is none that is known: unit 1, with one remark that says what is written."""
    found = guess(tmp_path, t_s=T, **{"P1 set (x10 kPa)": C1, "flow (sccm)": F})
    assert [one["unit"] for kind in ("actuation", "observables") for one in found.mapping[kind]] == ["1", "1"]
    about = [r for r in found.remarks if "unit" in r]
    assert about == [
        "the unit of 'P1 set (x10 kPa)' is written as 1: labrig does not know 'x10 kPa'; correct it under 'unit:'",
        "the unit of 'flow (sccm)' is written as 1: labrig does not know 'sccm'; correct it under 'unit:'",
    ]


def test_two_columns_that_differ_by_their_unit_have_two_names(tmp_path: Path) -> None:
    """What is called the same without its unit keeps it in its name, as no two entries may be called the same."""
    found = guess(tmp_path, t_s=T, p1_set_kPa=C1, force_N=F, force_mN=1000 * P1)
    assert [o["name"] for o in found.mapping["observables"]] == ["force_N", "force_mN"]


HOLDS = np.repeat([0.0, 20.0, 40.0, 10.0, 30.0, 5.0], 6)


def test_the_number_of_the_set_point_is_no_command(tmp_path: Path) -> None:
    """A column `setpoint` that counts 1, 2, 3 where the pressures change numbers the captures; the pressures are it."""
    rng = np.random.default_rng(0)
    frame = pd.DataFrame(
        {
            "t_s": np.arange(36.0),
            "setpoint": 1 + np.arange(36) // 6,
            "p1 [kPa]": HOLDS,
            "force_N": 0.3 * HOLDS + 0.01 * rng.normal(size=36),
        }
    )
    frame.to_csv(tmp_path / "t.csv", index=False)
    mapping = guess_mapping(tmp_path / "t.csv").mapping
    assert mapping["capture"] == {"column": "setpoint"}
    assert [a["column"] for a in mapping["actuation"]] == ["p1 [kPa]"]
    frame["p1 [kPa]"] += 0.05 * rng.normal(size=36)  # measured: now only the number says what was commanded
    frame.to_csv(tmp_path / "t.csv", index=False)
    assert [a["column"] for a in guess_mapping(tmp_path / "t.csv").mapping["actuation"]] == ["setpoint"]


def test_trials_of_one_measurement_have_one_role(tmp_path: Path) -> None:
    """Three columns of angles that differ by a number, one quieter than the others: none is what was commanded."""
    p = np.arange(0.0, 65.0, 5.0)
    bend = 75 * (p / 60) ** 1.4
    frame = pd.DataFrame({"Pressure (kPa)": p, "Trial 1 (deg)": bend})
    frame["Trial 2 (deg)"] = bend + np.tile([0.4, -0.4], 7)[:13]
    frame.to_csv(tmp_path / "t.csv", index=False)
    mapping = guess_mapping(tmp_path / "t.csv").mapping
    assert [a["column"] for a in mapping["actuation"]] == ["Pressure (kPa)"]
    assert [o["column"] for o in mapping["observables"]] == ["Trial 1 (deg)", "Trial 2 (deg)"]


def test_means_with_their_spread_and_number(tmp_path: Path) -> None:
    """Of a table of means, the standard deviation and the number of measurements are no observables."""
    p = np.arange(0.0, 65.0, 5.0)
    names = ("Pressure (kPa)", "Angle mean (deg)", "Angle SD (deg)", "Force std (N)", "n")
    columns = (
        p,
        75 * (p / 60) ** 1.4,
        0.1 + 0 * p + 0.01 * np.arange(13),
        0.3 + 0.01 * np.arange(13) ** 0.5,
        5,
    )
    pd.DataFrame(dict(zip(names, columns, strict=True))).to_csv(tmp_path / "t.csv", index=False)
    guess = guess_mapping(tmp_path / "t.csv")
    assert [o["column"] for o in guess.mapping["observables"]] == ["Angle mean (deg)", "Force std (N)"]
    assert "column 'Angle SD (deg)' is the spread of 'Angle mean (deg)' and is left out" in guess.remarks


@pytest.mark.parametrize("name", ["Frame", "Frame Number", "frames"])
def test_frames_at_no_known_rate_are_no_clock(tmp_path: Path, name: str) -> None:
    """A camera's file whose frames nobody knows the rate of is not joined as if they were milliseconds."""
    frames = pd.DataFrame({name: 215 + 300 * np.arange(36), "tip x": HOLDS / 10, "tip y": HOLDS / 50})
    frames.to_csv(tmp_path / "cam.csv", index=False)
    rig = pd.DataFrame({"t_s": 3.0 * np.arange(36), "p_set_kPa": HOLDS})
    rig.to_csv(tmp_path / "rig.csv", index=False)
    with pytest.raises(
        LabrigError, match=rf"column '{name}' counts frames, and nothing says how many a second: 'time: "
    ):
        guess_together([tmp_path / "rig.csv", tmp_path / "cam.csv"], tmp_path)
