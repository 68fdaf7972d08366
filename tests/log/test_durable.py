"""What a power cut leaves: every step that was done, in files whose names are known."""

from pathlib import Path
from typing import Any

import pytest

from labrig import _durable
from labrig.log import Layout, LogWriter, Topic, load_segments, summarise
from labrig_schema.step_pb2 import Step

LAYOUT = Layout(("c1",), (0.0,), (60.0,), markers=("m1",))


def _write_step(writer: LogWriter, index: int) -> None:
    writer.write(Topic.STEP, 1.0 + index, index=index, kind="record", state=Step.DONE, step_json="{}")


def _steps(folder: Path) -> list[int]:
    segments, _ = load_segments(folder)
    payloads = [payload for loaded in segments for payload in loaded.messages(Topic.STEP).payload]
    return [Step.FromString(payload).index for payload in payloads]


def test_a_step_that_is_done_survives_a_power_cut(disk: Any, tmp_path: Path) -> None:
    """Once `step_done` has returned the step is on the disk; one that was only written is not counted on."""
    folder = tmp_path / "run"
    folder.mkdir()
    writer = LogWriter(folder / "log.000.mcap", LAYOUT)
    for index in range(3):
        _write_step(writer, index)
        writer.step_done()
        _write_step(writer, 100 + index)
        assert _steps(disk.cut(folder, tmp_path / f"left{index}"))[-1] == index
    writer.close()


def test_a_log_that_has_only_begun_survives(disk: Any, tmp_path: Path) -> None:
    """The file's name and its layout are durable before the first step."""
    folder = tmp_path / "run"
    folder.mkdir()
    writer = LogWriter(folder / "log.000.mcap", LAYOUT)
    segments, _ = load_segments(disk.cut(folder, tmp_path / "left"))
    assert segments[0].layout == LAYOUT
    writer.close()


@pytest.mark.parametrize("reason", ["completed", ""])
def test_a_log_that_was_closed_survives_with_its_end(disk: Any, tmp_path: Path, reason: str) -> None:
    """Why the run ended, and the indexes, are durable once `close` has returned."""
    folder = tmp_path / "run"
    folder.mkdir()
    writer = LogWriter(folder / "log.000.mcap", LAYOUT)
    _write_step(writer, 0)
    writer.close(reason)
    left = disk.cut(folder, tmp_path / "left")
    assert summarise(left).state == (reason or "closed")
    assert summarise(left).warnings == []
    assert (left / "log.000.mcap").read_bytes() == (folder / "log.000.mcap").read_bytes()


def test_what_is_lost_of_a_log_without_its_end_is_counted(tmp_path: Path) -> None:
    """A log that was cut has no counts at its end: the messages' own numbers say how many are missing."""
    path = tmp_path / "log.000.mcap"
    writer = LogWriter(path, LAYOUT)
    ends = []
    for index in range(3):
        _write_step(writer, index)
        writer.step_done()
        ends.append(path.stat().st_size)
    writer.abandon()
    whole = bytearray(path.read_bytes())
    whole[ends[0] + 80] ^= 0xFF  # in the second chunk
    path.write_bytes(whole)
    segments, warnings = load_segments(path)
    assert len(segments[0].messages(Topic.STEP).payload) == 2
    assert "log.000.mcap: 1 of 3 messages on /step are lost" in warnings


class TestAFileThatSomebodyReads:
    """Windows refuses to put a file in another's place while that one is read."""

    @pytest.fixture
    def refused(self, monkeypatch: pytest.MonkeyPatch) -> list[int]:
        """How often it is still refused, on a computer with Windows."""
        left = [2]
        replace = Path.replace

        def busy(self: Path, target: Path) -> Path:
            if left[0] > 0:
                left[0] -= 1
                raise PermissionError(13, "in use", str(target))
            return replace(self, target)

        monkeypatch.setattr(Path, "replace", busy)
        monkeypatch.setattr(_durable, "_WINDOWS", True)
        monkeypatch.setattr(_durable, "_BUSY_S", 0.4)
        return left

    def test_it_is_asked_again(self, refused: list[int], tmp_path: Path) -> None:
        """Once the reader is done the new file is there, whole."""
        path = tmp_path / "investigation.json"
        path.write_text("before")
        _durable.write_whole(path, "after")
        assert (path.read_text(), refused) == ("after", [0])

    def test_not_for_ever(self, refused: list[int], tmp_path: Path) -> None:
        """Who goes on reading is named as what the system says, and what was there stays."""
        refused[0] = 10**6
        path = tmp_path / "investigation.json"
        path.write_text("before")
        with pytest.raises(PermissionError):
            _durable.write_whole(path, "after")
        assert [(entry.name, entry.read_text()) for entry in tmp_path.iterdir()] == [(path.name, "before")]

    def test_elsewhere_a_refusal_is_one(
        self, refused: list[int], monkeypatch: pytest.MonkeyPatch, tmp_path: Path
    ) -> None:
        """Where names have nothing to do with who reads a file, it is not asked again."""
        monkeypatch.setattr(_durable, "_WINDOWS", False)
        with pytest.raises(PermissionError):
            _durable.write_whole(tmp_path / "a.json", "after")
        assert refused == [1]
