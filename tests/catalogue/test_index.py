"""The index is only a copy: whatever becomes of it, the listing is right."""

import os
import random
import shutil
import sqlite3
import sys
import threading
from contextlib import closing
from pathlib import Path

import pytest

from labrig.catalogue import INDEX, list_runs, note, tag


def partials(folder: Path) -> list[str]:
    """What writers have left over."""
    return [path.name for path in folder.iterdir() if path.name.endswith(".partial")]


def test_the_index_is_a_table_that_other_programs_read(shelf: Path, make_result) -> None:
    """SQLite itself finds the runs by their verdict, with the columns of the table."""
    make_result(shelf / "diagnosis.json", shelf / "tuesday")
    list_runs(shelf)
    with closing(sqlite3.connect(shelf / INDEX)) as connection:
        found = connection.execute("SELECT run, error FROM runs WHERE verdict = 'identified'").fetchall()
    assert found == [("tuesday", 2.0)]


@pytest.mark.parametrize("content", [b"", b"no database", b"SQLite format 3\x00" + bytes(500)])
def test_a_damaged_index_is_made_anew(shelf: Path, opened: list[str], content: bytes) -> None:
    """What is no index counts as none, and one is put in its place."""
    first = list_runs(shelf)
    (shelf / INDEX).write_bytes(content)
    assert list_runs(shelf) == first
    opened.clear()
    assert list_runs(shelf) == first
    assert opened == []


def test_no_damaged_byte_is_believed(shelf: Path, make_run) -> None:
    """Wherever bytes of the index were changed or lost, the listing is what the runs say."""
    for number in range(2, 12):
        make_run(shelf / f"run-{number}", number=number, captures=1)
    first = list_runs(shelf)
    whole = (shelf / INDEX).read_bytes()
    choose = random.Random(1)
    for _ in range(150):
        damaged = bytearray(whole[: choose.choice([len(whole), len(whole), choose.randrange(len(whole))])])
        for _ in range(choose.choice([1, 3, 30]) if damaged else 0):
            damaged[choose.randrange(len(damaged))] = choose.randrange(256)
        (shelf / INDEX).write_bytes(damaged)
        assert list_runs(shelf) == first


def test_an_index_of_another_kind_is_replaced(shelf: Path) -> None:
    """Another program's database, or one of another version of labrig's, is not read."""
    first = list_runs(shelf)
    for change in ("PRAGMA application_id=1", "PRAGMA user_version=99", "DROP TABLE results"):
        with closing(sqlite3.connect(shelf / INDEX)) as connection:
            connection.execute(change)
            connection.commit()
        assert list_runs(shelf) == first
    with closing(sqlite3.connect(shelf / INDEX)) as connection:
        connection.execute("UPDATE runs SET captures = 99")
        connection.commit()
    assert list_runs(shelf) == first


def test_an_index_that_is_lost_takes_nothing_with_it(shelf: Path) -> None:
    """Tags and notes are the run's own."""
    tag(shelf / "monday", ["good"])
    first = list_runs(shelf)
    (shelf / INDEX).unlink()
    assert list_runs(shelf) == first
    assert first[0].tags == ("good",)


def test_a_copied_folder_has_an_index_that_fits(
    shelf: Path, tmp_path: Path, opened: list[str], make_result
) -> None:
    """A copy that keeps the times of its files is listed at once, and what changes in it changes in it alone."""
    make_result(shelf / "monday" / "diagnosis.json", shelf / "monday")
    tag(shelf / "monday", ["good"])
    first = list_runs(shelf)
    copied = tmp_path / "elsewhere" / "kept"
    shutil.copytree(shelf, copied)
    opened.clear()
    assert list_runs(copied) == first
    assert opened == []
    shutil.rmtree(copied / "tuesday")
    note(copied / "monday", "only here")
    assert [row.notes for row in list_runs(copied)] == ["only here"]
    assert list_runs(shelf) == first
    for path in copied.rglob("*"):
        os.utime(path, (1e9, 1e9))
    assert [row.run for row in list_runs(copied)] == ["monday"]


@pytest.mark.skipif(os.name != "posix", reason="folders that nobody may write into are made so by chmod")
def test_a_folder_that_is_read_only_is_listed(shelf: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    """No index can be written there, and none is needed."""
    (shelf).chmod(0o500)
    try:
        if os.access(shelf, os.W_OK):  # root may write everywhere: take it from the file instead

            def refuse(*_: object, **__: object) -> None:
                raise PermissionError(13, "Permission denied")

            monkeypatch.setattr(Path, "open", refuse)
        assert [row.run for row in list_runs(shelf)] == ["monday", "tuesday"]
        monkeypatch.undo()
        assert [path.name for path in sorted(shelf.iterdir())] == ["monday", "tuesday"]
    finally:
        shelf.chmod(0o700)


@pytest.mark.parametrize("where", ["replace", "fsync", "connect"])
def test_an_index_that_cannot_be_written_is_no_error(
    shelf: Path, monkeypatch: pytest.MonkeyPatch, where: str
) -> None:
    """A full disk, a file that another process holds (Windows), a drive that knows no locks: the listing is made."""

    def refuse(*_: object, **__: object) -> None:
        raise sqlite3.OperationalError("locked") if where == "connect" else OSError(28, "No space left")

    owner = {"replace": Path, "fsync": os, "connect": sqlite3}[where]
    monkeypatch.setattr(owner, where, refuse)
    assert [row.run for row in list_runs(shelf)] == ["monday", "tuesday"]
    monkeypatch.undo()
    assert [path.name for path in sorted(shelf.iterdir())] == ["monday", "tuesday"]


def test_a_folder_in_the_place_of_the_index_is_left_alone(shelf: Path) -> None:
    """What can't be replaced stays, and the listing is made without it."""
    (shelf / INDEX).mkdir()
    assert [row.run for row in list_runs(shelf)] == ["monday", "tuesday"]
    assert (shelf / INDEX).is_dir()
    assert partials(shelf) == []


def test_a_writer_that_is_killed_leaves_the_old_index(
    shelf: Path, opened: list[str], make_run, kill_while_writing
) -> None:
    """The next listing is whole, and what the killed one left is removed once it is old."""
    first = list_runs(shelf)
    old = (shelf / INDEX).read_bytes()
    make_run(shelf / "wednesday", number=3)
    kill_while_writing(f"list_runs({str(shelf)!r})")
    assert (shelf / INDEX).read_bytes() == old
    (left,) = partials(shelf)
    opened.clear()
    assert list_runs(shelf)[:2] == first
    assert opened == ["wednesday"]
    assert partials(shelf) == [left]
    os.utime(shelf / left, (1e9, 1e9))
    shutil.rmtree(shelf / "wednesday")
    assert list_runs(shelf) == first
    assert partials(shelf) == []


def test_two_who_list_at_once_both_get_everything(shelf: Path, make_run) -> None:
    """Whoever writes the index last, each listing is whole and so is the index."""
    for number in range(2, 8):
        make_run(shelf / f"run-{number}", number=number)
    wanted = list_runs(shelf)
    wrong: list[object] = []

    def often(seed: int) -> None:
        choose = random.Random(seed)
        for _ in range(15):
            if choose.random() < 0.3:
                (shelf / INDEX).unlink(missing_ok=True)
            rows = list_runs(shelf)
            if rows != wanted:
                wrong.append(rows)

    threads = [threading.Thread(target=often, args=(seed,)) for seed in range(4)]
    for thread in threads:
        thread.start()
    for thread in threads:
        thread.join()
    assert wrong == []
    assert list_runs(shelf) == wanted
    assert partials(shelf) == []


@pytest.mark.skipif(sys.platform != "linux", reason="only Linux has names of files that are no text")
def test_a_name_that_is_no_text_is_listed(shelf: Path) -> None:
    """A folder whose name is not UTF-8 is a run like others; the index does without it."""
    (shelf / "monday").rename(shelf / os.fsdecode(b"m\xff"))
    for _ in range(2):
        assert [row.captures for row in list_runs(shelf)] == [2, 5]
