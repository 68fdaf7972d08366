"""What watching a run in the workbench costs: the run's overhead, and memory after eight hours of data.

    python benchmarks/workbench_live.py [--quick] [--out benchmarks/RESULTS.md]

The overhead is measured on the real clock, in turn without and with somebody who asks three times a second. The eight
hours are told in minutes to a run's own memory, while a workbench and a page in Chromium watch it: the page asks as
fast as it can, so that it asks as often as in an hour or more. Writes the section "Watching a run" of the results.
"""

import argparse
import gc
import multiprocessing
import os
import platform
import secrets
import statistics
import subprocess
import sys
import tempfile
import threading
import time
from dataclasses import dataclass
from pathlib import Path

import numpy as np
import psutil
from _streaming import CHAMBERS, FRAME_HZ, MARKERS, SAMPLE_HZ, make_rig
from campaign import Captures

from labrig._running import notes
from labrig.bench._report import write_section
from labrig.campaign import Actuate, Completed, Control, Progress, Reachable, Record, Recording, Watching, run
from labrig.log import Topic, load_segments
from labrig_drivers import MarkerFrame, PressureSample, RealClock

HOURS, HOLD_S = 8.0, 4.0
ASK_S = 0.35
MB = 1024 * 1024
HURRY = "const wait = setTimeout; window.setTimeout = (f, ms, ...more) => wait(f, ms / 10, ...more);"
MODEL = """
import numpy as np


def predict(actuation):
    return np.tile(actuation.mean(axis=1, keepdims=True), (1, {values}))
"""


def overhead(folder: Path, captures: int, watched: bool) -> list[float]:
    """Overheads of the captures of one run, as shares of its 3 s, from the log's own times."""
    from itertools import pairwise

    from labrig_schema.step_pb2 import Step

    clock, control = RealClock(), Control()
    rig, procedure = make_rig(clock), Captures(count=captures + 1, settle_s=2.0, record_s=1.0)
    asker = multiprocessing.get_context("spawn").Process(target=_ask, args=(str(folder),))
    if watched:
        with Reachable(procedure, rig.config, folder, clock, control) as reachable:
            asker.start()
            time.sleep(2.0)
            run(procedure, rig, folder, clock, watching=Watching([reachable], control))
        asker.join(10)
    else:
        run(procedure, rig, folder, clock)
    segments, _ = load_segments(folder)
    steps = [Step.FromString(payload) for payload in segments[0].messages(Topic.STEP).payload]
    starts = [step.started_s for step in steps if step.state == Step.DONE and step.kind == "actuate"]
    return [(later - earlier - 3.0) / 3.0 for earlier, later in pairwise(starts)]


def _ask(folder: str) -> None:
    """Ask a run as a page does, until it has gone."""
    since, event = 0.0, 0
    while found := [note for note in notes("run") if note.facts["folder"] == str(Path(folder).resolve())]:
        try:
            state = found[0].ask("status", since_s=since, event=event)
        except Exception:
            return
        since = (state["history"]["time_s"] or [since])[-1]
        time.sleep(ASK_S)


def feed(folder: Path, seconds: float) -> None:
    """Tell a run's own memory eight hours of frames, samples and captures in `seconds`; print its memory, MB."""
    clock = RealClock()
    rig = make_rig(clock)
    start_s = clock.now_s()
    folder.mkdir(parents=True)
    (folder / "run.yaml").write_text(f"procedure: captures\nstart_s: {start_s}\n", encoding="utf-8")
    rest_mm = np.random.default_rng(0).normal(scale=80.0, size=(MARKERS, 3)) * [1, 1, 0.1]
    status, process = np.zeros(MARKERS, np.int8), psutil.Process()
    captures = int(HOURS * 3600 / HOLD_S)
    with Reachable(Captures(), rig.config, folder, clock, Control()) as live:
        from labrig.campaign import RigInfo

        live.started(RigInfo("benchmark", rig.config.channels, rig.config.markers, False, 0), rest_mm)
        began = time.monotonic()
        for number in range(captures):
            at_s = start_s + number * HOLD_S
            pressure = np.full(CHAMBERS, float(number % 50))
            live.step_started(2 * number, Actuate(pressure))
            live.step_done(Completed(2 * number, Actuate(pressure), None, at_s, at_s))
            live.commanded(at_s, tuple(pressure))
            for k in range(int(HOLD_S * SAMPLE_HZ)):
                live.sample(PressureSample(at_s + k / SAMPLE_HZ, pressure))
            for k in range(int(HOLD_S * FRAME_HZ)):
                live.frame(MarkerFrame(at_s + k / FRAME_HZ, k, rest_mm + 0.01 * k, status))
            recording = Recording(
                np.array([at_s + 3.0]),
                rest_mm[None] + pressure[0] / 10,
                np.array([at_s + 3.0]),
                pressure[None],
            )
            live.step_done(Completed(2 * number + 1, Record(1.0), recording, at_s + 3.0, at_s + 4.0))
            live.progress(
                Progress(2 * number, 2 * captures, number, captures, number * HOLD_S, 0.0, "record")
            )
            live.event(at_s, f"capture {number}", "INFO")
            if number == captures // 8:
                gc.collect()
                print(process.memory_info().rss / MB, flush=True)
            time.sleep(max(0.0, began + seconds * number / captures - time.monotonic()))
        gc.collect()
        print(process.memory_info().rss / MB, flush=True)
        sys.stdin.read()


@dataclass
class Memory:
    """Memory in MB, after one hour of data and after eight."""

    run: tuple[float, float]
    server: tuple[float, float]
    model: float
    heap: tuple[float, float]
    tab: tuple[float, float]
    asked: int
    took_s: float


def memory(folder: Path, seconds: float) -> Memory:
    """Eight hours of a run, watched by a workbench and a page."""
    from playwright.sync_api import sync_playwright

    from labrig.workbench import open_desk, start

    (folder / "model.py").write_text(MODEL.format(values=3 * MARKERS), encoding="utf-8")
    (folder / "model.yaml").write_text(
        "base: {kind: python, file: model.py, function: predict}\neffects: []\n"
    )
    name = f"run-{secrets.token_hex(2)}"
    feeder = subprocess.Popen(
        [sys.executable, __file__, "--feed", str(folder / name), str(seconds)],
        stdin=subprocess.PIPE,
        stdout=subprocess.PIPE,
        text=True,
    )
    assert feeder.stdout is not None
    said: list[float] = []
    reader = threading.Thread(target=lambda: said.extend(float(line) for line in feeder.stdout or ()))
    reader.start()
    running, server = start(open_desk(folder)), psutil.Process()
    began = time.monotonic()
    with sync_playwright() as playwright:
        browser = playwright.chromium.launch(args=["--no-sandbox"], executable_path=_chromium())
        page = browser.new_context(viewport={"width": 1280, "height": 900}).new_page()
        asked = [0]
        page.on("request", lambda request: asked.__setitem__(0, asked[0] + ("/watch/now" in request.url)))
        page.add_init_script(
            "const wait = setTimeout; window.setTimeout = (f, ms, ...a) => wait(f, ms / 10, ...a);"
        )
        page.goto(running.address)
        while not any(note.facts["folder"].endswith(name) for note in notes("run")):
            time.sleep(0.2)
        page.goto(f"http://127.0.0.1:{running.port}/#/watch?live={name}&model=model.yaml")
        page.reload()
        page.wait_for_selector(".live-run")
        page.wait_for_selector(".surface canvas")
        devtools = page.context.new_cdp_session(page)

        def look() -> tuple[float, float, float]:
            devtools.send("HeapProfiler.collectGarbage")
            gc.collect()
            metrics = {
                each["name"]: each["value"] for each in devtools.send("Performance.getMetrics")["metrics"]
            }
            return metrics["JSHeapUsedSize"] / MB, _largest("--type=renderer"), server.memory_info().rss / MB

        devtools.send("Performance.enable")
        while len(said) < 1:
            page.wait_for_timeout(500)
        early, asked_early = look(), asked[0]
        while len(said) < 2:
            page.wait_for_timeout(500)
        model = max(
            (p.memory_info().rss / MB for p in server.children(recursive=True) if _is(p, "_live_error")),
            default=0.0,
        )
        late = look()
        took_s, count = time.monotonic() - began, asked[0] - asked_early
        browser.close()
    assert feeder.stdin is not None
    feeder.stdin.close()
    feeder.wait(20)
    reader.join(5)
    running.stop()
    return Memory(
        (said[0], said[1]),
        (early[2], late[2]),
        model,
        (early[0], late[0]),
        (early[1], late[1]),
        count,
        took_s,
    )


def _chromium() -> str | None:
    import shutil

    return shutil.which("chromium")


def _is(process: psutil.Process, word: str) -> bool:
    try:
        return any(word in part for part in process.cmdline())
    except psutil.Error:
        return False


def _largest(word: str) -> float:
    """Memory of the largest child process whose command has a word, MB."""
    children = psutil.Process().children(recursive=True)
    return max((p.memory_info().rss / MB for p in children if _is(p, word)), default=0.0)


def main() -> None:
    """Measure and write the section."""
    parser = argparse.ArgumentParser(
        description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter
    )
    parser.add_argument(
        "--quick", action="store_true", help="fewer captures, minutes instead of a quarter of an hour"
    )
    parser.add_argument("--out", type=Path, default=Path(__file__).with_name("RESULTS.md"))
    parser.add_argument("--feed", nargs=2, help=argparse.SUPPRESS)
    given = parser.parse_args()
    if given.feed:
        feed(Path(given.feed[0]), float(given.feed[1]))
        return
    captures, seconds = (4, 60.0) if given.quick else (10, 240.0)
    with tempfile.TemporaryDirectory() as place:
        folder = Path(place).resolve()
        shares: dict[bool, list[float]] = {False: [], True: []}
        for number in range(3):
            for watched in (False, True):
                shares[watched] += overhead(folder / f"{number}{watched}", captures, watched)
        desk = folder / "desk"
        desk.mkdir()
        found = memory(desk, seconds)
    flat, captures_8h = "flat", int(HOURS * 3600 / HOLD_S)
    looks = f"{found.asked:,} looks, as many as in {found.asked * ASK_S / 60:.0f} min"
    rows = [
        (
            f"overhead of a 3 s capture, {MARKERS} markers at {FRAME_HZ:g} Hz, nobody watching",
            _share(shares[False]),
            "",
        ),
        (
            f"the same, asked for its state every {ASK_S:g} s by another process",
            _share(shares[True]),
            "at most 2 %",
        ),
        (
            f"memory of a run after 1 h and after {HOURS:g} h of data, {captures_8h:,} captures",
            _pair(found.run),
            flat,
        ),
        (
            "of the workbench's server, in one process with what drives the browser here",
            _pair(found.server),
            flat,
        ),
        ("of the process that holds a model against all the captures", f"{found.model:.0f} MB", ""),
        (f"heap of the page that watches, {looks}", _pair(found.heap), flat),
        ("memory of the browser's tab", _pair(found.tab), flat),
    ]
    quick, system = " --quick" if given.quick else "", f"{platform.machine()}, {os.cpu_count()} cores"
    head = f"`python benchmarks/workbench_live.py{quick}` on {system}, Python {platform.python_version()}."
    table = [f"| {' | '.join(row)} |" for row in rows]
    below = [head, "", "| What | Measured | Asked for |", "|---|---|---|", *table]
    write_section(given.out, "## Watching a run", below)
    print("\n".join(below))


def _share(shares: list[float]) -> str:
    return (
        f"{100 * statistics.median(shares):.2f} % (worst {100 * max(shares):.2f} %, {len(shares)} captures)"
    )


def _pair(values: tuple[float, float]) -> str:
    return f"{values[0]:.0f} MB, {values[1]:.0f} MB"


if __name__ == "__main__":
    main()
