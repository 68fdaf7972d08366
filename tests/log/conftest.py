"""A small log of a rig, written by hand, and what of it was durable when."""

from dataclasses import dataclass
from pathlib import Path
from typing import Any

import numpy as np
import pandas as pd
import pytest

from labrig.log import Layout, LogWriter, Topic
from labrig_drivers import MarkerFrame, MarkerStatus, PressureSample
from labrig_schema.step_pb2 import Step

N = 60
T = np.arange(N) * 0.1
P = np.repeat([10.0, 30.0, 20.0, 40.0, 0.0, 25.0], 10)
F = 0.5 * P + np.sin(T)
FRAME = pd.DataFrame({"time_s": T, "p1_kpa": P, "force_n": F})

CAPTURES = 6
START_S = 1_767_225_600.0


@dataclass
class SmallLog:
    """A run folder, and after how many bytes of its log each capture was durable."""

    folder: Path
    durable_bytes: list[int]
    first_chunk_bytes: int


def write_session(folder: Path, number: int, captures: int = CAPTURES, start_s: float = START_S) -> list[int]:
    """One session of 2 chambers and 3 markers: actuate, 1 s at 20 Hz, recorded in its second half."""
    layout = Layout(
        chambers=("c1", "c2"),
        chamber_min=(0.0, 0.0),
        chamber_max=(60.0, 50.0),
        markers=("m1", "m2", "m3"),
        rest_mm=((0.0, 0.0, 0.0), (10.0, 0.0, 0.0), (20.0, 0.0, 0.0)),
        start_s=START_S,
        session=str(number),
    )
    rng = np.random.default_rng(number)
    writer = LogWriter(folder / f"log.{number:03d}.mcap", layout, {"procedure": "made", "seed": 3})
    durable = []
    for capture in range(captures):
        begin_s = start_s + 2.0 * capture
        writer.command(begin_s, [10.0 * capture, 5.0], event=True)
        for row in range(20):
            time_s = begin_s + 0.05 * (row + 1)
            position = rng.normal(size=(3, 3))
            status = np.full(3, MarkerStatus.SEEN, np.int8)
            if row % 4 == 0:
                position[2], status[2] = np.nan, MarkerStatus.OCCLUDED
            writer.frame(MarkerFrame(time_s, row, position, status))
            writer.measured(PressureSample(time_s, np.array([10.0 * capture, 5.0]) + 0.01 * row))
        writer.write(
            Topic.STEP,
            begin_s + 1.0,
            index=capture,
            kind="record",
            state=Step.DONE,
            step_json=f'{{"kind": "record", "duration_s": 0.5, "repeat": "{"r" if capture in (1, 4) else ""}"}}',
            started_s=begin_s + 0.5,
            ended_s=begin_s + 1.0,
        )
        writer.step_done()
        durable.append(writer.path.stat().st_size)
    writer.command(start_s + 2.0 * captures, [0.0, 0.0], event=True, reason="end")
    writer.close("completed")
    return durable


@pytest.fixture(scope="session")
def small_log(tmp_path_factory: pytest.TempPathFactory) -> SmallLog:
    """A run of one session."""
    folder = tmp_path_factory.mktemp("small") / "run"
    folder.mkdir()
    durable = write_session(folder, 0)
    whole = (folder / "log.000.mcap").read_bytes()
    chunk = whole.index(b"\x04\x00\x00\x00zstd") - 37
    return SmallLog(folder, durable, chunk + 9 + int.from_bytes(whole[chunk + 1 : chunk + 9], "little"))


@pytest.fixture
def two_sessions(tmp_path: Path) -> Path:
    """A run that was resumed once: sessions of 2 and 3 captures."""
    folder = tmp_path / "run"
    folder.mkdir()
    write_session(folder, 0, captures=2)
    write_session(folder, 1, captures=3, start_s=START_S + 100.0)
    return folder


@pytest.fixture
def write_log() -> Any:
    """`write_session`."""
    return write_session


def write_c3d(path: Path, points: np.ndarray, labels: list[str], unit: str, rate: float) -> None:
    """A C3D file of points (M, T, 3)."""
    import ezc3d

    c3d = ezc3d.c3d()
    c3d["parameters"]["POINT"]["RATE"]["value"] = [rate]
    c3d["parameters"]["POINT"]["LABELS"]["value"] = labels
    c3d["parameters"]["POINT"]["UNITS"]["value"] = [unit]
    data = np.ones((4, *points.shape[:2]))
    data[:3] = np.moveaxis(points, 2, 0)
    c3d["data"]["points"] = data
    c3d.write(str(path))


@pytest.fixture
def desk(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> Path:
    """The current folder of the test."""
    monkeypatch.chdir(tmp_path)
    return tmp_path
