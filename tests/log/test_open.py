"""A rig's log becomes the Dataset of docs/reference/dataset.md."""

from collections.abc import Callable
from pathlib import Path
from typing import Any

import numpy as np
import pytest

from labrig import LabrigError, open_run


def test_a_run_has_the_documented_variables(small_log) -> None:
    """Every variable and coordinate of the reference is there with its dims and units."""
    run = open_run(small_log.folder)
    assert dict(run.sizes) == {"capture": 6, "chamber": 2, "time": 20, "marker": 3, "axis": 3, "event": 7}
    assert run["commanded"].dims == ("capture", "chamber")
    assert run["measured"].dims == ("capture", "time", "chamber")
    assert run["position_mm"].dims == ("capture", "time", "marker", "axis")
    assert [run[name].dims for name in ("hold_s", "time_s", "settled")] == [("capture", "time")] * 3
    assert run["event_commanded"].dims == ("event", "chamber")
    assert run["rest_mm"].to_numpy().tolist() == [[0, 0, 0], [10, 0, 0], [20, 0, 0]]
    assert run["commanded"].attrs["units"] == "kPa"
    assert run["chamber"].to_numpy().tolist() == ["c1", "c2"]
    assert run["chamber_max"].to_numpy().tolist() == [60.0, 50.0]
    assert run.attrs["source"] == "rig"
    assert run.attrs["between_sessions"] == "vented"
    assert run.attrs["warnings"] == []


def test_the_whole_hold_is_there_and_its_settled_part_marked(small_log) -> None:
    """Rows begin with the actuation; those from the start of the recording on are settled."""
    run = open_run(small_log.folder)
    np.testing.assert_allclose(run["hold_s"][3], 0.05 * np.arange(1, 21), atol=1e-6)
    np.testing.assert_allclose(run["time_s"][3], 6.0 + 0.05 * np.arange(1, 21), atol=1e-6)
    assert run["settled"][3].to_numpy().tolist() == [False] * 9 + [True] * 11
    np.testing.assert_allclose(run["event_time_s"], [0, 2, 4, 6, 8, 10, 12], atol=1e-6)
    assert run["event_of"].to_numpy().tolist() == [0, 1, 2, 3, 4, 5]


def test_values_are_what_was_logged(small_log) -> None:
    """Positions to 32 bits, NaN where occluded; pressures at the rows' times; labels of repeats."""
    run = open_run(small_log.folder)
    rng = np.random.default_rng(0)
    first = rng.normal(size=(20, 3, 3)).astype(np.float32)
    first[::4, 2] = np.nan
    np.testing.assert_array_equal(run["position_mm"][0], first.astype(float))
    np.testing.assert_allclose(run["measured"][2, :, 0], 20.0 + 0.01 * np.arange(20), atol=1e-6)
    assert run["commanded"].to_numpy().tolist() == [[10.0 * capture, 5.0] for capture in range(6)]
    assert run["repeat"].to_numpy().tolist() == ["", "r", "", "", "r", ""]


def test_a_single_file_opens_like_its_folder(small_log) -> None:
    """An .mcap file may be named instead of the run."""
    run = open_run(small_log.folder / "log.000.mcap")
    assert run.equals(open_run(small_log.folder))


def test_each_resume_is_a_session(two_sessions: Path) -> None:
    """Captures and events know their session, and time runs on from the first."""
    run = open_run(two_sessions)
    assert run["session"].to_numpy().tolist() == ["0", "0", "1", "1", "1"]
    assert run["event_session"].to_numpy().tolist() == ["0"] * 3 + ["1"] * 4
    assert run["event_of"].to_numpy().tolist() == [0, 1, 3, 4, 5]
    assert float(run["time_s"][2, 0]) == pytest.approx(100.05)


def test_a_missing_segment_is_said(two_sessions: Path) -> None:
    """The sessions that are left are read, and the file that is gone is named."""
    (two_sessions / "log.000.mcap").unlink()
    run = open_run(two_sessions)
    assert run.sizes["capture"] == 3
    assert run.attrs["warnings"] == ["log.000.mcap is missing; what it held is lost"]


def test_an_unreadable_segment_does_not_hide_the_others(two_sessions: Path) -> None:
    """A segment of which nothing is whole is one more warning."""
    (two_sessions / "log.001.mcap").write_bytes(b"")
    run = open_run(two_sessions)
    assert run.sizes["capture"] == 2
    assert run.attrs["warnings"] == [
        f"{two_sessions / 'log.001.mcap'} is empty: nothing of this log was written"
    ]


@pytest.mark.parametrize(
    ("content", "message"),
    [
        (None, "{path} does not exist; name a run folder or an .mcap file"),
        (b"", "{path} is empty: nothing of this log was written"),
        (
            b"time,c1,m1\n0,1,2\n" * 9,
            "{path} is not an MCAP file, or nothing of it is whole; `labrig import` makes a run of a table",
        ),
        (b"\x89MCAP0\r\n", "{path} holds no whole chunk: nothing of it can be read"),
    ],
)
def test_what_is_no_log_is_refused_in_one_line(tmp_path: Path, content: bytes | None, message: str) -> None:
    """Absent, empty, foreign and hopeless files are each named for what they are."""
    path = tmp_path / "some.mcap"
    if content is not None:
        path.write_bytes(content)
    with pytest.raises(LabrigError) as caught:
        open_run(path)
    assert str(caught.value) == message.format(path=path)


def test_a_folder_without_a_log_is_no_run(tmp_path: Path) -> None:
    """The folder is named, and what it lacks."""
    with pytest.raises(LabrigError) as caught:
        open_run(tmp_path)
    assert str(caught.value) == f"{tmp_path} is not a run: it holds no log.000.mcap"


def test_a_log_of_another_tool_is_refused(tmp_path: Path) -> None:
    """An MCAP file without labrig's layout is a valid file of somebody else's."""
    from mcap.writer import Writer

    path = tmp_path / "other.mcap"
    with path.open("wb") as file:
        writer = Writer(file)
        writer.start()
        channel = writer.register_channel("/x", "json", writer.register_schema("x", "jsonschema", b"{}"))
        writer.add_message(channel, 1, b"{}", 1)
        writer.finish()
    with pytest.raises(LabrigError) as caught:
        open_run(path)
    assert str(caught.value) == (
        f"{path} is an MCAP file, but no log of labrig's that can be read (it names no chambers); "
        "use `labrig import` for tables of other tools"
    )


def test_a_log_of_a_newer_labrig_is_refused(
    small_log, tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    """A version that this labrig does not know is said, not guessed at."""
    monkeypatch.setattr("labrig.log._layout.VERSION", 0)
    with pytest.raises(LabrigError) as caught:
        open_run(small_log.folder)
    assert str(caught.value) == (
        f"{small_log.folder / 'log.000.mcap'} was written by a newer labrig "
        "(log version 1, this one reads up to 0); update labrig"
    )


def test_an_older_log_is_migrated(small_log, monkeypatch: pytest.MonkeyPatch) -> None:
    """What an older log says of itself goes through every migration in between."""
    monkeypatch.setattr("labrig.log._layout.VERSION", 3)
    monkeypatch.setattr(
        "labrig.log._layout.MIGRATIONS",
        {1: lambda text: text.replace('"c1"', '"c?"'), 2: lambda text: text.replace('"c?"', '"chest"')},
    )
    assert open_run(small_log.folder)["chamber"].to_numpy().tolist() == ["chest", "c2"]


def test_a_run_without_captures_opens(tmp_path: Path, write_log: Callable[..., Any]) -> None:
    """Stopped before the first capture was complete: no rows, but the events are there."""
    write_log(tmp_path, 0, captures=0)
    run = open_run(tmp_path)
    assert dict(run.sizes) == {"capture": 0, "chamber": 2, "time": 0, "marker": 3, "axis": 3, "event": 1}
