"""Files of results and models: whole, or as they were before."""

from pathlib import Path
from typing import Any

import pytest

from labrig._durable import write_whole


def test_a_file_that_was_written_survives_a_power_cut(disk: Any, tmp_path: Path) -> None:
    """A model or a result is on the disk, under its name, once it is said to be written; so is what replaces it."""
    folder = tmp_path / "lab"
    folder.mkdir()
    for text in ("base: {kind: static}\n", "base: {kind: static, degree: 2}\n"):
        write_whole(folder / "model.yaml", text)
        left = disk.cut(folder, tmp_path / f"left {len(text)}")
        assert (left / "model.yaml").read_text(encoding="utf-8") == text


def test_a_disk_that_fails_leaves_the_file_of_before(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    """Where the disk does not take the content, the error names the file, which is as it was, and alone."""
    path = tmp_path / "model.yaml"
    path.write_text("before", encoding="utf-8")

    def full(_number: int) -> None:
        raise OSError(28, "No space left on device")

    monkeypatch.setattr("os.fsync", full)
    with pytest.raises(OSError, match=r"No space left on device: '.*model\.yaml'"):
        write_whole(path, "after")
    assert path.read_text(encoding="utf-8") == "before"
    assert list(tmp_path.iterdir()) == [path]
