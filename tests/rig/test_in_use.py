"""One process at a time uses a rig, and a run's folder: others are refused and touch nothing. A vent never is."""

import os
import subprocess
import sys
from collections.abc import Callable, Iterator
from pathlib import Path
from typing import Any

import pytest

from labrig import LabrigError
from labrig.rig import RigConfig, in_use, load_rig, parse_rig
from labrig.rig._asked import link_of

HOLDER = """
import sys, time
from pathlib import Path
from labrig.rig import in_use, load_rig
with in_use(load_rig(sys.argv[1]), "run runs/night", Path(sys.argv[2])):
    print("has it", flush=True)
    time.sleep(60)
"""


@pytest.fixture
def holder() -> Iterator[Callable[..., "subprocess.Popen[str]"]]:
    """Start a process that has a rig and a folder."""
    started: list[subprocess.Popen[str]] = []

    def start(rig: Path, folder: Path) -> "subprocess.Popen[str]":
        command = [sys.executable, "-c", HOLDER, str(rig), str(folder)]
        process = subprocess.Popen(command, stdout=subprocess.PIPE, text=True)
        started.append(process)
        assert process.stdout is not None
        assert process.stdout.readline() == "has it\n"
        return process

    yield start
    for process in started:
        process.kill()
        process.communicate()


def _files(folder: Path) -> dict[str, tuple[int, bytes]]:
    return {
        str(path): (path.stat().st_mtime_ns, path.read_bytes())
        for path in folder.rglob("*")
        if path.is_file()
    }


@pytest.mark.parametrize(
    ("one", "other"),
    [
        ({"host": "10.0.0.7"}, {"host": "10.0.0.7", "port": 502, "unit_id": 1}),
        ({"host": "localhost"}, {"host": "127.0.0.1"}),
        ({"serial": "COM3"}, {"serial": "com3"}),
        ({"serial": "COM10"}, {"serial": "\\\\.\\COM10"}),
        ({"serial": "LINK"}, {"serial": "PORT"}),
    ],
)
def test_a_controller_is_one_however_it_is_written(tmp_path: Path, one: dict, other: dict) -> None:
    """Defaults that are left out, another case, a link to a port: the same rig; another unit of it is another."""
    port, link = tmp_path / "dev" / "ttyUSB0", tmp_path / "dev" / "serial-by-id"
    port.parent.mkdir()
    port.touch()
    link.symlink_to(port)

    def of(options: dict[str, Any]) -> str:
        named = {
            name: {"PORT": str(port), "LINK": str(link)}.get(value, value) for name, value in options.items()
        }
        pressure = {"kind": "modbus", "map": "festo-vtem", **named}
        chambers = [{"name": "c1", "max_kpa": 60}]
        return link_of(
            parse_rig({"name": "r", "chambers": chambers, "pressure": pressure}, "rig.yaml", Path())
        )

    assert of(one) == of(other) != of({**other, "unit_id": 2})


def test_a_second_command_is_refused_and_a_vent_is_not(
    labrig: Any, holder: Any, valves: Any, write_rig: Callable[..., Path], tmp_path: Path
) -> None:
    """Run, resume and check say who has the rig, and touch nothing; `labrig rig vent` vents all the same."""
    rig, folder = write_rig(), tmp_path / "runs" / "night"
    folder.mkdir(parents=True)
    (folder / "run.yaml").write_text(f"source: idle\nrig_file: {rig}\nparameters: {{}}\n", encoding="utf-8")
    process = holder(rig, folder)
    before, sets = _files(folder), valves.sets
    words = [
        ("rig", "check", rig, "--still"),
        ("run", "idle", "--rig", rig, "--out", tmp_path / "second"),
        ("run", "--resume", folder),
        ("rig", "check", rig),
    ]
    for each in words:
        code, _, said = labrig(*each)
        does = "is still going on" if "--resume" in each else "is using this rig"
        assert said.startswith(f"labrig: run runs/night (process {process.pid}, since 20")
        assert said.endswith(f") {does}; wait, or stop it\n")
        assert code == 2
    assert _files(folder) == before
    assert valves.sets == sets
    assert not valves.links
    assert not (tmp_path / "second").exists()
    code, out, _ = labrig("rig", "vent", rig)
    assert code == 0
    assert "vented in" in out


def test_a_killed_process_has_nothing(holder: Any, write_rig: Callable[..., Path], tmp_path: Path) -> None:
    """The system takes the lock from whoever is gone; the next one has it at once."""
    rig = write_rig()
    process = holder(rig, tmp_path)
    process.kill()
    process.wait()
    with in_use(load_rig(rig), "another", tmp_path):
        pass


def test_a_guard_that_still_vents_is_not_worked_against(
    runner: Any, valves: Any, write_rig: Callable[..., Path], monkeypatch: pytest.MonkeyPatch
) -> None:
    """Where no reading confirms its vent, it goes on after its run: it would vent the next run, too, which waits."""
    rig = write_rig()
    process = runner(rig)
    monkeypatch.setattr(valves, "answer", lambda _request: [40.0, 30.0])
    process.kill()
    process.wait()
    monkeypatch.setattr("labrig.rig._in_use._ENDS_S", 0.5)
    with pytest.raises(
        LabrigError, match=r"the guard of a run \(process \d+\) still has this rig: no reading"
    ):
        in_use(load_rig(rig), "another").__enter__()
    monkeypatch.undo()
    monkeypatch.setattr("labrig.rig._in_use._ENDS_S", 30.0)
    with in_use(load_rig(rig), "another"):
        assert valves.pressure_kpa < 0.5


def test_one_process_has_a_rig_once(write_rig: Callable[..., Path], tmp_path: Path) -> None:
    """Two threads of one program are two users as well; afterwards nothing is left."""
    config = load_rig(write_rig())
    with in_use(config, "the first"), pytest.raises(LabrigError) as caught, in_use(config, "the second"):
        pass
    assert str(caught.value).startswith(f"the first (process {os.getpid()}, since 20")
    with in_use(config, "the third"):
        pass


def test_rigs_that_are_simulated_here_are_nobodys(tmp_path: Path) -> None:
    """Any number of them may run side by side, each in a folder of its own."""
    content = {
        "name": "s",
        "chambers": [{"name": "c1", "max_kpa": 60}],
        "pressure": {"kind": "simulated"},
        "simulated": {"surface": "mannequin"},
    }
    config = parse_rig(content, "rig.yaml", tmp_path)
    with in_use(config, "one", tmp_path / "a"), in_use(config, "two", tmp_path / "b"):
        pass
    with (
        in_use(config, "one", tmp_path / "a"),
        pytest.raises(LabrigError, match=r"^one .* is still going on"),
    ):
        in_use(config, "two", tmp_path / "a").__enter__()


def test_without_a_place_for_locks_a_run_goes_on(
    write_rig: Callable[..., Path], tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    """A cache folder that cannot be written is no reason not to measure."""
    (tmp_path / "file").write_text("")
    monkeypatch.setenv("LABRIG_CACHE", str(tmp_path / "file"))
    with in_use(load_rig(write_rig()), "a run", tmp_path):
        pass


def _config(**options: Any) -> RigConfig:
    content = {"name": "r", "chambers": [{"name": "c1", "max_kpa": 60}], "pressure": options}
    return parse_rig(content, "rig.yaml", Path())


def test_controllers_are_told_apart_by_their_addresses() -> None:
    """Whatever a class of one's own calls its address; how it is used does not count, nor where its file lies."""
    own = {"kind": "python", "file": "valve.py", "class": "Valve"}
    links = [
        link_of(_config(**options))
        for options in (
            {**own, "machine": "left"},
            {**own, "machine": "right"},
            {"kind": "modbus", "map": "m", "serial": "COM3"},
            {"kind": "modbus", "map": "m", "serial": "COM4"},
            {"kind": "modbus", "map": "m", "host": "10.0.0.1", "unit_id": 1},
            {"kind": "modbus", "map": "m", "host": "10.0.0.1", "unit_id": 2},
        )
    ]
    assert len(set(links)) == len(links)
    slow = {**own, "file": "/lab/valve.py", "machine": "left", "timeout_s": 3.0}
    assert link_of(_config(**slow)) == links[0]
