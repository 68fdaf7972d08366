"""The looker's own side, on a run of a simulated rig."""

import json
import subprocess
import sys
from collections.abc import Callable
from pathlib import Path
from typing import Any

import pytest
import yaml

from labrig import open_run
from labrig.live import RECORD, Look, serve
from labrig.rig import RigConfig

from .conftest import RIG

MODEL = "base: {kind: simulator, rig: rig.yaml}\neffects: []\n"
Command = Callable[..., tuple[int, str, str]]


@pytest.fixture
def measured(config: RigConfig, tmp_path: Path) -> Path:
    """A finished run of eight short captures, with the model beside it."""
    from labrig.campaign import run
    from labrig.rig import connect
    from labrig_drivers import SimulatedClock
    from labrig_procedures import Capture

    (tmp_path / "rig.yaml").write_text(yaml.safe_dump(RIG))
    (tmp_path / "model.yaml").write_text(MODEL)
    with connect(config, SimulatedClock()) as rig:
        run(Capture(captures=8, repeated=0, settle_s=0.5, record_s=0.2), rig, tmp_path / "run")
    return tmp_path


def test_a_look_says_keeps_and_draws_what_it_found(measured: Path) -> None:
    """A question gives a look at all that is in the log, a record in the run's folder, and a picture of all looks."""
    said: list[dict[str, Any]] = []
    drawn: list[tuple[list[int], str | None]] = []
    serve(
        measured / "run",
        measured / "model.yaml",
        ['{"captures": 8}', '{"end": "settled: all effects are out"}'],
        lambda line: said.append(json.loads(line)),
        lambda looks, ended, folder: drawn.append(([look.captures for look in looks], ended)),
    )
    look = Look.from_dict(said[0]["look"])
    assert (len(said), look.captures, look.units) == (1, 8, "mm")
    assert look.minutes == pytest.approx(float(open_run(measured / "run")["time_s"].max()) / 60)
    assert drawn == [([8], None), ([8], "settled: all effects are out")]
    kept = json.loads((measured / "run" / RECORD).read_text())
    assert kept["ended"] == "settled: all effects are out"
    assert kept["looks"][0]["captures"] == 8


def test_a_diagnosis_that_fails_is_trouble_and_the_next_is_made(measured: Path) -> None:
    """What goes wrong in one look is said, no picture is drawn, and the process goes on answering."""
    said: list[dict[str, Any]] = []

    def questions() -> Any:
        (measured / "run" / "log.000.mcap").rename(measured / "away")
        yield '{"captures": 8}'
        (measured / "away").rename(measured / "run" / "log.000.mcap")
        yield '{"captures": 8}'

    serve(
        measured / "run",
        measured / "model.yaml",
        questions(),
        lambda line: said.append(json.loads(line)),
        lambda looks, ended, folder: 1 / 0,
    )
    assert said[0]["trouble"].startswith("the diagnosis failed: LabrigError: ")
    assert said[1]["look"]["captures"] == 8


def test_a_picture_shows_every_look(tmp_path: Path) -> None:
    """`diagnosis-live.png` is drawn of looks that say little as well as of those that say much."""
    from labrig.view import write_course

    empty = Look(8, 0.5, "underpowered", (), {"creep": 0.0}, units="mm")
    full = Look(12, 0.8, "identified", ("creep",), {"creep": 0.95, "leak": 0.2}, 0.8, 0.3, 0.1, 0.1, "mm")
    path = write_course([empty, full], "settled: sure of creep 0.95", tmp_path)
    assert path.read_bytes()[:4] == b"\x89PNG"
    assert [each.name for each in tmp_path.iterdir()] == ["diagnosis-live.png"]


def test_run_with_diagnose_ends_when_it_is_near_enough(
    measured: Path, labrig: Command, monkeypatch: pytest.MonkeyPatch
) -> None:
    """`labrig run --diagnose --until error=...` looks twice in a process of its own, ends, and leaves its picture."""
    monkeypatch.chdir(measured)
    words = ["--captures", 30, "--repeated", 0, "--settle-s", 0.5, "--record-s", 0.2, "--rig", "rig.yaml"]
    code, out, err = labrig(
        "run",
        "capture",
        *words,
        "--out",
        "live",
        "--diagnose",
        "model.yaml",
        "--every",
        1,
        "--until",
        "error=50mm",
    )
    assert code == 0, err
    assert out == "live: 13 captures in 15 s, vented\n"
    assert "near enough: the held-out error is" in " ".join(err.split())
    kept = json.loads((measured / "live" / RECORD).read_text())
    assert [look["captures"] for look in kept["looks"]] == [12, 13]
    assert kept["ended"].startswith("near enough")
    assert (measured / "live" / "diagnosis-live.png").exists()
    code, _, err = labrig("run", "--resume", "live")
    assert code != 0
    assert "is finished" in err


@pytest.mark.parametrize(
    ("words", "says"),
    [
        (["--until", "settled"], "--every, --until, --budget and --adapt are for --diagnose MODEL"),
        (["--diagnose", "model.yaml", "--until", "soon"], "--until soon: write settled, or an error"),
        (["--diagnose", "no.yaml"], "no.yaml"),
    ],
)
def test_a_wrong_option_moves_nothing(
    measured: Path, labrig: Command, monkeypatch: pytest.MonkeyPatch, words: list[str], says: str
) -> None:
    """A rule or a model that cannot be read is one line, and no run is begun."""
    monkeypatch.chdir(measured)
    code, _, err = labrig("run", "capture", "--rig", "rig.yaml", "--out", "live", *words)
    assert code != 0
    assert says in err
    assert not (measured / "live").exists()


def test_its_process_ends_with_the_run_that_asked(measured: Path) -> None:
    """When the run is killed, its pipe closes, and the process of the diagnosis is gone too."""
    words = [sys.executable, "-m", "labrig.api._live", str(measured / "run"), str(measured / "model.yaml")]
    process = subprocess.Popen(words, stdin=subprocess.PIPE, stdout=subprocess.DEVNULL)
    assert process.stdin is not None
    process.stdin.close()
    assert process.wait(60) == 0
