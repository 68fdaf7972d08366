"""Campaigns killed at random moments: is every chamber vented, and is every completed capture kept?

    python benchmarks/kill.py [--runs 500] [--workers 3] [--out benchmarks/RESULTS.md]

Each run is a process of its own that drives a simulated OpenPneu board (published dialect, on a TCP port) with
labrig's driver behind labrig's guard. The board lives here, has no watchdog, and holds its pressure when the link is
gone. At a random moment the runner is killed: mostly with SIGKILL, sometimes stopped (SIGSTOP), or asked to end
(SIGTERM, SIGINT, SIGHUP). Then the board must read ambient within `WITHIN_S`, and the log must hold every capture
that the runner had said was done. POSIX only: the signals are.
"""

import argparse
import os
import random
import signal
import statistics
import subprocess
import sys
import tempfile
import threading
import time
from collections import Counter
from concurrent.futures import ThreadPoolExecutor
from dataclasses import dataclass, field
from pathlib import Path
from typing import Any

import numpy as np
import yaml

from labrig import LabrigError
from labrig.log import summarise
from labrig_drivers import Channel, RealClock
from labrig_drivers.simulated._openpneu_board import OpenPneuBoard
from labrig_drivers.simulated._openpneu_twin import OpenPneuTwin
from labrig_drivers.simulated._wire_plant import SharedPlant

WITHIN_S = 10.0
VENTED_KPA = 3.0
CHAMBERS = 4
HEARTBEAT_S = 2.0
LATEST_S = 5.0
SIGNALS = {"SIGKILL": 0.7, "SIGSTOP": 0.1, "SIGTERM": 0.1, "SIGINT": 0.05, "SIGHUP": 0.05}


class Chambers:
    """First-order chambers: what the board drives."""

    marker_names: tuple[str, ...] = ()
    time_constant_s = 0.15

    def __init__(self) -> None:
        self.channels = tuple(Channel(f"c{n + 1}", 0.0, 60.0) for n in range(CHAMBERS))
        self._start = self._target = np.zeros(CHAMBERS)
        self._since_s = 0.0

    def command(self, time_s: float, pressure_kpa: Any) -> None:
        """A new target from `time_s` on."""
        self._start, self._since_s = self.pressure_kpa(time_s), time_s
        self._target = np.array(pressure_kpa, float)

    def pressure_kpa(self, time_s: float) -> Any:
        """The pressures at a time."""
        share = np.exp(-max(0.0, time_s - self._since_s) / self.time_constant_s)
        return self._target + (self._start - self._target) * share

    def observe(self, time_s: float) -> Any:
        """There are no markers."""
        return np.zeros((0, 3)), np.zeros(0, np.int8)

    def surface(self, time_s: float) -> Any:
        """There is no surface."""
        return np.zeros((0, 3)), np.zeros((0, 3), np.int64)


@dataclass
class Outcome:
    """One killed run: how, under which pressure, how long until it was vented (None: never), captures."""

    signal: str
    pressure_kpa: float
    vented_s: float | None
    reported: int
    kept: int


@dataclass
class Bench:
    """A board and the folder of the runs made on it."""

    folder: Path
    chambers: Chambers = field(default_factory=Chambers)

    def __post_init__(self) -> None:
        self.plant = SharedPlant(self.chambers, RealClock())
        board = OpenPneuBoard(self.plant, dialect="published", build="full")
        self.twin = OpenPneuTwin(board, boot_s=0.0).start()
        self.rig = self.folder / "rig.yaml"
        content = {
            "name": "kill",
            "chambers": [{"name": c.name, "max_kpa": 60, "slew_kpa_s": 300} for c in self.chambers.channels],
            "pressure": {"kind": "openpneu", "port": self.twin.port, "boot_s": 0, "build": "full"},
            "safety": {"heartbeat_s": HEARTBEAT_S, "stale_pressure_s": 3.0, "vented_kpa": VENTED_KPA},
        }
        self.rig.write_text(yaml.safe_dump(content), encoding="utf-8")

    def highest_kpa(self) -> float:
        """The highest pressure in any chamber now."""
        return float(np.abs(self.plant.pressure_kpa()).max())

    def kill_one(self, number: int, chance: random.Random) -> Outcome:
        """Start a run, kill it at a random moment after its first set-point, and look at what is left."""
        run = self.folder / f"run{number}"
        how = chance.choices(list(SIGNALS), list(SIGNALS.values()))[0]
        command = [sys.executable, __file__, "--child", str(self.rig), str(run)]
        process = subprocess.Popen(command, stdout=subprocess.PIPE, stderr=subprocess.DEVNULL, text=True)
        reported: list[str] = []
        begun = threading.Event()
        reader = threading.Thread(target=_collect, args=(process, reported, begun))
        reader.start()
        if not begun.wait(60):
            process.kill()
            raise RuntimeError("a run did not begin within 60 s")
        time.sleep(chance.uniform(0.0, LATEST_S))
        pressure_kpa = self.highest_kpa()
        process.send_signal(getattr(signal, how))
        vented_s = self._wait_vented()
        if how == "SIGSTOP":
            process.kill()
        process.wait(60)
        reader.join(10)
        if process.stdout is not None:
            process.stdout.close()
        return Outcome(how, pressure_kpa, vented_s, len(reported), _captures(run))

    def _wait_vented(self) -> float | None:
        """Seconds until the chambers stay vented: three readings in a row."""
        begin, calm = time.monotonic(), 0
        while time.monotonic() - begin < WITHIN_S:
            calm = calm + 1 if self.highest_kpa() <= VENTED_KPA else 0
            if calm == 1:
                first = time.monotonic() - begin
            if calm == 30:
                return first
            time.sleep(0.01)
        return None

    def close(self) -> None:
        """Stop the board."""
        self.twin.stop()


def _collect(process: subprocess.Popen[str], reported: list[str], begun: threading.Event) -> None:
    assert process.stdout is not None
    for line in process.stdout:
        if line.startswith("begun"):
            begun.set()
        if line.startswith("done") and line.endswith("\n"):
            reported.append(line)


def _captures(run: Path) -> int:
    try:
        return summarise(run).captures
    except LabrigError:
        return 0


def child(rig: Path, out: Path) -> None:
    """The run that is killed: many short captures; says on standard output what is durable."""
    from labrig.campaign import (
        Actuate,
        Completed,
        Observer,
        Procedure,
        Record,
        RigInfo,
        Settle,
        Steps,
        Watching,
        run,
    )
    from labrig.rig import connect, load_rig

    class Many(Procedure):
        def steps(self, rig: RigInfo) -> Steps:
            rng = rig.rng()
            for _ in range(200):
                yield Actuate(rng.uniform(10.0, 60.0, CHAMBERS))
                yield Settle(0.1)
                yield Record(0.1)

    class Teller(Observer):
        def step_started(self, index: int, step: Any) -> None:
            if index == 0:
                print("begun", flush=True)

        def step_done(self, completed: Completed) -> None:
            if isinstance(completed.step, Record):
                print("done", completed.index, flush=True)

    with connect(load_rig(rig), RealClock(), guard_log=out.with_suffix(".guard.log")) as connected:
        run(Many(), connected, out, seed=os.getpid(), watching=Watching([Teller()]))


def measure(runs: int, workers: int, seed: int = 0) -> list[Outcome]:
    """Kill so many runs, some at a time, each worker on a board of its own."""
    with tempfile.TemporaryDirectory() as name:

        def work(worker: int) -> list[Outcome]:
            folder = Path(name) / str(worker)
            folder.mkdir()
            bench, chance = Bench(folder), random.Random(1000 * seed + worker)
            try:
                return [bench.kill_one(number, chance) for number in range(worker, runs, workers)]
            finally:
                bench.close()

        with ThreadPoolExecutor(workers) as pool:
            return [outcome for outcomes in pool.map(work, range(workers)) for outcome in outcomes]


def lines_of(outcomes: list[Outcome]) -> list[str]:
    """The table for the results."""
    under = [outcome for outcome in outcomes if outcome.pressure_kpa > VENTED_KPA]
    unvented = sum(outcome.vented_s is None for outcome in outcomes)
    lost = sum(max(0, outcome.reported - outcome.kept) for outcome in outcomes)
    captures = sum(outcome.reported for outcome in outcomes)
    lines = [
        f"{len(outcomes)} runs killed at a random moment, {len(under)} of them under pressure "
        f"({', '.join(f'{count} {name}' for name, count in Counter(o.signal for o in outcomes).most_common())}): "
        f"**{unvented} unvented, {lost} of {captures} completed captures lost.**",
        "",
        "| Killed with | runs | time to ambient, median | worst |",
        "|---|---|---|---|",
    ]
    for name in SIGNALS:
        times = [o.vented_s for o in under if o.signal == name and o.vented_s is not None]
        if times:
            lines.append(f"| {name} | {len(times)} | {statistics.median(times):.2f} s | {max(times):.2f} s |")
    lines += [
        "",
        f"Ambient: at most {VENTED_KPA:g} kPa in every chamber (time constant {Chambers.time_constant_s:g} s); "
        f"heartbeat {HEARTBEAT_S:g} s, which is what SIGSTOP waits for.",
    ]
    return lines


def report(lines: list[str], path: Path) -> None:
    """Replace the section "Killed runs" of the results."""
    text = path.read_text(encoding="utf-8") if path.exists() else "# Measured\n"
    head, _, rest = text.partition("## Killed runs\n")
    _, mark, tail = rest.partition("\n## ")
    partial = path.with_suffix(".partial")
    section = "## Killed runs\n\n" + "\n".join(lines) + "\n"
    partial.write_text(
        head.rstrip("\n") + "\n\n" + section + (f"\n## {tail}" if mark else ""), encoding="utf-8"
    )
    partial.replace(path)


def main() -> int:
    """Kill the runs, write the section, exit with 1 if anything was left under pressure or lost."""
    parser = argparse.ArgumentParser(
        description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter
    )
    parser.add_argument("--runs", type=int, default=500)
    parser.add_argument("--workers", type=int, default=3)
    parser.add_argument("--seed", type=int, default=0)
    parser.add_argument("--out", type=Path, default=Path(__file__).parent / "RESULTS.md")
    parser.add_argument("--child", nargs=2, type=Path, metavar=("RIG", "RUN"), help=argparse.SUPPRESS)
    options = parser.parse_args()
    if options.child:
        child(*options.child)
        return 0
    outcomes = measure(options.runs, options.workers, options.seed)
    lines = lines_of(outcomes)
    report(lines, options.out)
    print("\n".join(lines))
    return int(any(o.vented_s is None or o.kept < o.reported for o in outcomes))


if __name__ == "__main__":
    sys.exit(main())
