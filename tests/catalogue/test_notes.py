"""Tags and notes: in the run's folder, whole or not at all, and no two writers lose each other's."""

import os
import shutil
import subprocess
import sys
import threading
from pathlib import Path

import pytest
import yaml

from labrig import LabrigError
from labrig.catalogue import list_runs, note, read_notes, tag
from labrig.log import recover


def test_tags_and_notes_are_kept_in_the_run(shelf: Path, opened: list[str]) -> None:
    """They stand in notes.yaml as a person would write it, and in the table, for which no log is read again."""
    monday = shelf / "monday"
    list_runs(shelf)
    opened.clear()
    tag(monday, ["good", "wet"])
    tag(monday, ["good", "später"])
    note(monday, "chamber 3 leaks: from noon on")
    note(monday, "  repaired ")
    assert yaml.safe_load((monday / "notes.yaml").read_text(encoding="utf-8")) == {
        "tags": ["good", "wet", "später"],
        "notes": ["chamber 3 leaks: from noon on", "repaired"],
    }
    row = list_runs(shelf)[0]
    assert (row.tags, row.notes) == (("good", "wet", "später"), "chamber 3 leaks: from noon on\nrepaired")
    tag(monday, ["wet"], remove=True)
    assert list_runs(shelf)[0].tags == ("good", "später")
    assert opened == []


def test_they_go_where_the_run_goes(shelf: Path, tmp_path: Path) -> None:
    """A copy of the folder and a recovered run have them; without notes.yaml they are gone."""
    tag(shelf / "monday", ["good"])
    shutil.copytree(shelf / "monday", tmp_path / "away" / "copy")
    recover(shelf / "monday", tmp_path / "away" / "whole")
    assert [row.tags for row in list_runs(tmp_path / "away")] == [("good",), ("good",)]
    list_runs(shelf)
    (shelf / "monday" / "notes.yaml").unlink()
    assert list_runs(shelf)[0].tags == ()


def test_what_a_person_wrote_by_hand_counts(shelf: Path) -> None:
    """A number is a word as well, and one of the two lists may be missing."""
    (shelf / "monday" / "notes.yaml").write_text("tags: [2026, good]\n")
    assert list_runs(shelf)[0].tags == ("2026", "good")


@pytest.mark.parametrize(
    ("text", "said"),
    [
        ("tags: good\n", "line 1: tags: should be a list, not 'good'"),
        ("tag: [good]\n", "line 1: tag: there is no such field; did you mean tags?"),
        ("tags: [good\n", "is not YAML"),
        ("", "is not a file of notes: it should begin with `tags: [...]`"),
    ],
)
def test_a_damaged_file_is_named_and_left_alone(shelf: Path, text: str, said: str) -> None:
    """The listing says what is wrong with it; nothing is added to it before it is mended."""
    path = shelf / "monday" / "notes.yaml"
    path.write_text(text)
    notes = list_runs(shelf)[0].notes
    assert notes.startswith(f"unreadable: {path}")
    assert said in notes
    for change in (lambda: tag(shelf / "monday", ["x"]), lambda: note(shelf / "monday", "x")):
        with pytest.raises(LabrigError) as caught:
            change()
        assert said in str(caught.value)
    assert path.read_text() == text
    assert sorted(left.name for left in (shelf / "monday").iterdir()) == ["log.000.mcap", "notes.yaml"]


@pytest.mark.parametrize("word", ["two words", "a,b", "", "it's", "x" * 61, "a\nb", "a\x07"])
def test_a_tag_is_one_word(shelf: Path, word: str) -> None:
    """Anything else is refused, and nothing is written."""
    with pytest.raises(LabrigError, match="is no tag: a tag is one word"):
        tag(shelf / "monday", ["good", word])
    assert not (shelf / "monday" / "notes.yaml").exists()


def test_what_cannot_be_done_is_said(shelf: Path) -> None:
    """A tag that is not there, an empty note, a folder that is no run: one line each, and nothing is written."""
    tag(shelf / "monday", ["good", "wet"])
    before = (shelf / "monday" / "notes.yaml").read_bytes()
    with pytest.raises(LabrigError) as caught:
        tag(shelf / "monday", ["wet", "god"], remove=True)
    assert str(caught.value).endswith("monday has no tag 'god'; did you mean good? (it has good)")
    with pytest.raises(LabrigError, match="the note is empty"):
        note(shelf / "monday", "  ")
    assert (shelf / "monday" / "notes.yaml").read_bytes() == before
    for place in (shelf, shelf / "none"):
        with pytest.raises(LabrigError, match="is no run folder; `labrig runs` lists those"):
            tag(place, ["good"])
    with pytest.raises(LabrigError, match="is one file, and what is said of a run is kept in its folder"):
        tag(shelf / "monday" / "log.000.mcap", ["good"])
    assert not (shelf / "notes.yaml").exists()


def test_two_who_write_at_once_lose_nothing(shelf: Path) -> None:
    """Every tag and every note of several writers is there in the end."""

    def write(number: int) -> None:
        for k in range(5):
            tag(shelf / "monday", [f"t{number}-{k}"])
            note(shelf / "monday", f"n{number}-{k}")

    threads = [threading.Thread(target=write, args=(number,)) for number in range(4)]
    for thread in threads:
        thread.start()
    for thread in threads:
        thread.join()
    kept = read_notes(shelf / "monday")
    assert sorted(kept.tags) == [f"t{n}-{k}" for n in range(4) for k in range(5)]
    assert sorted(kept.notes) == [f"n{n}-{k}" for n in range(4) for k in range(5)]


def test_a_writer_that_is_killed_holds_nobody_up_for_long(shelf: Path, kill_while_writing) -> None:
    """The file is as it was before, and the next one writes at once."""
    tag(shelf / "monday", ["first"])
    kill_while_writing(f"tag({str(shelf / 'monday')!r}, ['killed'])")
    assert read_notes(shelf / "monday").tags == ["first"]
    assert [row.tags for row in list_runs(shelf)] == [("first",), ()]
    tag(shelf / "monday", ["second"])
    assert read_notes(shelf / "monday").tags == ["first", "second"]
    assert sorted(path.name for path in (shelf / "monday").iterdir()) == ["log.000.mcap", "notes.yaml"]


def test_a_disk_that_is_full_leaves_the_old_file(shelf: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    """Nothing is written by half, and the error names the file."""
    tag(shelf / "monday", ["first"])

    def full(number: int) -> None:
        raise OSError(28, "No space left on device")

    monkeypatch.setattr(os, "fsync", full)
    with pytest.raises(OSError, match="No space left") as caught:
        tag(shelf / "monday", ["second"])
    monkeypatch.undo()
    assert caught.value.filename == str(shelf / "monday" / "notes.yaml")
    assert read_notes(shelf / "monday").tags == ["first"]
    assert sorted(left.name for left in (shelf / "monday").iterdir()) == ["log.000.mcap", "notes.yaml"]


def test_a_run_that_cannot_be_written_says_so(shelf: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    """On a drive that is read-only one line says that tags belong into the run's folder."""

    def refuse(*_: object, **__: object) -> None:
        raise PermissionError(13, "Permission denied")

    monkeypatch.setattr(Path, "touch", refuse)
    with pytest.raises(
        LabrigError, match=r"monday: nothing can be written there \(Permission denied\), and a run's"
    ):
        tag(shelf / "monday", ["good"])


HOLDS = """
import sys, time
from labrig.catalogue import _notes
from pathlib import Path
with _notes._changed(Path(sys.argv[1])) as notes:
    print("has it", flush=True)
    sys.stdin.readline()
    notes.tags.append("slow")
"""


def test_nobody_is_overtaken_however_slow(shelf: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    """Another process that takes its time keeps its turn: who comes meanwhile waits, and says so in the end."""
    monkeypatch.setattr("labrig.catalogue._notes._WAIT_S", 0.2)
    command = [sys.executable, "-c", HOLDS, str(shelf / "monday")]
    with subprocess.Popen(command, stdin=subprocess.PIPE, stdout=subprocess.PIPE, text=True) as slow:
        assert slow.stdout is not None
        assert slow.stdout.readline() == "has it\n"
        with pytest.raises(LabrigError, match=r"monday: another process is changing its notes; try again"):
            tag(shelf / "monday", ["quick"])
        slow.communicate("\n", timeout=60)
    tag(shelf / "monday", ["quick"])
    assert read_notes(shelf / "monday").tags == ["slow", "quick"]
