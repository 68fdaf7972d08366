"""Files that nobody described and that were recorded of the same time: what each adds, and how they are joined."""

from pathlib import Path

import numpy as np
import pandas as pd
import pytest
import yaml

from labrig import LabrigError
from labrig.log import guess_mapping, import_guessed, import_table
from labrig.tables import guess_together

from .conftest import write_c3d

OWN = "a mapping of its own can have them"
N = 400
T = np.arange(N) * 0.05
P = np.repeat([0.0, 30, 10, 40, 20, 0, 50, 10], 50)
NOISE = np.random.default_rng(5).normal(0, 0.02, (N, 3))
TIP = np.stack([60 + 0.4 * P, 20 - 0.2 * P, 190 + 0.1 * P], axis=1) + NOISE


def write(name: str, **columns: np.ndarray) -> Path:
    """A table of these columns."""
    pd.DataFrame(columns).to_csv(name, index=False)
    return Path(name)


def marker(start_s: float = 0.0) -> Path:
    """What a camera saw of one marker, by a clock that begins then."""
    return write("camera.csv", Time=start_s + T, **{f"tip_{a}": TIP[:, i] for i, a in enumerate("xyz")})


def commands(start_s: float = 0.0) -> Path:
    """What was commanded, once in each tenth of a second."""
    return write("valves.csv", time_s=start_s + T[::2], p_set_kPa=P[::2])


@pytest.mark.parametrize("first", [True, False])
def test_commands_and_places_in_two_files(desk: Path, first: bool) -> None:
    """Two files of one time become one run, whichever is named first: each row has what was commanded then."""
    tables = [commands(), marker()] if first else [marker(), commands()]
    run, guess, _ = import_guessed(tables, Path("run"))
    assert guess.mapping["table"] == "camera.csv"
    (join,) = guess.mapping["join"]
    assert (join["name"], join["file"], join["how"]) == ("valves", "valves.csv", "previous")
    assert guess.mapping["actuation"] == [{"column": "valves.p_set_kPa", "name": "p_set", "unit": "kPa"}]
    assert "valves.csv is joined by time; its columns are called valves.COLUMN" in guess.remarks
    assert run["commanded"].to_numpy().ravel().tolist() == P[::50].tolist()
    assert run["marker"].values.tolist() == ["tip"]
    assert np.nanmax(run["position_mm"].sel(axis="x").to_numpy()[1]) == pytest.approx(72, abs=0.1)


def test_clocks_without_a_common_time(desk: Path) -> None:
    """Clocks that have no time in common are taken to begin together, and that is said."""
    run, guess, _ = import_guessed([commands(1.7e9), marker()], Path("run"))
    (join,) = guess.mapping["join"]
    assert join["offset_s"] == pytest.approx(-1.7e9)
    assert (
        "the clock of valves.csv has no time in common with the other: both are taken to begin together; correct "
        "'offset_s' if not" in guess.remarks
    )
    assert run["commanded"].to_numpy().ravel().tolist() == P[::50].tolist()


@pytest.mark.parametrize("every", [1, 3])
def test_commands_beside_a_c3d_file(desk: Path, every: int) -> None:
    """A C3D file and a table of what was commanded become one run of what was seen, whichever has more rows."""
    write_c3d(Path("take.c3d"), np.stack([TIP, TIP + 9]), ["tip", "base"], "mm", 20.0)
    table = write("valves.csv", time_s=T[::every], p_set_kPa=P[::every])
    run, guess, _ = import_guessed([table, Path("take.c3d")], Path("run"))
    assert guess.mapping["table"] == "take.c3d"
    assert run["commanded"].to_numpy().ravel().tolist() == P[::50].tolist()
    assert run["marker"].values.tolist() == ["tip", "base"]


def test_commands_that_are_written_when_they_are_set(desk: Path) -> None:
    """A command that is written once, when it is set, holds until the next: each of its rows makes one capture."""
    p = [0.0, 52.5, 10.0, 81.0, 33.0, 64.5, 20.0, 90.0, 5.0, 71.0]
    set_s = 11.0 * np.arange(10) + np.array([0, 1, -1, 0, 0, 1, -1, 0, 1, 0]) / 2
    seen_s = (set_s[:, None] + [3.0, 6.0, 9.0]).ravel()
    write("set.csv", **{"t [s]": set_s, "p_set [kPa]": np.array(p)})
    write("seen.csv", **{"t [s]": seen_s, "F [N]": np.repeat(p, 3) / 9 + NOISE[:30, 0]})
    run, guess, _ = import_guessed([Path("set.csv"), Path("seen.csv")], Path("run"))
    assert guess.mapping["join"][0]["how"] == "previous"
    assert run["commanded"].to_numpy().ravel().tolist() == p
    assert run.sizes["time"] == 3


def test_commands_on_their_way_are_between_two_rows(desk: Path) -> None:
    """A command that was sampled while it went up is computed between two rows, as what was measured is."""
    t = np.arange(0, 20, 0.5)
    write("set.csv", **{"t [s]": t, "p_set [kPa]": np.round(50 - 50 * np.cos(t / 3), 2)})
    write("seen.csv", **{"t [s]": T[:380], "F [N]": T[:380] + NOISE[:380, 0]})
    _, guess, _ = import_guessed([Path("set.csv"), Path("seen.csv")], Path("run"))
    assert guess.mapping["join"][0]["how"] == "linear"


def test_what_is_no_input_beside_a_file_of_commands(desk: Path) -> None:
    """What would be taken for the input of one file alone was measured where another one says what was commanded."""
    sensors = write("sensors.csv", t_s=T, flex=P / 3 + NOISE[:, 0], pull=P / 7 + NOISE[:, 1])
    assert [one["column"] for one in guess_mapping(sensors).mapping["actuation"]] == ["flex"]
    _, guess, _ = import_guessed([commands(), sensors], Path("run"))
    assert [one["name"] for one in guess.mapping["actuation"]] == ["p_set"]
    assert [one["name"] for one in guess.mapping["observables"]] == ["flex", "pull"]
    assert not any("no column is called a pressure" in line for line in guess.remarks)


def test_pressures_that_were_measured_in_another_file(desk: Path) -> None:
    """A pressure beside a file that says what was commanded is a covariate, with how to compare both."""
    sensors = write("sensors.csv", t_s=T, pressure_kPa=P + NOISE[:, 0], angle_deg=P / 7 + NOISE[:, 1])
    _, guess, _ = import_guessed([commands(), sensors], Path("run"))
    assert [one["name"] for one in guess.mapping["actuation"]] == ["p_set"]
    assert [one["name"] for one in guess.mapping["covariates"]] == ["pressure"]
    assert (
        "'pressure_kPa' was measured, for another table says what was commanded: taken for a covariate; put it under "
        "'measured:' to compare them" in guess.remarks
    )


def test_names_that_both_files_have(desk: Path) -> None:
    """Only names that more than one file has are told apart by the file."""
    places = {f"tip_{a}": TIP[:, i] for i, a in enumerate("xyz")}
    write("a.csv", t_s=T, p_set_kPa=P, flex=P / 3, **places)
    write("b.csv", t_s=T, pull=P / 7 + NOISE[:, 0], **places)
    _, guess, _ = import_guessed([Path("a.csv"), Path("b.csv")], Path("run"))
    names = {one.get("marker", one["name"]) for one in guess.mapping["observables"]}
    assert names == {"tip", "b.tip", "flex", "pull"}


def test_sheets_with_the_same_columns_are_sessions(desk: Path) -> None:
    """Two days in two sheets of one workbook are two sessions, not two instruments."""
    day = pd.DataFrame({"t_s": T, "p_set_kPa": P, "angle_deg": P / 7 + NOISE[:, 1]})
    with pd.ExcelWriter("days.xlsx") as book:
        day.to_excel(book, sheet_name="Monday", index=False)
        day.to_excel(book, sheet_name="Tuesday", index=False)
    run, guess, _ = import_guessed([Path("days.xlsx")], Path("run"))
    assert "join" not in guess.mapping
    assert sorted(set(run["session"].values.tolist())) == ["Monday", "Tuesday"]
    assert run.sizes["capture"] == 16


def test_a_file_without_a_clock_joins_nothing(desk: Path) -> None:
    """Where a file has no clock, nothing of it can be joined: the import ends in one line that names what is left."""
    with pytest.raises(LabrigError) as error:
        import_guessed([commands(), write("shape.csv", flex=P, pull=P)], Path("run"))
    assert str(error.value).startswith("valves.csv: nothing is left that was measured")
    assert not Path("run").exists()


def test_any_of_the_trials_says_where_the_markers_are_at_rest(tmp_path: Path) -> None:
    """Of trials of which only the second has every input at zero, that one says it, in whichever order they come."""
    for name, low in (("trial_1", 0.0), ("trial_2", 5.0)):
        p = np.repeat([low, 20.0, 40.0, 10.0, low, 30.0], 6)
        frame = pd.DataFrame({"t_s": np.arange(36.0), "p_set_kPa": p})
        for m in (1, 2):
            for a, axis in enumerate("xyz"):
                frame[f"m{m}_{axis}_mm"] = 10.0 * m + a + 0.1 * p * (axis == "z")
        frame.to_csv(tmp_path / f"{name}.csv", index=False)
    for order in (("trial_1", "trial_2"), ("trial_2", "trial_1")):
        guess = guess_together([tmp_path / f"{name}.csv" for name in order], tmp_path)
        assert guess.mapping["markers"]["m1"]["rest"] == [10.0, 11.0, 12.0]
        assert guess.mapping["table"] == [f"{name}.csv" for name in order]


def test_nothing_is_computed_between_what_was_seen_and_what_was_not(desk: Path) -> None:
    """A marker that its camera writes at 0, 0, 0 while it does not see it is nowhere on the way there either."""
    lost = TIP.copy()
    lost[100:140] = 0
    write("camera.csv", Time=T, **{f"tip_{a}": lost[:, i] for i, a in enumerate("xyz")})
    write("valves.csv", time_s=T[:-1] + 0.02, p_set_kPa=P[:-1])
    mapping = {
        "table": "valves.csv",
        "time": {"column": "time_s", "unit": "s"},
        "join": [{"name": "cam", "file": "camera.csv", "time": {"column": "Time", "unit": "s"}}],
        "actuation": [{"column": "p_set_kPa", "name": "p", "unit": "kPa"}],
        "observables": [
            {"column": f"cam.tip_{a}", "name": f"tip.{a}", "unit": "mm", "marker": "tip", "axis": a}
            for a in "xyz"
        ],
    }
    Path("m.yaml").write_text(yaml.safe_dump(mapping))
    run = import_table(Path("m.yaml"), Path("run"))
    seen = run["position_mm"].to_numpy().reshape(-1, 3)
    seen = seen[np.isfinite(seen).all(axis=1)]
    assert len(seen) == N - 1 - 41
    assert seen.min(axis=0) == pytest.approx(TIP.min(axis=0), abs=0.1)
    said = "camera.csv: tip.x, tip.y, tip.z are exactly 0 in 40 rows, and far from it in all others: not seen there"
    assert said in run.attrs["import_remarks"]


@pytest.mark.parametrize("other", ["order", "more"])
def test_sessions_whose_columns_are_not_quite_the_same(desk: Path, other: str) -> None:
    """Files that each say what was commanded and measured are sessions, with columns in another order or one too many;
    they are not joined as if they were recorded at once.
    """
    places = {f"tip_{a}": TIP[:, i] for i, a in enumerate("xyz")}
    first = write("a.csv", t_s=T, p_set_kPa=P, **places)
    if other == "order":
        second = write("b.csv", **places, p_set_kPa=P[::-1], t_s=T)
    else:
        second = write("b.csv", t_s=T, p_set_kPa=P[::-1], room_degC=T, **places)
    run, guess, _ = import_guessed([first, second], Path("run"))
    assert guess.mapping["table"] == ["a.csv", "b.csv"]
    assert "join" not in guess.mapping
    assert run["chamber"].values.tolist() == ["p_set"]
    assert sorted(set(run["session"].values.tolist())) == ["a", "b"]
    left_out = [line for line in guess.remarks if "not in every file" in line]
    assert left_out == (
        [] if other == "order" else [f"b.csv: 1 column is not in every file and left out: room_degC; {OWN}"]
    )


def test_a_file_that_is_named_twice(desk: Path) -> None:
    """The same file is no second session that repeats the first to the last digit: no noise floor comes of it."""
    path = write("a.csv", t_s=T, p_set_kPa=P, force_N=P / 7)
    with pytest.raises(LabrigError, match=r"a\.csv is named twice: the same measurements would count"):
        import_guessed([path, path.resolve()], Path("run"))
    assert not Path("run").exists()


def triggered() -> tuple[Path, Path]:
    """A log of pressures, and a slower camera that is triggered: it sees the last fifth of each hold."""
    seen = np.flatnonzero(np.arange(N) % 50 >= 40)[::3]
    log = write("log.csv", time_s=T, p_set_kPa=P, p_kPa=P + NOISE[:, 0])
    return log, write(
        "camera.csv", time_s=T[seen] + 0.001, **{f"tip_{a}_mm": TIP[seen, i] for i, a in enumerate("xyz")}
    )


@pytest.mark.parametrize("first", [True, False])
def test_rows_are_those_of_what_was_observed(desk: Path, first: bool) -> None:
    """A log of more rows than a camera adds what was commanded and measured then: nothing is computed between what the
    camera saw.
    """
    log, camera = triggered()
    run, guess, _ = import_guessed([log, camera] if first else [camera, log], Path("run"))
    assert guess.mapping["table"] == "camera.csv"
    assert [entry["column"] for entry in guess.mapping["measured"]] == ["log.p_kPa"]
    assert run.sizes["capture"] == 8
    seen = run["position_mm"].to_numpy().ravel()
    assert np.isclose(seen[np.isfinite(seen), None], TIP.ravel(), atol=1e-9).any(axis=1).all()
    assert run["measured"].mean("time").to_numpy().ravel() == pytest.approx(P[::50], abs=0.1)


def test_between_two_holds_a_triggered_camera_saw_nothing(desk: Path) -> None:
    """Joined to a denser log, no place lies between those of two holds; between neighbours it is computed."""
    log, camera = triggered()
    clock = {"column": "time_s", "unit": "s"}
    mapping = {
        "table": log.name,
        "join": [{"name": "camera", "file": camera.name, "time": clock}],
        "time": clock,
        "actuation": [{"column": "p_set_kPa", "name": "p", "unit": "kPa"}],
        "observables": [{"column": "camera.tip_x_mm", "name": "tip", "unit": "mm"}],
    }
    Path("m.yaml").write_text(yaml.safe_dump(mapping))
    run = import_table(Path("m.yaml"), Path("run"))
    off = (run["observed"] - (60 + 0.4 * run["commanded"].squeeze("chamber", drop=True))).to_numpy()
    assert np.isfinite(off).sum() > 8 * 5
    assert np.nanmax(np.abs(off)) < 0.2
