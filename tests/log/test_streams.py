"""Inputs that nobody cut into captures: rows at full rate, the whole history, and segments with names."""

import re
from pathlib import Path

import numpy as np
import pandas as pd
import pytest
import yaml

import labrig
from labrig import LabrigError
from labrig.log import write_dataset
from labrig.tables import find_segments
from tests.log.one_force import run_of

N = 2000
T = np.arange(N) * 0.05
RNG = np.random.default_rng(3)
STAIRS = np.repeat([0.0, 20.0, 40.0, 60.0, 40.0, 20.0, 0.0, 30.0, 50.0, 10.0], 200)
SINE = 30 - 30 * np.cos(2 * np.pi * T / 10)
TRAPEZE = np.tile(
    np.r_[np.linspace(0, 50, 100), np.full(150, 50.0), np.linspace(50, 0, 100), np.zeros(150)], 4
)
WALK = np.cumsum(RNG.normal(size=N))
NOISE = RNG.normal(size=N)


def imported(u: np.ndarray, name: str = "run", **more: object):
    """A run of a stream, with a force that is twice the pressure."""
    frame = pd.DataFrame({"t": T[: len(u)], "p": u, "F": 2 * u, "part": more.pop("part", 0)})
    frame.to_csv("t.csv", index=False)
    mapping = {
        "table": "t.csv",
        "time": {"column": "t", "unit": "s"},
        "actuation": [{"column": "p", "name": "p", "unit": "kPa"}],
        "observables": [{"column": "F", "name": "F", "unit": "N"}],
        **more,
    }
    Path("map.yaml").write_text(yaml.safe_dump(mapping))
    return labrig.import_table("map.yaml", name)


def kinds(u: np.ndarray) -> dict[str, int]:
    """How many segments of each kind an input has; they cover all rows, once."""
    found = find_segments(u[:, None], T[: len(u)], "kPa")
    assert [s.begin for s in found] == [0, *(s.end for s in found[:-1])]
    assert found[-1].end == len(u)
    return {kind: sum(s.kind == kind for s in found) for kind in {s.kind for s in found}}


@pytest.mark.parametrize(
    ("u", "expected"),
    [
        (STAIRS, {"plateau": 10}),
        (STAIRS + 0.1 * NOISE, {"plateau": 10}),
        (TRAPEZE, {"ramp": 8, "plateau": 8}),
        (TRAPEZE + 0.1 * NOISE, {"ramp": 8, "plateau": 8}),
        (np.linspace(0, 60, N), {"ramp": 1}),
        (np.interp(T, [0, 30, 60, 100], [0, 60, 20, 60]), {"ramp": 3}),
        (np.full(N, 12.0), {"plateau": 1}),
        (np.round(np.linspace(0, 60, N) * 10) / 10, {"ramp": 1}),
        (STAIRS + np.where((T % 30 >= 5) & (T % 30 < 10), 0.2, 0.0), {"plateau": 14}),
        (STAIRS + np.where(T % 30 > 29.9, 0.2, 0.0), {"plateau": 10}),
    ],
    ids=[
        "stairs",
        "noisy stairs",
        "trapeze",
        "noisy trapeze",
        "ramp",
        "three ramps",
        "held",
        "quantised ramp",
        "steps of a three-hundredth",
        "a digit off at last",
    ],
)
def test_segments_of_what_is_commanded(u: np.ndarray, expected: dict[str, int]) -> None:
    """Plateaus and ramps are counted as a person would, with noise of a sensor or without."""
    assert kinds(u) == expected


@pytest.mark.parametrize("u", [SINE, SINE + 0.2 * NOISE, np.round(SINE)], ids=["sine", "noisy", "quantised"])
def test_a_sine_is_cycles(u: np.ndarray) -> None:
    """Ten periods of a sine are ten cycles, cut at the troughs; its crests are no plateaus."""
    assert kinds(u) == {"cycle": 10}


def test_a_sum_of_sines_has_no_plateaus() -> None:
    """The slow crests of a sum of sines, beside a part that is fast, are no plateaus; what stands still is one."""
    phase = np.cumsum(2 * np.pi * 0.05 * np.repeat([0.03, 0.12, 0.3], [1000, 500, 500]))
    swing = np.round(2.5 + 1.5 * np.sin(phase) + 0.6 * np.sin(0.37 * phase + 1), 3)
    assert "plateau" not in kinds(swing)
    assert kinds(np.r_[swing[:1000], np.full(400, swing[999])])["plateau"] == 1


def test_a_random_walk_is_stretches() -> None:
    """What has no shape is cut into stretches, named by their times."""
    found = find_segments(WALK[:, None], T, "kPa")
    assert {s.kind for s in found} == {"stretch"}
    assert 2 <= len(found) <= 12
    assert found[0].name.startswith("stretch 1 (0-")


def test_a_stream_is_a_run_at_full_rate(desk: Path) -> None:
    """Every row is there, at its own input, in a segment with a name; the history is the input itself."""
    run = imported(SINE, capture={"per": "segment"})
    assert run.sizes["capture"] == N
    assert run["commanded"].to_numpy()[:, 0] == pytest.approx(SINE)
    assert run["event_commanded"].to_numpy()[:, 0] == pytest.approx(SINE)
    assert run["observed"].to_numpy()[:, 0, 0] == pytest.approx(2 * SINE)
    names = list(dict.fromkeys(run["segment"].to_numpy().tolist()))
    assert names[3] == "cycle 4 (30-39.95 s)"
    assert len(names) == 10
    assert "t.csv: a stream of 2000 rows: 10 cycles" in run.attrs["warnings"]
    write_dataset(run, Path("copy"), run_yaml={})
    copy = labrig.open_run("copy")
    assert copy["segment"].to_numpy().tolist() == run["segment"].to_numpy().tolist()


def test_stairs_are_holds(desk: Path) -> None:
    """Where the input is held most of the time its plateaus are captures, with time within each."""
    run = imported(STAIRS, capture={"per": "segment"})
    assert (run.sizes["capture"], run.sizes["time"]) == (10, 200)
    assert run["commanded"].to_numpy()[:, 0].tolist() == STAIRS[::200].tolist()
    assert run["hold_s"].to_numpy()[3, [0, 199]] == pytest.approx([0.0, 9.95])
    assert run["segment"].to_numpy()[3] == "plateau 4 at 60 kPa"


def test_a_capture_may_be_a_ramp(desk: Path) -> None:
    """Captures in which the input moves all along count row by row and keep their names; the others stay holds."""
    u = np.r_[np.full(100, 10.0), np.linspace(10, 50, 100), np.full(100, 50.0)]
    run = imported(u, capture={"column": "part"}, part=np.repeat(["a", "b", "c"], 100))
    assert run.sizes["capture"] == 102
    assert run["commanded"].to_numpy()[1:101, 0] == pytest.approx(u[100:200])
    assert set(run["segment"].to_numpy()[1:101]) == {"capture b"}
    assert any("p' moves within capture b" in w for w in run.attrs["warnings"])


def test_thinning_keeps_the_history(desk: Path) -> None:
    """With 'every' fewer rows are compared, and the input between them is still there, sample by sample."""
    run = imported(WALK, format={"every": 21})
    assert run.sizes["capture"] == len(WALK[::21])
    assert run["commanded"].to_numpy()[:, 0] == pytest.approx(WALK[::21])
    assert run["event_commanded"].to_numpy()[:, 0] == pytest.approx(WALK)
    assert run["event_time_s"].to_numpy() == pytest.approx(T)
    assert run["event_of"].to_numpy().tolist() == list(range(0, N, 21))


def test_a_long_table_is_read_back_as_a_short_one(desk: Path) -> None:
    """Beyond 20,000 rows a log is written in blocks: the same Dataset comes back, holds and streams alike."""
    n = 24_000
    u = np.repeat(np.arange(240) * 23.0 % 60, 100)
    frame = pd.DataFrame(
        {"t": np.arange(n) * 0.01, "p": u, "x": RNG.normal(size=n), "part": np.arange(n) // 100}
    )
    frame.to_parquet("t.parquet")
    for how in ({"column": "part"}, {"per": "segment"}):
        mapping = {
            "table": "t.parquet",
            "capture": how,
            "time": {"column": "t", "unit": "s"},
            "actuation": [{"column": "p", "name": "p", "unit": "kPa", "max": 60}],
            "observables": [{"column": "x", "name": "x", "unit": "N"}],
        }
        Path("map.yaml").write_text(yaml.safe_dump(mapping))
        name = "-".join(how)
        run = labrig.import_table("map.yaml", name)
        assert (run.sizes["capture"], run.sizes["time"]) == (240, 100)
        assert run["observed"].to_numpy().ravel() == pytest.approx(frame["x"].to_numpy())
        assert run["commanded"].to_numpy()[:, 0] == pytest.approx(u[::100])
        assert run["event_of"].to_numpy().tolist() == list(range(240))
    log = Path("column/log.000.mcap")
    log.write_bytes(log.read_bytes()[: log.stat().st_size // 2])
    left = labrig.open_run("column")
    m = left.sizes["capture"]
    assert 20 < m < 200
    assert left["observed"].to_numpy()[: m - 1].ravel() == pytest.approx(
        frame["x"].to_numpy()[: 100 * (m - 1)]
    )


def clocks(desk: Path, how: str, **more: object):
    """Two files: pressures at 20 Hz, and a camera at 33 Hz whose clock began 2.5 s later and runs 1 % fast."""
    pd.DataFrame({"t": T, "p": SINE}).to_csv("pressure.csv", index=False)
    at = np.arange(0, 90, 0.03)
    camera = pd.DataFrame({"frame_ms": (at - 2.5) * 1.01 * 1000, "x": np.sin(at / 3), "note": "ok"})
    camera.to_csv("camera.csv", index=False)
    mapping = {
        "table": "pressure.csv",
        "join": [
            {
                "name": "camera",
                "file": "camera.csv",
                "time": {"column": "frame_ms", "unit": "ms"},
                "how": how,
                "offset_s": 2.5,
                "rate": 1 / 1.01,
                **more,
            }
        ],
        "time": {"column": "t", "unit": "s"},
        "actuation": [{"column": "p", "name": "p", "unit": "kPa"}],
        "observables": [{"column": "camera.x", "name": "x", "unit": "mm"}],
    }
    Path("map.yaml").write_text(yaml.safe_dump(mapping))
    return labrig.import_table("map.yaml", "run")


@pytest.mark.parametrize(("how", "error"), [("linear", 1e-4), ("nearest", 0.006), ("previous", 0.011)])
def test_two_clocks(desk: Path, how: str, error: float) -> None:
    """A file with a clock of another rate and offset is read at the times of the first; no more is seen than it saw."""
    run = clocks(desk, how)
    t = run["time_s"].to_numpy()[:, 0]
    off = run["observed"].to_numpy()[:, 0, 0] - np.sin(t / 3)
    inside = t < 89.9
    assert np.abs(off[inside]).max() < error
    assert np.abs(off[inside]).max() > error / 20
    if how != "previous":
        assert t.max() == pytest.approx(89.95, abs=0.06)
    assert run["event_commanded"].to_numpy()[:, 0] == pytest.approx(SINE)


def test_clocks_that_never_meet(desk: Path) -> None:
    """Times that don't overlap are an error that gives both spans."""
    with pytest.raises(
        LabrigError, match=r"camera\.csv: its times .* are not those of pressure\.csv, 0 to 99.95 s"
    ):
        clocks(desk, "linear", offset_s=5000)


@pytest.mark.parametrize("rows", [2, 3, 4, 5])
def test_set_points_of_few_rows_are_holds(desk: Path, rows: int) -> None:
    """A table of 40 set-points anywhere, each of a few rows with the same command: as many captures of so many rows."""
    u = np.random.default_rng(0).uniform(0, 60, 40).round(1)
    run = imported(np.repeat(u, rows), capture={"per": "segment"})
    assert run.sizes["capture"] == 40
    assert run.commanded.values[:, 0] == pytest.approx(u)
    assert (np.isfinite(run.observed.values).sum(axis=1) == rows).all()


def test_set_points_of_one_row_are_no_record(desk: Path) -> None:
    """Where each row is another set-point, far from the one before, each is a capture of its own, without a segment."""
    u = np.random.default_rng(0).uniform(0, 60, 40).round(1)
    run = imported(u, capture={"per": "segment"})
    assert run.sizes["capture"] == 40
    assert "segment" not in run.coords
    assert run.attrs["import_remarks"] == ["t.csv: 40 set-points of one row each"]


def test_a_ramp_that_is_logged_twice_as_often_is_no_row_of_holds(desk: Path) -> None:
    """A command that rises every other row by little is a slow motion: its rows count one by one."""
    run = imported(
        np.repeat(np.r_[np.linspace(0, 60, 200), np.linspace(60, 0, 200)], 2), capture={"per": "segment"}
    )
    assert run.sizes["capture"] == 800


def table_of(rows_s: tuple[float, ...], wait_s: float, **more: object):
    """A run of 20 set-points with rows at such moments after the first, each actuated so long before."""
    u = np.random.default_rng(1).uniform(0, 60, 20).round(1)
    t = (np.arange(20)[:, None] * (wait_s + rows_s[-1] + 1.0) + np.array(rows_s)).ravel()
    p = np.repeat(u, len(rows_s))
    return run_of(pd.DataFrame({"t": t, "p": p, "F": 2 * p}), **more)


def test_the_wait_before_the_first_row_is_part_of_the_hold(desk: Path) -> None:
    """Actuate, wait 3 s, record: with settle_s the rows know how long they were held, and when it began."""
    run = table_of((0.0, 0.5, 1.0), 3.0, settle_s=3)
    assert run.hold_s.values == pytest.approx(np.tile([3.0, 3.5, 4.0], (20, 1)))
    assert run.event_time_s.values == pytest.approx(run.time_s.values[:, 0] - 3.0)
    assert run.attrs["import_remarks"] == []


def test_a_wait_that_nobody_said_is_asked_about(desk: Path) -> None:
    """Where much more time lies before a hold's first row than between its rows, the import says when it begins."""
    run = table_of((0.0, 0.5, 1.0), 3.0)
    assert run.hold_s.values == pytest.approx(np.tile([0.0, 0.5, 1.0], (20, 1)))
    assert run.attrs["import_remarks"] == [
        "t.csv: 4 s lie between the last row of a set-point and the first of the next, and each hold is taken to begin "
        "at its first row: if it was actuated before, write how long before, such as 'settle_s: 3'"
    ]


def test_rows_at_one_pace_raise_no_question(desk: Path) -> None:
    """Of holds that are logged all the time nothing is asked."""
    assert table_of((0.0, 1.0, 2.0), 0.0).attrs["import_remarks"] == []


@pytest.mark.parametrize(
    ("more", "words"),
    [
        (
            {"settle_s": 9},
            "t.csv, line 5: settle_s is 9 s, but the row before, of another set-point, is only 4 s earlier",
        ),
        (
            {"settle_s": 3, "hold": {"column": "t", "unit": "s"}},
            "'hold:' and 'settle_s:' say the same: leave one of them out",
        ),
        (
            {"settle_s": 3, "time": None},
            "'settle_s:' needs the time of each row: say its column under 'time:'",
        ),
    ],
)
def test_a_wait_that_cannot_be(desk: Path, more: dict, words: str) -> None:
    """Longer than there was time, said twice, or without any time: one line, and no run."""
    with pytest.raises(LabrigError, match=re.escape(words)):
        table_of((0.0, 0.5, 1.0), 3.0, **more)
    assert not Path("run").exists()
