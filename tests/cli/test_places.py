"""Where commands write: a place that is of no use is said in one line before any work, whichever command it is."""

import errno
import os
from collections.abc import Callable
from pathlib import Path

import pytest

Run = Callable[..., tuple[int, str, str]]

FOLDERS = [
    (("compare", "run", "--model", "model.yaml"), "--out"),
    (("diagnose", "run", "--model", "model.yaml"), "--out"),
    (("improve", "run", "--model", "model.yaml", "--add", "creep", "-o", "new.yaml"), "--out"),
    (("next", "run", "--model", "model.yaml", "--rig", "rig.yaml", "-o", "next.yaml"), "--out"),
    (("investigate", "--model", "model.yaml", "--rig", "rig.yaml"), "--out"),
    (("run", "capture", "--rig", "rig.yaml"), "--out"),
    (("simulate", "mannequin"), "--out"),
    (("train", "forward", "sims", "-o", "f.pt"), "--out"),
    (("train", "sim2real", "run", "--forward", "f.pt", "-o", "s.pt"), "--out"),
    (("ik", "target.ply", "--model", "model.yaml"), "--out"),
    (("validate", "target.ply", "--rig", "rig.yaml", "--model", "model.yaml"), "--out"),
    (("bench", "draw"), "--out"),
    (("bench", "blind"), "--out"),
    (("bench", "settle"), "--out"),
    (("rig", "simulate"), "-o"),
    (("rig", "record", "rig.yaml"), "-o"),
    (("rig", "replay", "recording"), "-o"),
]
FILES = [
    ("improve", "run", "--model", "model.yaml", "--add", "creep", "-o"),
    ("next", "run", "--model", "model.yaml", "--rig", "rig.yaml", "-o"),
    ("train", "forward", "sims", "-o"),
    ("train", "sim2real", "run", "--forward", "f.pt", "-o"),
    ("bench", "learn", "--out"),
    ("bench", "calibrate", "--out"),
    ("bench", "blind", "--out", "new", "--results"),
]
RIG = """\
name: bench
chambers: [{name: c1, max_kpa: 60}, {name: c2, max_kpa: 60}, {name: c3, max_kpa: 60}, {name: c4, max_kpa: 60}]
pressure: {kind: simulated}
mocap: {kind: simulated}
simulated: {surface: membrane}
"""


@pytest.fixture
def desk(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> Path:
    """A folder with a rig, a model, a target, and a file that is in the way."""
    monkeypatch.chdir(tmp_path)
    (tmp_path / "rig.yaml").write_text(RIG)
    (tmp_path / "model.yaml").write_text("base: {kind: simulator, rig: rig.yaml}\n")
    (tmp_path / "target.ply").write_text("")
    (tmp_path / "file").write_text("mine")
    return tmp_path


@pytest.mark.parametrize("words", [("--out", ""), ("--out=",)], ids=["apart", "together"])
def test_a_place_without_a_name(desk: Path, labrig: Run, words: tuple[str, ...]) -> None:
    """An empty name, as of a variable of a script that is not set, is not the current folder."""
    before = sorted(desk.iterdir())
    said = "labrig: --out is empty; name the place, or leave --out out (`.` is the current folder)\n"
    assert labrig("simulate", "membrane", "-n", "1", *words) == (2, "", said)
    assert sorted(desk.iterdir()) == before


@pytest.mark.parametrize(("words", "option"), FOLDERS, ids=lambda value: " ".join(value[:2]))
def test_a_file_in_the_way_of_a_folder(desk: Path, labrig: Run, words: tuple[str, ...], option: str) -> None:
    """A folder that is a file, or below one, is refused at once, and the file stays as it is."""
    before = sorted(desk.iterdir())
    for out, which in (("file", "this"), ("file/below/it", "file")):
        said = f"labrig: {option} {Path(out)}: {which} is a file; choose a folder\n"
        assert labrig(*words, option, out) == (2, "", said)
    assert (desk / "file").read_text() == "mine"
    assert sorted(desk.iterdir()) == before


SHORT = [words for words, option in FOLDERS if option == "--out" and "-o" not in words]


@pytest.mark.parametrize("words", SHORT, ids=lambda value: " ".join(value[:2]))
def test_a_folder_has_a_short_option(desk: Path, labrig: Run, words: tuple[str, ...]) -> None:
    """Whatever command it is, `-o` is its `--out`, where it writes no file of its own."""
    said = "labrig: --out file: this is a file; choose a folder\n"
    assert labrig(*words, "-o", "file") == (2, "", said)


@pytest.mark.parametrize(("words", "option"), FOLDERS, ids=lambda value: " ".join(value[:2]))
def test_a_folder_that_cannot_be_written(
    desk: Path,
    labrig: Run,
    monkeypatch: pytest.MonkeyPatch,
    words: tuple[str, ...],
    option: str,
) -> None:
    """A folder that the person may not write into is refused before any work."""
    locked = desk / "locked"
    locked.mkdir()
    can = os.access
    monkeypatch.setattr(os, "access", lambda path, how: Path(path).name != "locked" and can(path, how))
    out = Path("locked/new")
    said = f"labrig: {option} {out}: nothing can be written into {locked.resolve()}; choose another folder\n"
    assert labrig(*words, option, str(out)) == (2, "", said)
    assert list(locked.iterdir()) == []


@pytest.mark.parametrize("words", FILES, ids=lambda value: " ".join(value[:2]))
def test_a_file_that_cannot_be_written(desk: Path, labrig: Run, words: tuple[str, ...]) -> None:
    """A file in a folder that does not exist is refused at once, and so is a folder in its place."""
    (desk / "folder.yaml").mkdir()
    missing = Path("none/new.yaml")
    assert labrig(*words, missing) == (2, "", f"labrig: {missing}: the folder none does not exist\n")
    code, out, err = labrig(*words, "folder.yaml")
    assert (code, out) == (2, "")
    assert "folder.yaml" in err
    assert len(err.splitlines()) == 1
    assert "unexpected" not in err


@pytest.mark.parametrize(
    ("error", "said"),
    [
        (FileNotFoundError(errno.ENOENT, "No such file", "a/b"), "there is no a/b"),
        (IsADirectoryError(errno.EISDIR, "Is a directory", "a"), "a is a folder, where a file is needed"),
        (
            NotADirectoryError(errno.ENOTDIR, "Not a directory", "a/b"),
            "a/b: a file is where a folder is needed; choose another name",
        ),
        (
            PermissionError(errno.EACCES, "Permission denied", "a"),
            "a can be neither made nor read: Permission denied; choose another place",
        ),
        (
            OSError(errno.ENOSPC, "No space left on device", "out/compare.json"),
            "out/compare.json cannot be written: No space left on device; make room there, or choose another place",
        ),
        (OSError(errno.ENOSPC, "No space left on device"), "No space left on device; --debug says where"),
    ],
)
def test_no_path_is_unexpected(
    labrig: Run, monkeypatch: pytest.MonkeyPatch, error: OSError, said: str
) -> None:
    """What the system says of a path while a command works is one line with the path, exit code 2."""
    import labrig.cli._run_tables as tables

    def fail(*_: object) -> None:
        raise error

    monkeypatch.setattr(tables, "print_runs", fail)
    assert labrig("runs") == (2, "", f"labrig: {said}\n")


def test_what_is_replaced_is_said(desk: Path, labrig: Run) -> None:
    """A second result in the same folder takes the place of the first one, and says so."""
    run = ("run", "capture", "--rig", "rig.yaml", "--captures", "8", "--repeated", "0", "--out", "one")
    assert labrig(*run)[0] == 0
    report = Path("compare/report.html")
    first = labrig("compare", "one", "--model", "model.yaml")[1].splitlines()[-1]
    again = labrig("compare", "one", "--model", "model.yaml")[1].splitlines()[-1]
    assert first == f"report: {report}"
    assert again == f"report: {report} (replaces the one that was there)"
