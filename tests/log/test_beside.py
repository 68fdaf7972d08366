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
