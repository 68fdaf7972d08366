"""A vent from outside a run reaches the chambers, whoever holds the link, and reads them back."""

import json
import os
import signal
import socket
import subprocess
import sys
from collections.abc import Iterator
from pathlib import Path
from typing import Any

import numpy as np
import pytest
import yaml

from labrig._running import GoneError, Note, Reception, SilentError, notes
from labrig.rig import GuardedPressure, connect, load_rig, vent_now
from labrig.rig._asked import link_of
from labrig_drivers import DeviceError, RealClock, VentNotConfirmedError

SLOW_S = 30.0


def test_the_guard_vents_for_whoever_asks(valves: Any, write_rig: Any, runner: Any) -> None:
    """While a run goes on its guard vents, says what it reads, and the run learns that it is over, and why."""
    path = write_rig()
    process = runner(path)
    valves.wait_for(39.0, 41.0, SLOW_S)
    vented = vent_now(load_rig(path), "the vent page")
    assert valves.pressure_kpa <= 0.5
    assert vented.pressure_kpa == pytest.approx({"c1": 0.0, "c2": 0.0}, abs=0.5)
    assert "guard" in vented.by
    assert process.wait(SLOW_S) == 1
    assert "pressure: stopped by the vent page" in process.stderr.read()


def test_a_vent_that_takes_long_is_not_cut_short_by_its_run(valves: Any, write_rig: Any, runner: Any) -> None:
    """The run goes on asking what is measured; its guard, which vents meanwhile, is left alone."""
    path = write_rig()
    content = yaml.safe_load(path.read_text(encoding="utf-8"))
    content["pressure"]["empties_s"] = 5.0
    path.write_text(yaml.safe_dump(content), encoding="utf-8")
    process = runner(path)
    valves.wait_for(39.0, 41.0, SLOW_S)
    before = valves.sets
    vented = vent_now(load_rig(path), "the vent page")
    assert (vented.took_s > 5.0, valves.sets - before) == (True, 1)
    assert process.wait(SLOW_S) == 1
    assert "pressure: stopped by the vent page" in process.stderr.read()


def test_set_points_are_refused_until_the_runner_has_vented_itself(valves: Any, write_rig: Any) -> None:
    """Nothing fills the chambers again behind the back of whoever vented them."""
    config = load_rig(write_rig())
    rig = connect(config, RealClock())
    try:
        rig.pressure.set(np.array([40.0, 30.0]))
        vent_now(config, "the vent page")
        for use in (lambda: rig.pressure.set(np.array([40.0, 30.0])), rig.pressure.samples):
            with pytest.raises(DeviceError, match="the vent page"):
                use()
        assert valves.pressure_kpa <= 0.5
        rig.vent()
        rig.pressure.set(np.array([40.0, 30.0]))
        valves.wait_for(35.0, 45.0, SLOW_S)
        rig.vent()
    finally:
        rig.close()
    assert [note for note in notes("guard") if note.pid == _guard_id(rig)] == []


def _guard_id(rig: Any) -> int:
    assert isinstance(rig.pressure, GuardedPressure)
    return rig.pressure._process.pid if rig.pressure._process is not None else -1


def test_with_the_runner_killed_the_vent_is_confirmed_all_the_same(
    valves: Any, write_rig: Any, runner: Any
) -> None:
    """Whether the guard is still there or gone, somebody vents and reads."""
    path = write_rig()
    process = runner(path)
    valves.wait_for(39.0, 41.0, SLOW_S)
    process.kill()
    vented = vent_now(load_rig(path))
    assert vented.pressure_kpa == pytest.approx({"c1": 0.0, "c2": 0.0}, abs=0.5)
    assert valves.pressure_kpa <= 0.5


@pytest.mark.skipif(not hasattr(signal, "SIGSTOP"), reason="POSIX only")
def test_a_guard_that_is_stopped_is_ended(valves: Any, write_rig: Any, runner: Any) -> None:
    """Runner and guard both stopped: nobody would vent, so the link is taken from them."""
    path = write_rig()
    process = runner(path)
    valves.wait_for(39.0, 41.0, SLOW_S)
    config = load_rig(path)
    link = link_of(config)  # other tests have guards, too
    note = next(note for note in notes("guard") if note.facts["link"] == link)
    os.kill(process.pid, signal.SIGSTOP)
    os.kill(note.pid, signal.SIGSTOP)
    vented = vent_now(config)
    assert vented.by == "this process"
    assert valves.pressure_kpa <= 0.5


def test_a_guard_that_is_gone_has_left_its_number_to_nobody(valves: Any, write_rig: Any) -> None:
    """After a power cut a guard's number may be another process's, and its port a third one's: neither is touched."""
    config = load_rig(write_rig())
    other = subprocess.Popen([sys.executable, "-c", "import time; time.sleep(60)"])
    reception = Reception("guard", {"link": link_of(config), "rig": "valves"}, lambda _: None)
    with socket.create_server(("127.0.0.1", 0)) as silent:
        content = json.loads(reception.path.read_text())
        gone = reception.path.with_name("guard-1-gone.json")
        reception.close()
        gone.write_text(json.dumps(content | {"pid": other.pid, "port": silent.getsockname()[1]}))
        assert content["locked"]
        vented = vent_now(config)
    assert (vented.by, other.poll(), gone.exists()) == ("this process", None, False)
    other.kill()
    other.wait()


def test_without_a_run_the_link_is_opened(valves: Any, write_rig: Any) -> None:
    """Chambers that somebody left under pressure are vented and read."""
    valves.answer({"set": [40.0, 30.0]})
    valves.wait_for(39.0, 41.0, SLOW_S)
    vented = vent_now(load_rig(write_rig()))
    assert vented.by == "this process"
    assert valves.pressure_kpa <= 0.5


def test_a_vent_that_nothing_confirms_says_so(valves: Any, write_rig: Any) -> None:
    """A board that does not answer is tried for the rig's patience, each failure told, and never called vented."""
    path = write_rig(safety={"vent_timeout_s": 0.2, "vent_patience_s": 0.5})
    valves.cut_links()
    config = load_rig(path)
    port = valves.port
    config = config.model_copy(
        update={"pressure": config.pressure.model_copy(update={"port": _closed_port(port)})}
    )
    told: list[str] = []
    with pytest.raises(VentNotConfirmedError, match="relieve the pressure by hand"):
        vent_now(config, tell=told.append)
    assert told


def _closed_port(other: int) -> int:
    import socket

    with socket.socket() as probe:
        probe.bind(("127.0.0.1", 0))
        port = probe.getsockname()[1]
    assert port != other
    return port


def test_the_command_says_what_every_chamber_reads(labrig: Any, valves: Any, write_rig: Any) -> None:
    """`labrig rig vent` prints each chamber and its pressure."""
    valves.answer({"set": [40.0, 30.0]})
    code, out, _ = labrig("rig", "vent", write_rig())
    assert code == 0
    lines = out.splitlines()
    assert [line.split()[0] for line in lines[:2]] == ["c1", "c2"]
    assert all(abs(float(line.split()[1])) <= 0.5 for line in lines[:2])
    assert valves.pressure_kpa <= 0.5


@pytest.fixture
def echo() -> Iterator[Reception]:
    """Somebody who can be asked and says what was said."""
    reception = Reception("echo", {"name": "e"}, lambda request: request)
    yield reception
    reception.close()


def test_without_the_key_nobody_is_answered(echo: Reception) -> None:
    """Other users of the computer, and web pages, can reach the port but not the process."""
    note = next(note for note in notes("echo") if note.port == echo.port)
    assert note.ask("this", more=1) == {"do": "this", "more": 1}
    wrong = Note("echo", note.pid, note.port, "0" * 32, note.facts, note.path)
    with pytest.raises(GoneError):
        wrong.ask("this")
    if os.name == "posix":
        assert note.path.stat().st_mode & 0o077 == 0


def test_the_note_of_one_that_ended_is_removed(echo: Reception) -> None:
    """A process that was killed leaves its note; the first who asks in vain takes it away."""
    note = next(note for note in notes("echo") if note.port == echo.port)
    text = note.path.read_text(encoding="utf-8")
    echo.close()
    note.path.write_text(text, encoding="utf-8")
    with pytest.raises(GoneError):
        note.ask("this")
    assert not note.path.exists()


def test_one_that_listens_and_says_nothing_is_told_from_one_that_ended(monkeypatch: Any) -> None:
    """A stopped process keeps its port open."""
    import socket

    monkeypatch.setattr("labrig._running.SILENT_S", 0.2)
    with socket.create_server(("127.0.0.1", 0)) as server:
        note = Note("echo", 0, server.getsockname()[1], "", {}, Path("nothing"))
        with pytest.raises(SilentError):
            note.ask("this")
