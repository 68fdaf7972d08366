"""Foreign tables become runs: CSV, Parquet and C3D, with every number where it belongs."""

from pathlib import Path

import numpy as np
import pandas as pd
import pytest
import yaml

from labrig import open_run
from labrig.log import import_table, write_dataset
from labrig.log._layout import Layout, layout_from_text, layout_to_text

from .conftest import write_c3d

MAP = {
    "table": "t.csv",
    "time": {"column": "t", "unit": "min"},
    "hold": {"column": "h", "unit": "ms"},
    "capture": {"column": "n"},
    "session": {"column": "day"},
    "repeat": {"column": "setpoint"},
    "between_sessions": "held",
    "actuation": [
        {"column": "p1", "name": "c1", "unit": "bar", "min": 0, "max": 2},
        {"value": 0.5, "name": "c2", "unit": "bar"},
    ],
    "measured": [{"column": "q1", "name": "c1", "unit": "bar"}],
    "observables": [
        {"column": "x", "name": "m1.x", "unit": "m", "marker": "m1", "axis": "x"},
        {"column": "y", "name": "m1.y", "unit": "cm", "marker": "m1", "axis": "y"},
        {"column": "z", "name": "m1.z", "unit": "mm", "marker": "m1", "axis": "z"},
        {"column": "F", "name": "force", "unit": "N"},
        {"column": "s", "name": "side", "unit": "m", "marker": "m2", "axis": "x"},
    ],
    "markers": {"m1": {"rest": [1.0, 2.0, 3.0]}},
    "covariates": [{"column": "T", "name": "temperature", "unit": "degC"}],
}
HOLDS = (3, 2, 4)


def table() -> pd.DataFrame:
    """Nine rows of three captures in two sessions, with a gap or two."""
    rng = np.random.default_rng(0)
    capture = np.repeat([1, 2, 3], HOLDS)
    hold = np.concatenate([np.arange(n) * 500.0 + 3000.0 for n in HOLDS])
    begin = np.array([0.0, 10.0, 20.0])[capture - 1]
    frame = pd.DataFrame(
        {
            "t": (begin + hold / 1000) / 60,
            "h": hold,
            "n": capture,
            "day": np.where(capture < 3, "mon", "tue"),
            "setpoint": np.where(capture == 2, "", "again"),
            "p1": np.array([0.5, 1.5, 0.5])[capture - 1],
            "q1": rng.uniform(0, 2, 9),
            "x": rng.normal(size=9),
            "y": rng.normal(size=9),
            "z": rng.normal(size=9),
            "F": rng.normal(size=9),
            "s": rng.normal(size=9),
            "T": rng.uniform(20, 25, 9),
        }
    )
    frame.loc[4, "F"] = np.nan
    return frame


def imported(mapping: dict, name: str = "run"):
    """The run that a mapping makes."""
    Path("map.yaml").write_text(yaml.safe_dump(mapping, sort_keys=False))
    return import_table(Path("map.yaml"), Path(name))


def rows_of(values: np.ndarray) -> np.ndarray:
    """Capture by capture, without the padding."""
    return np.concatenate([values[c, :n] for c, n in enumerate(HOLDS)])


@pytest.mark.parametrize("kind", ["csv", "parquet"])
def test_every_number_is_where_it_belongs(desk: Path, kind: str) -> None:
    """Values, times, holds, labels, units, limits and covariates come back from the log as the table had them."""
    frame = table()
    frame.to_csv("t.csv", index=False) if kind == "csv" else frame.to_parquet("t.parquet")
    imported({**MAP, "table": f"t.{kind}"})
    run = open_run("run")
    assert dict(run.sizes) == {
        "capture": 3,
        "chamber": 2,
        "time": 4,
        "event": 3,
        "marker": 1,
        "axis": 3,
        "observable": 2,
        "covariate": 1,
    }
    assert run["commanded"].values.tolist() == [[0.5, 0.5], [1.5, 0.5], [0.5, 0.5]]
    assert run["commanded"].attrs["units"] == "bar"
    assert run["chamber_min"].values.tolist() == [0.0, 0.0]
    assert run["chamber_max"].values.tolist() == [2.0, 0.5]
    assert rows_of(run["hold_s"].values) == pytest.approx(frame["h"] / 1000)
    assert rows_of(run["time_s"].values) == pytest.approx((frame["t"] - frame["t"][0]) * 60)
    assert np.isnan(run["hold_s"].values[1, 2:]).all()
    assert run["settled"].values.sum() == 9
    metres = np.stack([1000 * frame["x"], 10 * frame["y"], frame["z"]], axis=1)
    assert rows_of(run["position_mm"].values[:, :, 0]) == pytest.approx(metres)
    assert run["rest_mm"].values.tolist() == [[1.0, 2.0, 3.0]]
    assert rows_of(run["observed"].values[:, :, 0]) == pytest.approx(frame["F"].to_numpy(), nan_ok=True)
    assert rows_of(run["observed"].values[:, :, 1]) == pytest.approx(1000 * frame["s"])
    assert run["unit"].values.tolist() == ["N", "mm"]
    assert run["marker_of"].values.tolist() == ["", "m2"]
    assert run["axis_of"].values.tolist() == ["", "x"]
    assert rows_of(run["measured"].values[:, :, 0]) == pytest.approx(frame["q1"])
    assert np.isnan(run["measured"].values[:, :, 1]).all()
    assert rows_of(run["covariates"].values[:, :, 0]) == pytest.approx(frame["T"])
    assert run["covariate_unit"].values.tolist() == ["degC"]
    assert run["session"].values.tolist() == ["mon", "mon", "tue"]
    assert run["repeat"].values.tolist() == ["again", "", "again"]
    assert run["event_of"].values.tolist() == [0, 1, 2]
    assert run["event_time_s"].values == pytest.approx(np.array([0.0, 10.0, 20.0]) - 3.0)
    assert (run.attrs["between_sessions"], run.attrs["source"]) == ("held", "table")


def test_a_run_that_was_imported_is_written_and_read_alike(desk: Path) -> None:
    """The Dataset of a run, written as another run, is the same to the last digit."""
    table().to_csv("t.csv", index=False)
    run = imported(MAP)
    write_dataset(run, Path("copy"), run_yaml={"procedure": "test"})
    copy = open_run("copy")
    for name in run.variables:
        np.testing.assert_array_equal(run[name].values, copy[name].values, err_msg=str(name))
    assert yaml.safe_load(Path("run/run.yaml").read_text())["mapping"]["between_sessions"] == "held"


def test_the_former_word_for_vented_is_read(desk: Path) -> None:
    """A mapping or a log that says `released` between sessions means what is called `vented` now."""
    table().to_csv("t.csv", index=False)
    assert imported({**MAP, "between_sessions": "released"}).attrs["between_sessions"] == "vented"
    older = layout_to_text(Layout(("c1",), (0.0,), (60.0,))).replace('"vented"', '"released"')
    assert "released" in older
    assert layout_from_text(older).between_sessions == "vented"


def test_a_log_without_places_is_written_as_it_always_was() -> None:
    """An older labrig reads it: where sensors look is in the layout only where somebody knows that."""
    plain = Layout(("c1",), (0.0,), (60.0,))
    assert "observable_rest_mm" not in layout_to_text(plain)
    assert layout_from_text(layout_to_text(plain)) == plain
    known = Layout(("c1",), (0.0,), (60.0,), observable_rest_mm=((1.0, 2.0, 3.0),))
    assert layout_from_text(layout_to_text(known)) == known


def test_rows_without_captures_are_captures_themselves(desk: Path) -> None:
    """No 'capture:', no 'time:', no 'hold:': each row is one, in the order of the table."""
    Path("t.csv").write_text("p,F\n1,10\n2,20\n3,\n4,40\n")
    run = imported(
        {
            "table": "t.csv",
            "actuation": [{"column": "p", "name": "c1", "unit": "kPa"}],
            "observables": [{"column": "F", "name": "force", "unit": "N"}],
        }
    )
    assert run.sizes["capture"] == 3
    assert run["commanded"].values.ravel().tolist() == [1.0, 2.0, 4.0]
    assert run["event_commanded"].values.ravel().tolist() == [1.0, 2.0, 3.0, 4.0]
    assert run["event_of"].values.tolist() == [0, 1, 3]
    assert run["session"].values.tolist() == ["t", "t", "t"]
    assert run.attrs["between_sessions"] == "unknown"


def test_the_way_a_table_is_written(desk: Path) -> None:
    """Separators, no header, decimal commas, thousands, rows to skip, to stop at and to thin."""
    lines = ["rubbish", "more rubbish"] + [f"1.{i:03d}.000;{i},5;{10 * i}" for i in range(12)]
    Path("t.csv").write_text("\n".join(lines) + "\n")
    run = imported(
        {
            "table": "t.csv",
            "format": {
                "separator": ";",
                "header": False,
                "decimal": ",",
                "skip_rows": 2,
                "rows": 10,
                "every": 3,
            },
            "time": {"column": 0, "unit": "us", "thousands": "."},
            "actuation": [{"column": 1, "name": "c1", "unit": "kPa"}],
            "observables": [{"column": 2, "name": "force", "unit": "N"}],
        }
    )
    assert run["commanded"].values.ravel().tolist() == [0.5, 3.5, 6.5, 9.5]
    assert run["time_s"].values.ravel() == pytest.approx([0.0, 0.003, 0.006, 0.009])
    assert run["observed"].values.ravel().tolist() == [0.0, 30.0, 60.0, 90.0]


@pytest.mark.parametrize(("separator", "between"), [("tab", "\t"), ("whitespace", "  "), (",", ", ")])
def test_separators_with_names(desk: Path, separator: str, between: str) -> None:
    """Tabs and runs of blanks have names; blanks after a comma do no harm, nor does a byte-order mark."""
    Path("t.csv").write_text(
        "\n".join(between.join(r) for r in (("p", "F"), ("1", "2"))), encoding="utf-8-sig"
    )
    run = imported(
        {
            "table": "t.csv",
            "format": {"separator": separator},
            "actuation": [{"column": "p", "name": "c1", "unit": "kPa"}],
            "observables": [{"column": "F", "name": "force", "unit": "N"}],
        }
    )
    assert run["observed"].values.ravel().tolist() == [2.0]


def test_several_files_are_sessions_one_after_the_other(desk: Path) -> None:
    """Each file is its own session with its own constants; clocks that begin anew follow each other."""
    for name in ("a", "b"):
        Path(f"{name}.csv").write_text("t,F\n0,1\n1,2\n")
    run = imported(
        {
            "table": [
                {"file": "a.csv", "actuation": {"c1": 10}, "covariates": {"payload": 0}},
                {"file": "b.csv", "session": "late", "actuation": {"c1": 20}, "covariates": {"payload": 50}},
            ],
            "time": {"column": "t", "unit": "s"},
            "capture": {"per": "file"},
            "actuation": [{"name": "c1", "unit": "kPa"}],
            "observables": [{"column": "F", "name": "force", "unit": "N"}],
            "covariates": [{"name": "payload", "unit": "g"}],
        }
    )
    assert run["session"].values.tolist() == ["a", "late"]
    assert run["commanded"].values.ravel().tolist() == [10.0, 20.0]
    assert run["time_s"].values.tolist() == [[0.0, 1.0], [2.0, 3.0]]
    assert run["hold_s"].values.tolist() == [[0.0, 1.0], [0.0, 1.0]]
    assert run["covariates"].values[:, 0, 0].tolist() == [0.0, 50.0]


def test_markers_of_a_c3d_file(desk: Path) -> None:
    """Events say what was commanded when; points have their own names, unit and rate; gaps stay gaps."""
    rng = np.random.default_rng(0)
    points = rng.normal(size=(3, 400, 3)).astype(np.float32).astype(float)
    points[1, 250] = np.nan
    write_c3d(Path("t.c3d"), points, ["Arm - 1", "Arm - 2", "Base"], "m", 100.0)
    run = imported(
        {
            "table": [
                {
                    "file": "t.c3d",
                    "events": [
                        {"time_s": 0, "actuation": {"c1": 0}, "record": False},
                        {"time_s": 1, "actuation": {"c1": 100}},
                        {"time_s": 2, "actuation": {"c1": 200}},
                        {"time_s": 3.5, "actuation": {"c1": 0}, "record": False},
                    ],
                }
            ],
            "actuation": [{"name": "c1", "unit": "mbar"}],
            "markers": {"tip": {"point": "Arm - 2"}, "Base": {"rest": [0, 0, 1]}},
        }
    )
    assert run["marker"].values.tolist() == ["tip", "Base"]
    assert run["commanded"].values.ravel().tolist() == [100.0, 200.0]
    assert run["event_commanded"].values.ravel().tolist() == [0.0, 100.0, 200.0, 0.0]
    assert run["event_time_s"].values == pytest.approx([0.0, 1.0, 2.0, 3.5])
    assert run["hold_s"].values[0, [0, 99]] == pytest.approx([0.0, 0.99])
    assert run["position_mm"].values[0, :100, 0] == pytest.approx(1000 * points[1, 100:200], rel=1e-6)
    assert run["position_mm"].values[1, :150, 1] == pytest.approx(1000 * points[2, 200:350], rel=1e-6)
    assert np.isnan(run["position_mm"].values[1, 50, 0]).all()
    assert run["rest_mm"].values[1].tolist() == [0.0, 0.0, 1.0]


def test_a_c3d_file_by_itself(desk: Path, labrig) -> None:
    """Without 'markers:' all points are taken; one that is not there is named, with those that are."""
    write_c3d(Path("t.c3d"), np.tile([1.0, 2.0, 3.0], (2, 5, 1)), ["a", "b"], "mm", 50.0)
    mapping = {
        "table": "t.c3d",
        "capture": {"per": "file"},
        "actuation": [{"value": 0, "name": "none", "unit": "kPa"}],
    }
    run = imported(mapping)
    assert run["marker"].values.tolist() == ["a", "b"]
    assert run["position_mm"].values.reshape(-1, 3).tolist() == [[1.0, 2.0, 3.0]] * 10
    Path("map.yaml").write_text(yaml.safe_dump({**mapping, "markers": ["a", "c"]}))
    assert labrig("import", "--mapping", "map.yaml", "-o", "other") == (
        2,
        "",
        "labrig: t.c3d: has no point 'c'; it has a, b\n",
    )
    assert not Path("other").exists()


@pytest.mark.parametrize("share", [0.0, 0.001])
def test_a_run_that_was_cut_is_refused(desk: Path, labrig, share: float) -> None:
    """A log that lost its head, or its rows, ends a diagnosis in one line, and nothing is written."""
    table().to_csv("t.csv", index=False)
    imported(MAP)
    log = Path("run/log.000.mcap")
    whole = log.read_bytes()
    log.write_bytes(whole[: int(share * len(whole))])
    Path("model.yaml").write_text("base: {kind: static}\n")
    code, out, err = labrig("diagnose", "run", "--model", "model.yaml")
    assert (code, out) == (2, "")
    assert err.startswith("labrig: run")
    assert err.count("\n") == 1
    assert not Path("diagnosis").exists()


def test_a_run_that_was_cut_in_the_middle_says_so(desk: Path, labrig) -> None:
    """What is whole of the log is compared, and the result tells what was lost."""
    table().to_csv("t.csv", index=False)
    imported(MAP)
    log = Path("run/log.000.mcap")
    log.write_bytes(log.read_bytes()[: log.stat().st_size * 3 // 4])
    Path("model.yaml").write_text("base: {kind: static}\n")
    code, out, err = labrig("compare", "run", "--model", "model.yaml")
    assert (code, err) == (0, "")
    assert "note: log.000.mcap" in out
