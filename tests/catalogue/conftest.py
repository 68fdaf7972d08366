"""Small runs, and results about them, in a folder of runs."""

import json
import subprocess
import sys
from collections.abc import Callable
from pathlib import Path
from typing import Any
from unittest import mock

import pytest

from labrig.log import Layout, LogWriter, Topic, run_id
from labrig_schema.step_pb2 import Step

START_S = 1_785_000_000.0


KILLED = """
import os, time
from labrig.catalogue import list_runs, tag

def hang(number):
    print("writing", flush=True)
    time.sleep(600)

os.fsync = hang
{work}
"""


def write_run(
    folder: Path, captures: int = 2, *, rig: str = "mannequin", number: int = 0, **facts: Any
) -> Path:
    """A run of some captures and no markers; `number` makes it another one."""
    folder.mkdir(parents=True)
    layout = Layout(("c1",), (0.0,), (60.0,), start_s=START_S + number)
    run = {
        "procedure": "capture",
        "captures": captures,
        "started": f"2026-07-{number + 1:02d}T10:00:00+00:00",
        "operator": "ada",
        "rig": {"name": rig},
        "seed": number,
        **facts,
    }
    with mock.patch("os.fsync"):
        writer = LogWriter(folder / "log.000.mcap", layout, run)
        for capture in range(captures):
            step = {"index": capture, "kind": "record", "state": Step.DONE, "step_json": "{}"}
            writer.write(Topic.STEP, START_S + number + capture, **step)
        writer.close("completed")
    return folder


def write_result(path: Path, run: Path, verdict: str | None = "identified", **changed: Any) -> Path:
    """A diagnosis.json (without a verdict: a compare.json) about a run."""
    error = {"model": 1.5, "floor": 0.1} if verdict is None else {"base": 2.0, "model": 0.3, "floor": 0.1}
    content: dict[str, Any] = {"error": error, "units": "mm", "model": "model.yaml"}
    content["runs"] = [{"run": "as it was called then", "id": run_id(run)}]
    if verdict is not None:
        content["verdict"] = verdict
    path.parent.mkdir(parents=True, exist_ok=True)
    path.write_text(json.dumps(content | changed))
    return path


@pytest.fixture
def make_run() -> Callable[..., Path]:
    """`write_run`."""
    return write_run


@pytest.fixture
def make_result() -> Callable[..., Path]:
    """`write_result`."""
    return write_result


@pytest.fixture
def shelf(tmp_path: Path) -> Path:
    """A folder with the runs monday (2 captures, rig mannequin) and tuesday (5, rig bench)."""
    folder = tmp_path / "runs"
    write_run(folder / "monday", 2, number=0)
    write_run(folder / "tuesday", 5, rig="bench", number=1)
    return folder


@pytest.fixture
def opened(monkeypatch: pytest.MonkeyPatch) -> list[str]:
    """The names of the runs whose logs were read since the test cleared this list."""
    import labrig.catalogue._list as module

    names: list[str] = []
    read = module.read_row

    def counted(folder: Path, name: str) -> Any:
        names.append(name)
        return read(folder, name)

    monkeypatch.setattr(module, "read_row", counted)
    return names


@pytest.fixture
def kill_while_writing() -> Callable[[str], None]:
    """Kills a process that has written a file, and has not yet put it in its place."""

    def kill(work: str) -> None:
        code = KILLED.format(work=work)
        with subprocess.Popen([sys.executable, "-c", code], stdout=subprocess.PIPE, text=True) as process:
            assert process.stdout is not None
            assert process.stdout.readline() == "writing\n"
            process.kill()

    return kill
