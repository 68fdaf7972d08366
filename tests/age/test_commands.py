"""labrig history, labrig check, and the line before a campaign."""

import shutil
from collections.abc import Callable
from pathlib import Path

import pytest
import yaml

from labrig.campaign._session import Session
from labrig.catalogue import list_runs
from labrig_drivers import DeviceError

Typed = Callable[..., tuple[int, str, str]]


@pytest.fixture
def here(aged: Path, monkeypatch: pytest.MonkeyPatch, tmp_path: Path) -> Path:
    """A working folder with the files of the rig that aged."""
    for name in ("rig.yaml", "model.yaml", "base.yaml"):
        (tmp_path / name).write_text((aged / name).read_text(encoding="utf-8"), encoding="utf-8")
    monkeypatch.chdir(tmp_path)
    return tmp_path


def test_history_says_what_changed_and_writes_the_report(labrig: Typed, here: Path, aged: Path) -> None:
    """A table, a line for each change with the day on which it was noticed, and the report's path."""
    code, out, err = labrig("history", "rig.yaml", "--model", "model.yaml", "--runs", aged / "runs")
    assert (code, err) == (0, "")
    lines = out.splitlines()
    assert any(line.startswith("creep went") and "(noticed 2026-02-" in line for line in lines)
    assert lines[-1] == f"report: {Path('history/report.html')}"
    assert {path.name for path in (here / "history").iterdir()} == {
        "history.json",
        "history.png",
        "report.html",
    }


def test_history_complains_in_one_line(labrig: Typed, here: Path, aged: Path) -> None:
    """Of a rig that has no runs, a folder that is not there, and a model that is none; nothing is written."""
    for words in (
        ("history", "nobody", "--model", "model.yaml", "--runs", aged / "runs"),
        ("history", "bench", "--model", "model.yaml", "--runs", "nowhere"),
        ("history", "bench", "--model", "rig.yaml", "--runs", aged / "runs"),
    ):
        code, out, err = labrig(*words)
        assert code != 0
        assert out == ""
        assert err.startswith("labrig: ")
        assert err.count("\n") == 1
    assert not (here / "history").exists()


def test_check_records_a_run_and_adds_it_to_the_history(labrig: Typed, here: Path) -> None:
    """The run is an ordinary one with the tag check; nothing has changed after two of them."""
    options = ("--points", 2, "--visits", 2, "--hold-s", 20, "--recovery-s", 5)
    for number in (1, 2):
        code, out, err = labrig("check", "--rig", "rig.yaml", "--model", "base.yaml", *options)
        assert (code, err) == (0, "")
        assert f"{number} run{'s' if number > 1 else ''} of bench" in out
        assert "report: " in out
    rows = list_runs(here / "runs", "'check' in tags")
    assert len(rows) == 2
    assert {row.procedure for row in rows} == {"check"}
    assert {row.state for row in rows} == {"completed"}


def test_a_check_that_was_interrupted_goes_on_and_concludes(
    labrig: Typed, here: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    """The error has the command that goes on with it; that one tags the run and says what it and others say."""
    options = ("--points", 2, "--visits", 2, "--hold-s", 20, "--recovery-s", 5)
    wait, waited = Session.wait_until, []

    def broken(session: Session, time_s: float) -> None:
        waited.extend([time_s] * bool(session.folder))  # a plan is gone through before, without one
        if len(waited) == 12:
            raise DeviceError("mocap: no frame for 5 s")
        wait(session, time_s)

    monkeypatch.setattr(Session, "wait_until", broken)
    code, out, err = labrig("check", "--rig", "rig.yaml", "--model", "base.yaml", "--out", "aged", *options)
    assert (code, out) == (3, "")
    (row,) = list_runs(here / "runs")
    command = f"labrig check --rig rig.yaml --model base.yaml --out aged --resume {Path('runs') / row.run}"
    assert err.rstrip().endswith(f"to resume: {command}")
    monkeypatch.undo()
    monkeypatch.chdir(here)
    code, out, err = labrig(*command.split()[1:])
    assert (code, err) == (0, "labrig: resumed after 8 completed steps\n")
    assert "1 run of bench" in out
    assert f"report: {Path('aged/report.html')}" in out
    (row,) = list_runs(here / "runs", "'check' in tags")
    assert row.state == "completed"


def test_only_a_check_goes_on_as_one(labrig: Typed, here: Path) -> None:
    """Another procedure's run, and parameters beside a run that has its own, are refused in one line."""
    files = ("--rig", "rig.yaml", "--model", "base.yaml")
    run = Path("runs/other")
    assert labrig("run", "capture", "--captures", 2, "--rig", "rig.yaml", "--out", run)[0] == 0
    code, _, err = labrig("check", *files, "--resume", run)
    assert code == 2
    assert err == f"labrig: {run} is no check but a capture; to resume: labrig run --resume {run}\n"
    code, _, err = labrig("check", *files, "--resume", run, "--points", 2)
    assert code == 2
    assert err == (
        "labrig: --resume goes on with what the check was; it takes no parameters and no --realtime\n"
    )


def test_check_stops_before_the_rig_moves_where_the_model_is_none(labrig: Typed, here: Path) -> None:
    """One line, and no run."""
    code, _, err = labrig("check", "--rig", "rig.yaml", "--model", "rig.yaml")
    assert code != 0
    assert err.count("\n") == 1
    assert not (here / "runs").exists()


def test_a_campaign_says_first_that_the_rig_is_another(labrig: Typed, here: Path, aged: Path) -> None:
    """One line on the error stream, with what changed; without a model, or for another rig, nothing is said."""
    runs = here / "runs"
    shutil.copytree(aged / "runs", runs)
    assert labrig("history", "bench", "--model", "model.yaml")[0] == 0
    run = ("run", "capture", "--captures", 2, "--rig", "rig.yaml")
    code, _, err = labrig(*run, "--model", "model.yaml", "--out", runs / "new")
    assert code == 0
    (line,) = err.splitlines()
    assert line.startswith("labrig: rig bench is not what model.yaml was fitted to: ")
    assert "creep" in line
    code, _, err = labrig(*run, "--out", runs / "newer")
    assert (code, err) == (0, "")
    other = yaml.safe_load((here / "rig.yaml").read_text(encoding="utf-8")) | {"name": "another"}
    (here / "other.yaml").write_text(yaml.safe_dump(other), encoding="utf-8")
    run = ("run", "capture", "--captures", 2, "--rig", "other.yaml")
    code, _, err = labrig(*run, "--model", "model.yaml", "--out", runs / "others")
    assert (code, err) == (0, "")
