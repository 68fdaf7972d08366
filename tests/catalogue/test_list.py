"""Runs as a table: what it says, and that every change is seen without reading what did not change."""

import os
import shutil
from pathlib import Path
from typing import Any

import pandas as pd
import pytest

from labrig import LabrigError
from labrig.catalogue import list_runs, note, runs, tag, write_parquet
from labrig.log import find_runs, run_id


def named(folder: Path) -> list[str]:
    """The names of the runs that are listed."""
    return [row.run for row in list_runs(folder)]


def test_a_run_is_a_row(shelf: Path) -> None:
    """When, rig, operator, procedure, captures, size and state are those of the log."""
    table = runs(shelf).set_index("run")
    assert list(table.index) == ["monday", "tuesday"]
    tuesday = table.loc["tuesday"]
    assert tuesday["started"] == pd.Timestamp("2026-07-02 10:00", tz="UTC")
    assert list(tuesday[["rig", "operator", "procedure", "state"]]) == [
        "bench",
        "ada",
        "capture",
        "completed",
    ]
    assert list(tuesday[["captures", "planned", "warnings"]]) == [5, 5, 0]
    size_mb = (shelf / "tuesday" / "log.000.mcap").stat().st_size / 1e6
    assert tuesday["size_mb"] == size_mb
    assert tuesday["length_s"] == pytest.approx(4.0)
    assert pd.isna(tuesday["error"])
    assert list(table["tags"]) == [[], []]


def test_runs_lie_in_the_folder_runs(shelf: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    """Where labrig.run puts them, and where no folder is named."""
    shelf.rename(shelf.with_name("runs"))
    monkeypatch.chdir(shelf.parent)
    assert list(runs()["run"]) == ["monday", "tuesday"]


def test_nothing_is_read_twice(shelf: Path, opened: list[str]) -> None:
    """A second listing opens no log, and says the same."""
    first = list_runs(shelf)
    assert opened == ["monday", "tuesday"]
    opened.clear()
    assert list_runs(shelf) == first
    assert opened == []


def test_every_change_of_the_runs_is_seen(shelf: Path, opened: list[str], make_run) -> None:
    """A log that grew, a run that was added, removed, moved or replaced: only that one is read again."""
    list_runs(shelf)
    opened.clear()
    with (shelf / "monday" / "log.000.mcap").open("ab") as file:
        file.write(b"\x00" * 9)
    list_runs(shelf)
    assert opened == ["monday"]
    make_run(shelf / "group" / "wednesday", 3, number=2)
    assert named(shelf) == ["monday", "tuesday", "group/wednesday"]
    shutil.rmtree(shelf / "monday")
    assert named(shelf) == ["tuesday", "group/wednesday"]
    (shelf / "tuesday").rename(shelf / "renamed")
    assert named(shelf) == ["renamed", "group/wednesday"]
    shutil.rmtree(shelf / "renamed")
    (shelf / "group" / "wednesday").rename(shelf / "renamed")
    opened.clear()
    assert [(row.run, row.captures) for row in list_runs(shelf)] == [("renamed", 3)]
    assert opened == ["renamed"]


def test_a_second_session_and_a_new_run_yaml_are_changes(shelf: Path, opened: list[str]) -> None:
    """A run that was resumed, or whose run.yaml was put right, is read again."""
    list_runs(shelf)
    for name in ("log.001.mcap", "run.yaml"):
        opened.clear()
        (shelf / "monday" / name).write_bytes(b"")
        list_runs(shelf)
        assert opened == ["monday"]


def test_the_catalogue_finds_what_find_runs_finds(shelf: Path, make_run) -> None:
    """The runs are those of `labrig.log.find_runs`, in the same order."""
    make_run(shelf / "a" / "deep", number=3)
    make_run(shelf / "a" / "too" / "deep", number=4)
    (shelf / "empty").mkdir()
    assert [shelf / name for name in named(shelf)] == find_runs(shelf)


def test_a_run_by_itself_is_listed_and_left_alone(shelf: Path) -> None:
    """Nothing is written into a run's own folder."""
    before = sorted(path.name for path in (shelf / "monday").iterdir())
    assert named(shelf / "monday") == ["."]
    assert sorted(path.name for path in (shelf / "monday").iterdir()) == before


def test_a_run_that_cannot_be_read_says_why(shelf: Path, opened: list[str]) -> None:
    """It is a row all the same, and is tried again each time."""
    (shelf / "monday" / "log.000.mcap").write_bytes(b"no log")
    for _ in range(2):
        opened.clear()
        monday, tuesday = list_runs(shelf)
        assert monday.state.startswith("unreadable: ")
        assert tuesday.state == "completed"
        assert "monday" in opened


def test_odd_facts_do_no_harm(shelf: Path, make_run) -> None:
    """What run.yaml may hold when people or other programs wrote it is left out where it means nothing."""
    make_run(shelf / "odd", number=5, rig=None, started="yesterday", operator=7, captures=1)
    make_run(shelf / "odder", number=6)
    odd = next(row for row in list_runs(shelf) if row.run == "odd")
    assert (odd.rig, odd.started, odd.operator) == ("", "", "7")
    assert len(runs(shelf)) == 4


def test_a_listing_that_is_interrupted_keeps_what_it_has_read(
    shelf: Path, opened: list[str], monkeypatch: pytest.MonkeyPatch
) -> None:
    """After Ctrl-C the next listing goes on from there."""

    def stop(done: int, total: int) -> None:
        assert total == 2
        if done == 1:
            raise KeyboardInterrupt

    with pytest.raises(KeyboardInterrupt):
        list_runs(shelf, progress=stop)
    opened.clear()
    assert named(shelf) == ["monday", "tuesday"]
    assert opened == ["tuesday"]


@pytest.mark.parametrize("place", ["runs/monday/diagnosis", "runs/found", "diagnosis", "."])
def test_a_diagnosis_is_beside_its_run(shelf: Path, place: str, make_result) -> None:
    """In the run, among the runs, in a folder beside them, where commands write by default: it finds its run."""
    make_result(shelf.parent / place / "diagnosis.json", shelf / "monday")
    monday, tuesday = list_runs(shelf)
    assert (monday.verdict, monday.error, monday.floor, monday.units) == ("identified", 2.0, 0.1, "mm")
    assert monday.model == "model.yaml"
    assert (shelf / monday.result).samefile(shelf.parent / place / "diagnosis.json")
    assert (tuesday.verdict, tuesday.error, tuesday.result) == ("", None, "")


def test_the_diagnosis_of_a_run_two_levels_below_is_found(shelf: Path, make_result) -> None:
    """In a folder of the run's, where the workbench writes it: as deep as runs lie, their results are known."""
    make_result(shelf / "monday" / "model" / "diagnosis.json", shelf / "monday")
    lab = shelf.parent
    (deep,) = (row for row in list_runs(lab) if row.run == f"{shelf.name}/monday")
    assert (deep.verdict, deep.error) == ("identified", 2.0)
    assert (lab / deep.result).samefile(shelf / "monday" / "model" / "diagnosis.json")


def test_the_newest_diagnosis_counts(shelf: Path, make_result) -> None:
    """Of two diagnoses the one written last; a comparison only where there is no diagnosis."""
    kept = make_result(shelf / "a" / "compare.json", shelf / "monday", None)
    assert (list_runs(shelf)[0].error, list_runs(shelf)[0].verdict) == (1.5, "")
    old = make_result(shelf / "b" / "diagnosis.json", shelf / "monday", "unknown")
    new = make_result(shelf / "c" / "diagnosis.json", shelf / "monday", "confounded")
    for path, time_s in ((new, 2e9), (old, 1.9e9), (kept, 2.1e9)):
        os.utime(path, (time_s, time_s))
    assert list_runs(shelf)[0].verdict == "confounded"
    new.unlink()
    assert list_runs(shelf)[0].verdict == "unknown"
    old.unlink()
    assert list_runs(shelf)[0].result == "a/compare.json"
    kept.unlink()
    assert list_runs(shelf)[0].result == ""


@pytest.mark.parametrize(("captures", "verdict"), [(5, "identified"), (4, ""), ("five", "identified")])
def test_what_was_found_of_the_first_captures_is_not_listed(
    shelf: Path, captures: Any, verdict: str, make_result
) -> None:
    """A run that was gone on with has captures that its diagnosis knows nothing of; also from the index."""
    about = [{"run": "tuesday", "id": run_id(shelf / "tuesday"), "captures": captures}]
    make_result(shelf / "diagnosis.json", shelf / "tuesday", runs=about)
    for _ in range(2):
        assert list_runs(shelf)[1].verdict == verdict


def test_a_copy_of_a_run_has_its_results(shelf: Path, make_result) -> None:
    """What a result is about is recognised under any name."""
    make_result(shelf / "diagnosis.json", shelf / "monday")
    shutil.copytree(shelf / "monday", shelf / "copied")
    assert [row.run for row in list_runs(shelf, "verdict == 'identified'")] == ["copied", "monday"]


@pytest.mark.parametrize(
    "text",
    [
        "",
        "[]",
        "{",
        '{"error": 1}',
        '{"error": {}, "runs": 7}',
        '{"error": {}, "runs": [1]}',
        "[" * 100_000,
        "\xff",
    ],
)
def test_a_foreign_result_is_about_nothing(shelf: Path, text: str) -> None:
    """A file of that name that is not labrig's, or damaged, does no harm."""
    (shelf / "diagnosis.json").write_text(text, encoding="latin-1")
    assert [row.result for row in list_runs(shelf)] == ["", ""]


def test_a_parquet_file_holds_everything(shelf: Path, tmp_path: Path) -> None:
    """The columns of the table, tags as lists, come back from Parquet."""
    tag(shelf / "monday", ["good", "wet"])
    note(shelf / "monday", "a note")
    write_parquet(list_runs(shelf), tmp_path / "runs.parquet")
    back = pd.read_parquet(tmp_path / "runs.parquet")
    assert list(back.columns) == list(runs(shelf).columns)
    assert [list(tags) for tags in back["tags"]] == [["good", "wet"], []]
    assert back["started"].equals(runs(shelf)["started"].astype(back["started"].dtype))
    assert sorted(path.name for path in tmp_path.iterdir()) == ["runs", "runs.parquet"]


def test_a_missing_pyarrow_is_named(shelf: Path, tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    """One line says what to install, and nothing is written."""

    def absent(*_: object, **__: object) -> None:
        raise ImportError

    monkeypatch.setattr(pd.DataFrame, "to_parquet", absent)
    with pytest.raises(LabrigError, match="pip install pyarrow"):
        write_parquet(list_runs(shelf), tmp_path / "runs.parquet")
    assert not (tmp_path / "runs.parquet").exists()


def test_a_folder_without_runs_is_an_empty_table(tmp_path: Path) -> None:
    """It has the same columns and no rows, and nothing is written into it; a folder that is none is an error."""
    (tmp_path / "none").mkdir()
    table = runs(tmp_path / "none")
    assert len(table) == 0
    assert str(table["started"].dtype).endswith("UTC]")
    assert list((tmp_path / "none").iterdir()) == []
    with pytest.raises(LabrigError, match="is not a folder"):
        runs(tmp_path / "nowhere")
