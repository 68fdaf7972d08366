"""Files of results and models: whole, or as they were before."""

from concurrent.futures import ThreadPoolExecutor
from pathlib import Path
from typing import Any

import pytest

from labrig._durable import write_new, write_whole


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


def test_threads_that_write_one_file_leave_it_whole(tmp_path: Path) -> None:
    """Whoever reads while several threads write the same file finds what one of them wrote, whole."""
    path = tmp_path / "found.json"
    texts = ["a" * 400_000, "b"]
    write_whole(path, texts[1])
    with ThreadPoolExecutor(3) as pool:
        writing = [pool.submit(write_whole, path, texts[number % 2]) for number in range(40)]
        read = {path.read_text(encoding="utf-8") for _ in range(200)}
        for one in writing:
            one.result()
    assert read <= set(texts)
    assert list(tmp_path.iterdir()) == [path]


@pytest.mark.parametrize("links", [True, False])
def test_a_new_file_is_never_over_another_nor_empty(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch, links: bool
) -> None:
    """A name that is taken stays as it is; a new one has its whole content from the first, where links exist."""
    if not links:
        monkeypatch.setattr(Path, "hardlink_to", refused)
    write_new(tmp_path / "rig.yaml", "mine")
    with pytest.raises(FileExistsError):
        write_new(tmp_path / "rig.yaml", "other")
    assert (tmp_path / "rig.yaml").read_text(encoding="utf-8") == "mine"
    assert list(tmp_path.iterdir()) == [tmp_path / "rig.yaml"]


def refused(*_: object) -> None:
    """A file system without links."""
    raise OSError(1, "Operation not permitted")


def test_a_power_cut_leaves_a_new_file_whole_or_none(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    """As long as the content is not on the disk there is no file of that name."""
    seen: list[bool] = []
    monkeypatch.setattr("os.fsync", lambda _number: seen.append((tmp_path / "rig.yaml").exists()))
    write_new(tmp_path / "rig.yaml", "name: mine\n")
    assert seen[0] is False


def test_a_new_file_that_fails_at_the_last_takes_no_name(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    """Where links are unknown and the rename fails, too, nothing is left, and the next try finds the name free."""
    monkeypatch.setattr(Path, "hardlink_to", refused)
    monkeypatch.setattr(Path, "replace", refused)
    with pytest.raises(OSError, match="Operation not permitted"):
        write_new(tmp_path / "rig.yaml", "mine")
    assert list(tmp_path.iterdir()) == []
