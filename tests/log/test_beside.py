"""What is beside the measurement: the air, the supply, and how good the measurement was."""

from pathlib import Path

import numpy as np
import pandas as pd
import pytest

from labrig.log import guess_mapping

N = 60
T = np.arange(N) * 10.0
P = np.tile([0.0, 10, 20, 30, 20, 10], 10)
NOISE = np.random.default_rng(5).normal(size=(N, 3))


def guessed(folder: Path, **more: np.ndarray):
    """The guess of a table of pressures and angles with other columns beside them."""
    frame = {"time_s": T, "p_set_kPa": P, "angle_deg": 1.3 * P + 0.3 * NOISE[:, 0], **more}
    pd.DataFrame(frame).to_csv(folder / "t.csv", index=False)
    return guess_mapping(folder / "t.csv")


def names(entries: list[dict]) -> list[str]:
    """What entries of a mapping are called."""
    return [entry["name"] for entry in entries]


@pytest.mark.parametrize(
    "called", ["RH", "RH (%)", "rel. humidity", "Luftfeuchte [%]", "supply_V", "Vbat", "supply voltage"]
)
def test_what_was_around_the_measurement(tmp_path: Path, called: str) -> None:
    """A humidity and the voltage of a supply were not measured of the robot: they are covariates."""
    mapping = guessed(tmp_path, **{called: 24 + 0.02 * NOISE[:, 1]}).mapping
    assert names(mapping["observables"]) == ["angle"]
    assert len(mapping["covariates"]) == 1


@pytest.mark.parametrize(
    ("called", "size"),
    [
        *((name, 45) for name in ("hum", "hum_%", "Hum (%RH)", "humid", "rH", "rF [%]", "%RH", "HR [%]")),
        *(
            (name, 22)
            for name in ("T_room", "T_amb", "T_lab", "T Umgebung", "Raumtemperatur", "Tair", "room temp")
        ),
        *((name, 1013) for name in ("baro", "p_amb [hPa]", "p_atm_hPa", "Luftdruck [hPa]", "patm", "p_amb")),
        ("pression atmosphérique [kPa]", 101),
    ],
)
def test_what_a_weather_station_writes(tmp_path: Path, called: str, size: float) -> None:
    """Humidity, temperature and pressure of the room, as short as people write them, were not measured of the robot."""
    wanders = size * (1 + 0.002 * NOISE[:, 1].cumsum() / 8)
    mapping = guessed(tmp_path, **{called: wanders.round(2)}).mapping
    assert names(mapping["observables"]) == ["angle"]
    assert [entry["column"] for entry in mapping["covariates"]] == [called]
    assert "measured" not in mapping


def test_the_air_that_a_valve_gives_is_no_weather(tmp_path: Path) -> None:
    """A pressure of air that moves with the command is its sensor, and a gap of air is a length."""
    more = {"air pressure [kPa]": P + 0.1 * NOISE[:, 1], "air_gap_mm": P / 9 + NOISE[:, 2]}
    mapping = guessed(tmp_path, **more).mapping
    assert [entry["column"] for entry in mapping["measured"]] == ["air pressure [kPa]"]
    assert names(mapping["observables"]) == ["angle", "air_gap"]


def test_what_is_called_alike_and_was_measured(tmp_path: Path) -> None:
    """The force of a right hand is no humidity, and a supply that is driven is no supply that stands still."""
    mapping = guessed(tmp_path, RH_N=P / 7 + NOISE[:, 1]).mapping
    assert names(mapping["observables"]) == ["angle", "RH"]
    volts = np.tile([0.0, 2, 4, 6, 4, 2], 10)
    pd.DataFrame({"time_s": T, "supply_V": volts, "strain_mm": volts**2 + NOISE[:, 0]}).to_csv(
        tmp_path / "u.csv", index=False
    )
    assert names(guess_mapping(tmp_path / "u.csv").mapping["actuation"]) == ["supply"]


@pytest.mark.parametrize(
    "called",
    ["Mean Marker Error", "reprojection error [px]", "Marker Quality", "n_markers", "markers visible"],
)
def test_how_good_the_measurement_was(tmp_path: Path, called: str) -> None:
    """An error of markers and their number are nothing that a model predicts: they are left out, and that is said."""
    guess = guessed(tmp_path, **{called: np.round(4 + NOISE[:, 1])})
    assert names(guess.mapping["observables"]) == ["angle"]
    assert "covariates" not in guess.mapping
    assert f"column {called!r} says how good the measurement was and is left out" in guess.remarks
