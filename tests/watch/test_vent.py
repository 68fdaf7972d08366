"""The vent button reaches the chambers whatever else hangs or is gone; what it reports is what the rig holds."""

import os
import re
import signal
import urllib.error
import urllib.request
from pathlib import Path
from typing import Any

import psutil
import pytest

from labrig._running import notes
from labrig.log import summarise
from tests.waiting import wait_for

LONG = ("--captures", 200, "--settle-s", 0.3, "--record-s", 0.3)
stopping = pytest.mark.skipif(not hasattr(signal, "SIGSTOP"), reason="POSIX only")


def _confirmed(text: str, rig: Any) -> None:
    """The page says that it is confirmed, with a pressure for each chamber, and it is true."""
    assert "vented, confirmed" in text
    said = re.findall(r"<li><span>(.*?)</span> (-?[\d.]+) kPa</li>", text)
    assert [name for name, _ in said] == [channel.name for channel in rig.twins.plant.channels]
    assert all(abs(float(value)) < 3.0 for _, value in said)
    assert rig.highest_kpa < 3.0


def _pid(what: str, folder: Path) -> int:
    return next(note.pid for note in notes(what) if str(folder) in str(note.facts))


def test_during_a_run(bench: Any, rig: Any, press_vent: Any, until: Any) -> None:
    """The guard vents, the run ends with the reason in its log, and the captures before it are kept."""
    run = bench.start("first", *LONG)
    bench.live(run)
    until(lambda: (bench.now(run).get("progress") or {}).get("captures_done", 0) >= 1, "no capture")
    rig.wait_above(10.0)
    _confirmed(press_vent(bench.vent_address()), rig)
    until(lambda: not bench.now(run)["live"], "the run goes on")
    summary = summarise(bench.folder / run)
    assert "the vent button" in summary.state
    assert summary.captures >= 1
    assert rig.highest_kpa < 3.0


@stopping
def test_with_the_workbench_stopped(bench: Any, rig: Any, press_vent: Any) -> None:
    """A server that hangs, and every page with it, holds nothing up."""
    run = bench.start("first", *LONG)
    bench.live(run)
    address = bench.vent_address()
    rig.wait_above(10.0)
    os.kill(bench.process.pid, signal.SIGSTOP)
    try:
        _confirmed(press_vent(address), rig)
    finally:
        os.kill(bench.process.pid, signal.SIGCONT)


@stopping
def test_with_the_runner_stopped(bench: Any, rig: Any, press_vent: Any) -> None:
    """A runner that hangs is not asked: its guard vents."""
    run = bench.start("first", *LONG)
    bench.live(run)
    address = bench.vent_address()
    rig.wait_above(10.0)
    pid = _pid("run", bench.folder)
    os.kill(pid, signal.SIGSTOP)
    try:
        _confirmed(press_vent(address), rig)
    finally:
        os.kill(pid, signal.SIGCONT)


def test_with_the_runner_killed(bench: Any, rig: Any, press_vent: Any) -> None:
    """Whether the guard is still venting or has ended already, the pressure is read and reported."""
    run = bench.start("first", *LONG)
    bench.live(run)
    address = bench.vent_address()
    rig.wait_above(10.0)
    os.kill(_pid("run", bench.folder), getattr(signal, "SIGKILL", signal.SIGTERM))
    _confirmed(press_vent(address), rig)


def test_with_the_workbench_killed(bench: Any, rig: Any, press_vent: Any, until: Any) -> None:
    """The button outlives the workbench for as long as a run goes on, and then ends, too."""
    run = bench.start("first", *LONG)
    bench.live(run)
    address = bench.vent_address()
    rig.wait_above(10.0)
    bench.process.kill()
    bench.process.wait()
    _confirmed(press_vent(address), rig)

    def gone() -> bool:
        try:
            with urllib.request.urlopen(address, timeout=5):
                return False
        except OSError:
            return True

    until(gone, "the button stays for ever")


def test_without_a_run(bench: Any, rig: Any, press_vent: Any, until: Any) -> None:
    """What somebody left in the chambers is vented, by a link of the button's own."""
    rig.twins.plant.command([20.0] * len(rig.twins.plant.channels))
    rig.wait_above(10.0)
    _confirmed(press_vent(bench.vent_address()), rig)


def test_it_stays_said_until_the_rig_is_in_use_again(
    bench: Any, rig: Any, press_vent: Any, vent_says: Any
) -> None:
    """ "Vented, confirmed" stays while nobody uses the rig, and goes with the next run, whoever looks meanwhile."""
    address = bench.vent_address()
    _confirmed(press_vent(address), rig)
    assert "vented, confirmed" in vent_says(address)
    run = bench.start("first", *LONG)
    bench.live(run)
    rig.wait_above(10.0)
    assert "vented" not in vent_says(address)
    bench.ask("/api/watch/end", {"run": run})
    wait_for(lambda: not bench.now(run)["live"], "the run goes on")
    assert "vented, confirmed" not in vent_says(address)


def test_a_rig_that_is_not_there_is_not_called_vented(asked: Any, press_vent: Any) -> None:
    """Of a rig that is simulated inside its runs, while none goes on, the button says that nothing is filled."""
    text = press_vent(asked.vent_address())
    assert "nothing is filled" in text
    assert "confirmed" not in text
    assert "nobody" not in text


def test_a_vent_that_is_not_confirmed_is_never_called_so(bench: Any, rig: Any, press_vent: Any) -> None:
    """With the board gone the page says that nothing is confirmed, and what to do."""
    text = rig.file.read_text(encoding="utf-8").replace("vent_patience_s: 20.0", "vent_patience_s: 1.0")
    rig.file.write_text(re.sub(r"socket://127.0.0.1:\d+", "socket://127.0.0.1:9", text), encoding="utf-8")
    before = bench.vent_address()
    bench.spent = True
    _button(before).kill()  # its successor reads the rig file anew
    text = press_vent(wait_for(lambda: (now := bench.vent_address()) != before and now))
    assert "NOT confirmed" in text
    assert "relieve the pressure by hand" in text
    assert "vented, confirmed" not in text


def _button(address: str) -> psutil.Process:
    port = int(address.split(":")[2].split("/")[0])
    for process in psutil.process_iter(["cmdline"]):
        words = " ".join(process.info["cmdline"] or ())
        if "_vent_page" in words and any(c.laddr.port == port for c in process.net_connections("tcp")):
            return process
    raise AssertionError("the button has no process")


def test_without_its_key_the_button_does_nothing(bench: Any) -> None:
    """Another site, or another user of the computer, presses in vain."""
    address = bench.vent_address()
    other = address.rsplit("/", 2)[0] + "/" + "x" * 32 + "/"
    for given in (other + "vent", address + "vent/x"):
        with pytest.raises(urllib.error.HTTPError) as caught:
            urllib.request.urlopen(urllib.request.Request(given, data=b"", method="POST"), timeout=180)
        caught.value.close()
        assert caught.value.code == 403


def test_a_slip_in_the_rig_file_takes_nothing_away_that_ends_a_run(bench: Any, rig: Any, until: Any) -> None:
    """Whoever breaks the file while a run goes on still has the button, the run, its pause and its end; no new run."""
    run = bench.start("first", *LONG)
    bench.live(run)
    address = bench.vent_address()
    rig.file.write_text(rig.file.read_text("utf-8") + "chamberss: []\n", encoding="utf-8")
    status, facts = bench.ask("/api/watch/rig")
    assert status == 200
    assert facts["running"] == [run]
    assert "chamberss" in facts["wrong"]
    assert bench.vent_address() == address
    assert bench.now(run)["live"]
    status, said = bench.ask("/api/watch/plan", {"procedure": "capture"})
    assert (status, "chamberss" in said["error"]) == (400, True)
    assert bench.ask("/api/watch/end", {"run": run})[0] == 200
    until(lambda: not bench.now(run)["live"], "the run goes on")
    assert rig.highest_kpa < 3.0
