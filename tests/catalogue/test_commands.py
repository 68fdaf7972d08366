"""labrig runs, tag and note, as a person types them; and that a diagnosis is shown beside its run."""

import json
import re
from collections.abc import Callable
from pathlib import Path

import pandas as pd
import pytest

from labrig import open_run
from labrig.catalogue import COLUMNS, list_runs
from labrig.diagnosis import compare, improve
from labrig.log import write_dataset
from labrig.model import Model

Run = Callable[..., tuple[int, str, str]]
PAGE = Path(__file__).parents[2] / "docs" / "how-to" / "find-your-runs.md"


@pytest.fixture(autouse=True)
def _desk(shelf: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.chdir(shelf.parent)


def test_runs_are_lines(labrig: Run) -> None:
    """Columns stand one below the other; those that no run has are left out."""
    code, out, err = labrig("runs")
    assert (code, err) == (0, "")
    head, monday, tuesday = out.splitlines()
    assert head.split() == ["run", "started", "rig", "procedure", "captures", "length", "size", "state"]
    assert re.split("  +", monday) == [
        "monday", "2026-07-01 10:00:00", "mannequin", "capture", "2/2", "1 s", "0.0 MB", "completed",
    ]  # fmt: skip
    assert [line.index("completed") for line in (monday, tuesday)] == [head.index("state")] * 2


def test_notes_that_are_damaged_are_said(labrig: Run, shelf: Path) -> None:
    """A listing without a run's tags says so on the error stream, with the file, the line and what is wrong."""
    (shelf / "monday" / "notes.yaml").write_text("tags: good\n")
    code, out, err = labrig("runs")
    assert code == 0
    assert len(out.splitlines()) == 3
    file = Path("runs/monday/notes.yaml")
    said = f"labrig: {file}, line 1: tags: should be a list, not 'good'; its tags and notes are left out\n"
    assert err == said


def test_what_is_said_of_a_run_is_listed(labrig: Run, shelf: Path, make_result) -> None:
    """Tags, notes and results stand behind the state; a long note is shortened."""
    monday = str(Path("runs/monday"))
    assert labrig("tag", monday, "good", "wet") == (0, f"{monday}: good, wet\n", "")
    assert labrig("tag", monday, "wet", "--remove") == (0, f"{monday}: good\n", "")
    assert labrig("note", monday, "chamber 3 leaks, and so does chamber 4 a little") == (
        0,
        f"{monday}: 1 note\n",
        "",
    )
    make_result(Path("diagnosis/diagnosis.json"), shelf / "monday")
    line = labrig("runs")[1].splitlines()[1]
    assert re.split("  +", line)[-5:] == [
        "identified", "2 mm", "0.1 mm", "good", "chamber 3 leaks, and so does chamber ...",
    ]  # fmt: skip


def test_a_condition_chooses(labrig: Run, shelf: Path) -> None:
    """Only runs of which it is true; where there is none, that is said; a wrong name is one line."""
    assert [line.split()[0] for line in labrig("runs", "--where", "captures > 2")[1].splitlines()] == [
        "run",
        "tuesday",
    ]
    assert labrig("runs", "--where", "captures > 99") == (
        0,
        "no run in runs meets the condition captures > 99\n",
        "",
    )
    code, out, err = labrig("runs", "--where", "capture > 2")
    assert (code, out) == (2, "")
    assert err == (
        "labrig: where 'capture > 2': there is no column 'capture'; did you mean captures? "
        f"(columns: {', '.join(COLUMNS)})\n"
    )


def test_a_parquet_file_on_request(labrig: Run) -> None:
    """The file holds what was asked for; a place where none can be is named before anything is read."""
    out = labrig("runs", "--parquet", "all.parquet", "--where", "captures > 2")[1]
    assert out == "all.parquet: 1 run\n"
    assert list(pd.read_parquet("all.parquet")["run"]) == ["tuesday"]
    assert (
        labrig("runs", "--parquet", "all.parquet")[1]
        == "all.parquet: 2 runs (replaces the one that was there)\n"
    )
    assert labrig("runs", "--parquet", "runs") == (
        2,
        "",
        "labrig: --parquet runs: is a folder; name a file\n",
    )


def test_a_folder_without_runs_is_an_error(labrig: Run, tmp_path: Path) -> None:
    """With a condition too: one line says what to name."""
    (tmp_path / "empty").mkdir()
    for words in ((), ("--where", "captures > 2")):
        code, _, err = labrig("runs", "empty", *words)
        assert (code, err) == (
            2,
            "labrig: empty holds no runs; name the folder that does: labrig runs FOLDER\n",
        )


def test_compare_writes_what_its_run_is_found_by(labrig: Run, make_lab, tmp_path: Path) -> None:
    """A comparison in its default folder is shown beside the run in ./runs, and still after the run was renamed."""
    lab = make_lab(captures=20)
    run = write_dataset(lab.dataset(lab.predict(lab.u) + lab.noise()), Path("runs/mine"), run_yaml={})
    lab.model()
    assert labrig("compare", str(run), "--model", "model.yaml")[0] == 0
    said = json.loads(Path("compare/compare.json").read_text())
    assert said["runs"] == [{"run": "runs/mine", "id": open_run(run).attrs["run_id"], "captures": 20}]
    assert said["model"] == "model.yaml"
    run.rename("runs/yours")
    (row,) = list_runs("runs", "run == 'yours'")
    assert (row.model, row.result, row.verdict) == ("model.yaml", "../compare/compare.json", "")
    assert (row.error, row.floor) == (said["error"]["model"], said["error"]["floor"])


def test_a_result_says_what_it_is_about(make_lab) -> None:
    """Several runs, in their order; what is no file, a dataset or a model that was never saved, is not named."""
    lab = make_lab(captures=40)
    data, model = lab.dataset(lab.predict(lab.u) + lab.noise()), lab.model()
    runs = [open_run(write_dataset(data, Path(name), run_yaml={})) for name in ("one", "two")]
    summary = compare(runs, model).summary
    assert [each["run"] for each in summary["runs"]] == ["one", "two"]
    assert summary["model"].endswith("model.yaml")
    better = improve(runs, Model.load("model.yaml"), ["hysteresis"], force=True)
    assert better.summary["model"] == "model.yaml"
    assert better.improved is not None
    about = compare(data, better.improved).summary
    assert (about["runs"], about["model"]) == ([], None)


def test_the_page_has_every_column() -> None:
    """docs/how-to/find-your-runs.md explains the columns that there are, and no others."""
    first = re.findall(r"^\| (`.*?) \| .* \|$", PAGE.read_text("utf-8"), re.MULTILINE)
    assert set(re.findall(r"`(\w+)`", " ".join(first))) == set(COLUMNS)


def test_the_pages_conditions_mean_something(labrig: Run) -> None:
    """Each condition of the page is one that `labrig runs` takes."""
    conditions = re.findall(r'--where "(.*)"$', PAGE.read_text("utf-8"), re.MULTILINE)
    assert len(conditions) == 4
    for condition in conditions:
        assert labrig("runs", "--where", condition)[0] == 0, condition
