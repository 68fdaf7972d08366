"""The writer never overwrites, bounds what it keeps in memory, and leaves nothing open when it fails."""

import sys
from pathlib import Path
from typing import Any

import numpy as np
import pytest

from labrig import LabrigError
from labrig.log import Layout, LogWriter, load_segments
from labrig.log import to_ns as nanoseconds
from labrig_drivers import MarkerFrame


def _layout(markers: int = 1) -> Layout:
    return Layout(("c1",), (0.0,), (60.0,), markers=tuple(f"m{n}" for n in range(markers)))


def test_an_existing_file_is_never_overwritten(tmp_path: Path) -> None:
    """The file is named, and what is in it stays."""
    path = tmp_path / "log.000.mcap"
    path.write_bytes(b"precious")
    with pytest.raises(LabrigError) as caught:
        LogWriter(path, _layout())
    assert str(caught.value) == f"{path} exists already, and a log is never overwritten"
    assert path.read_bytes() == b"precious"


def test_what_a_step_has_written_can_be_read_before_the_log_is_closed(tmp_path: Path) -> None:
    """`step_done` leaves whole chunks on the disk; what came after it may be missing."""
    path = tmp_path / "log.000.mcap"
    writer = LogWriter(path, _layout())
    writer.event(1.0, "first")
    writer.step_done()
    writer.event(2.0, "second")
    events = load_segments(path)[0][0].segment.topics
    assert [len(messages.payload) for topic, messages in events.items() if topic.name == "EVENTS"] == [1]
    writer.close()
    writer.close()


def test_a_file_that_cannot_be_begun_is_closed(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    """A full disk at the first byte is an error of the caller's, not a leaked file."""

    def full(*_: Any, **__: Any) -> None:
        raise OSError(28, "No space left on device")

    monkeypatch.setattr("mcap.writer.Writer.add_metadata", full)
    with pytest.raises(OSError, match="No space left on device"):
        LogWriter(tmp_path / "log.000.mcap", _layout())


@pytest.mark.parametrize(
    ("time_s", "time_ns"),
    [
        (0.0, 0),
        (-5.0, 0),
        (float("nan"), 0),
        (1.5, 1_500_000_000),
        (1e300, 2**63 - 1),
        (float("inf"), 2**63 - 1),
    ],
)
def test_every_time_has_a_place_in_the_log(time_s: float, time_ns: int) -> None:
    """What nanoseconds cannot express is moved to the nearest end; the exact value stays in the message."""
    assert nanoseconds(time_s) == time_ns


@pytest.mark.skipif(sys.platform == "win32", reason="reads the peak memory as POSIX tells it")
def test_memory_does_not_grow_with_the_log(tmp_path: Path) -> None:
    """A hundred megabytes of frames pass through without staying."""
    import resource

    unit = 1 if sys.platform == "darwin" else 1024
    markers, count = 500, 16_000
    writer = LogWriter(tmp_path / "log.000.mcap", _layout(markers))
    position, status = np.ones((markers, 3)), np.zeros(markers, np.int8)
    for number in range(1000):
        writer.frame(MarkerFrame(1.0 + number, number, position, status))
    before = resource.getrusage(resource.RUSAGE_SELF).ru_maxrss * unit
    for number in range(1000, count):
        writer.frame(MarkerFrame(1.0 + number, number, position, status))
    grown = resource.getrusage(resource.RUSAGE_SELF).ru_maxrss * unit - before
    writer.close()
    assert grown < 30e6
