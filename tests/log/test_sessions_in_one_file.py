"""Recordings of one kind in one file: sheets of a workbook, groups of HDF5, structs of MAT."""

from pathlib import Path

import h5py
import numpy as np
import pandas as pd
import pytest
from scipy.io import savemat

from labrig.log import guess_mapping, import_guessed

T = np.arange(60) * 0.1
P = np.repeat([10.0, 30.0, 20.0, 40.0, 0.0, 25.0], 10)
TRIALS = ("first", "second", "another")


def trial(k: int) -> dict[str, np.ndarray]:
    """What was recorded in one trial."""
    noise = np.random.default_rng(k).normal(0, 0.02, 60)
    return {"t_s": T, "p_set_kPa": P + k, "angle_deg": P / 7 + noise}


def workbook(**beside: pd.DataFrame) -> Path:
    """A sheet of each trial, and other sheets."""
    with pd.ExcelWriter("t.xlsx") as book:
        for name, frame in beside.items():
            frame.to_excel(book, sheet_name=name, index=False)
        for k, name in enumerate(TRIALS):
            pd.DataFrame(trial(k)).to_excel(book, sheet_name=name, index=False)
    return Path("t.xlsx")


def hdf(start_s: float = 0.0) -> Path:
    """A group of each trial, with clocks that begin then."""
    with h5py.File("t.h5", "w") as file:
        for k, name in enumerate(("trial_2", "trial_7", "trial_10")):
            for key, values in trial(k).items():
                file[f"trials/{name}/{key}"] = values + start_s * (key == "t_s")
        file["notes/version"] = np.arange(4.0)
    return Path("t.h5")


def mat() -> Path:
    """An array of structs, one of each trial."""
    kinds = [(key, "O") for key in trial(0)]
    savemat("t.mat", {"trial": np.array([tuple(trial(k).values()) for k in range(3)], dtype=kinds)})
    return Path("t.mat")


def test_a_sheet_of_notes_beside_the_trials(desk: Path) -> None:
    """A sheet of notes and one of figures without a clock do not make parallel inputs of trials: these are sessions."""
    notes = pd.DataFrame({"Project": ["Rig", "Operator", "Date"], "muscles": ["A", "kl", "2021-04-02"]})
    figures = pd.DataFrame({"stiffness N/mm": [1.5, 1.6, 1.7], "level": [1, 2, 3]})
    run, guess, _ = import_guessed([workbook(Info=notes, Fits=figures)], Path("run"))
    assert "join" not in guess.mapping
    assert run["chamber"].values.tolist() == ["p_set"]
    assert list(dict.fromkeys(run["session"].values.tolist())) == list(TRIALS)
    for name in ("Info", "Fits"):
        assert f"part {name!r} has other columns than the sessions and is left out" in guess.remarks


def books(dated: bool, alone: bool) -> list[Path]:
    """Two workbooks of a sheet for each trial, of which the second is of the day before; of one file only one."""
    paths = [Path("b.xlsx"), Path("a.xlsx")]
    for day, path in enumerate(paths):
        with pd.ExcelWriter(path) as book:
            for k, name in enumerate(TRIALS[: 1 if alone and day else 3]):
                frame = pd.DataFrame(trial(3 * day + k))
                if dated:
                    began = pd.Timestamp(2024, 5, 2 - day, 9 + k)
                    frame = frame.assign(t_s=began + pd.to_timedelta(T, "s")).rename(columns={"t_s": "time"})
                frame.to_excel(book, sheet_name=name, index=False)
    return paths


@pytest.mark.parametrize("dated", [False, True])
@pytest.mark.parametrize("alone", [False, True])
def test_several_workbooks_of_several_sheets(desk: Path, dated: bool, alone: bool) -> None:
    """Each sheet of each file is a session, by its date, or in the order of the files."""
    run, guess, _ = import_guessed(books(dated, alone), Path("run"))
    first, second = [f"b_{name}" for name in TRIALS], ["a"] if alone else [f"a_{name}" for name in TRIALS]
    assert "join" not in guess.mapping
    assert list(dict.fromkeys(run["session"].values.tolist())) == (
        [*second, *first] if dated else [*first, *second]
    )
    places = {name: run["commanded"].to_numpy()[run["session"].values == name].max() for name in first}
    assert list(places.values()) == [40.0, 41.0, 42.0]


def test_another_record_beside_the_trials(desk: Path) -> None:
    """Sheets that say both what was commanded and what was measured are sessions beside a log of something else."""
    room = pd.DataFrame({"t_s": T, "room_degC": 21 + T / 60})
    run, guess, _ = import_guessed([workbook(Room=room)], Path("run"))
    assert "join" not in guess.mapping
    assert run["chamber"].values.tolist() == ["p_set"]
    assert "part 'Room' has other columns than the sessions and is left out" in guess.remarks


@pytest.mark.parametrize("made", [hdf, mat])
def test_groups_that_are_alike(desk: Path, made) -> None:
    """Groups of HDF5 and structs of MAT that hold the same arrays are sessions, in the order of the file; that they
    are is said.
    """
    run, guess, _ = import_guessed([made()], Path("run"))
    assert run["chamber"].values.tolist() == ["p_set"]
    assert run["commanded"].to_numpy().ravel().tolist() == [p + k for k in range(3) for p in P[::10]]
    assert len(set(run["session"].values.tolist())) == 3
    assert any("hold the same arrays: taken as 3 sessions" in line for line in guess.remarks)


def test_groups_of_one_date_were_recorded_at_once(desk: Path) -> None:
    """Groups whose dates are the same are no sessions: each adds its own input."""
    mapping = guess_mapping(hdf(1.7e9)).mapping
    assert len(mapping["actuation"]) == 3


def test_sensors_that_are_alike_are_no_sessions(desk: Path) -> None:
    """Groups that hold the same arrays, but say nothing of what was commanded, are sensors of one time."""
    with h5py.File("t.h5", "w") as file:
        for name, k in (("left", 7), ("right", 9)):
            file[f"{name}/t_s"], file[f"{name}/angle_deg"] = T, trial(0)["angle_deg"] * k
        file["valve/t_s"], file["valve/p_set_kPa"] = T, P
    mapping = guess_mapping("t.h5").mapping
    assert len(mapping["observables"]) == 2
    assert mapping["table"] == "t.h5"
