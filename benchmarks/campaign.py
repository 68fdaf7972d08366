"""What a campaign costs: overhead per capture, log writing, opening an hour, and bluesky's RunEngine beside it.

    python benchmarks/campaign.py [--quick] [--out benchmarks/RESULTS.md]

bluesky is compared if it can be imported (pip install bluesky). Writes the section "Campaigns" of the results.
"""

import argparse
import json
import os
import platform
import statistics
import tempfile
import time
from collections.abc import Callable
from itertools import pairwise
from pathlib import Path
from typing import Any
from unittest import mock

import numpy as np
from _streaming import CHAMBER_NAMES, CHAMBERS, FRAME_HZ, MARKER_NAMES, MARKERS, SAMPLE_HZ, make_rig

from labrig.bench._report import write_section
from labrig.campaign import Actuate, Procedure, Record, RigInfo, Settle, Steps, run
from labrig.log import Layout, LogWriter, Topic, load_segments, open_run
from labrig_drivers import MarkerFrame, RealClock, SimulatedClock
from labrig_schema.step_pb2 import Step


class Captures(Procedure):
    """The same capture many times."""

    count: int = 10
    settle_s: float = 3.0
    record_s: float = 1.0

    def steps(self, rig: RigInfo) -> Steps:
        """Actuate, settle, record."""
        for number in range(self.count):
            yield Actuate([float(number % 50)] * len(rig.channels))
            yield Settle(self.settle_s)
            if self.record_s:
                yield Record(self.record_s)


def overhead(folder: Path, captures: int) -> tuple[float, float]:
    """Mean and largest overhead of a capture on the real clock, as a share of its 3 s, from the log's own times."""
    clock = RealClock()
    procedure = Captures(count=captures, settle_s=2.0, record_s=1.0)
    run(procedure, make_rig(clock), folder, clock)
    segments, _ = load_segments(folder)
    messages = segments[0].messages(Topic.STEP)
    steps = [Step.FromString(payload) for payload in messages.payload]
    starts = [step.started_s for step in steps if step.state == Step.DONE and step.kind == "actuate"]
    shares = [(later - earlier - 3.0) / 3.0 for earlier, later in pairwise(starts)]
    return statistics.fmean(shares), max(shares)


def _frames(count: int) -> list[MarkerFrame]:
    rng = np.random.default_rng(1)
    status = np.zeros(MARKERS, np.int8)
    positions = rng.normal(scale=50.0, size=(200, MARKERS, 3))
    return [MarkerFrame(1e9 + n / FRAME_HZ, n, positions[n % 200], status) for n in range(count)]


def _layout() -> Layout:
    zeros, tops = (0.0,) * CHAMBERS, (60.0,) * CHAMBERS
    return Layout(tuple(CHAMBER_NAMES), zeros, tops, markers=tuple(MARKER_NAMES), start_s=1e9)


def writing(folder: Path, count: int, rounds: int = 5) -> dict[str, float]:
    """Frames per second into a log: labrig's writer, and the mcap library's with the same messages ready encoded
    and with them encoded as it writes. The best of some rounds each, for the disk is shared.
    """
    frames = _frames(count)
    rates: dict[str, list[float]] = {"labrig": [], "raw": [], "encoded": []}
    for number in range(rounds):
        path = folder / f"labrig{number}.mcap"
        writer = LogWriter(path, _layout())
        begin = time.perf_counter()
        for frame in frames:
            writer.frame(frame)
        writer.step_done()
        rates["labrig"].append(count / (time.perf_counter() - begin))
        writer.close()
        for name in ("raw", "encoded"):
            rates[name].append(count / _raw(folder / f"{name}{number}.mcap", frames, name == "encoded"))
        path.unlink()
    return {name: max(values) for name, values in rates.items()}


def _raw(path: Path, frames: list[MarkerFrame], encoding: bool) -> float:
    """Seconds that the mcap library's writer takes for the same messages."""
    from foxglove_schemas_protobuf.PackedElementField_pb2 import PackedElementField
    from foxglove_schemas_protobuf.PointCloud_pb2 import PointCloud
    from mcap.writer import Writer

    def encode(frame: MarkerFrame) -> bytes:
        cloud = PointCloud(frame_id="rig", point_stride=13)
        cloud.pose.orientation.w = 1.0
        for offset, name in ((0, "x"), (4, "y"), (8, "z")):
            cloud.fields.add(name=name, offset=offset, type=PackedElementField.FLOAT32)
        cloud.fields.add(name="status", offset=12, type=PackedElementField.UINT8)
        points = np.zeros(MARKERS, dtype=[("p", "<f4", (3,)), ("s", "u1")])
        points["p"], points["s"] = frame.position_mm, frame.status
        cloud.data = points.tobytes()
        cloud.timestamp.FromNanoseconds(int(frame.time_s * 1e9))
        return cloud.SerializeToString()

    ready = [] if encoding else [encode(frame) for frame in frames]
    with path.open("wb") as file:
        writer = Writer(file)
        writer.start()
        channel = writer.register_channel(
            "/mocap/markers", "protobuf", writer.register_schema("x", "protobuf", b"")
        )
        begin = time.perf_counter()
        for index, frame in enumerate(frames):
            time_ns = int(frame.time_s * 1e9)
            writer.add_message(channel, time_ns, encode(frame) if encoding else ready[index], time_ns, index)
        writer.flush()
        os.fsync(file.fileno())
        took_s = time.perf_counter() - begin
    path.unlink()
    return took_s


def opening(folder: Path, minutes: float) -> tuple[float, float, int, float]:
    """Seconds to open a campaign of some minutes at full rate (the best of five, and of the processor's own time),
    its captures, and its size in MB.
    """
    clock = SimulatedClock(1e9)
    procedure = Captures(count=int(minutes * 60 / 4.0))
    run(procedure, make_rig(clock), folder, clock)
    open_run(folder).close()  # imports, and the disk's cache
    walls, processor = [], []
    captures = 0
    for _ in range(5):
        begin, begin_cpu = time.perf_counter(), time.process_time()
        captures = open_run(folder).sizes["capture"]
        walls.append(time.perf_counter() - begin)
        processor.append(time.process_time() - begin_cpu)
    size = sum(path.stat().st_size for path in folder.glob("log.*"))
    return min(walls), min(processor), captures, size / 1e6


def step_cost(folder: Path, captures: int, durable: bool) -> float:
    """Milliseconds per capture (actuate, settle, record), log included, without waiting; `durable`: with fsync."""
    if not durable:
        with mock.patch("os.fsync"):
            return step_cost(folder, captures, True)
    clock = SimulatedClock(1e9)
    begin = time.perf_counter()
    run(Captures(count=captures, settle_s=0.05, record_s=0.05), make_rig(clock, 20.0, 20.0), folder, clock)
    return (time.perf_counter() - begin) / captures * 1e3


def bluesky_cost(folder: Path, captures: int) -> tuple[float, float] | None:
    """The same plan under bluesky's RunEngine: milliseconds per capture without and with a durable log.

    Devices are as little as bluesky takes. The durable log is a line of JSON per document, fsynced at each event.
    """
    try:
        import bluesky.plan_stubs as bps
        import bluesky.preprocessors as bpp
        from bluesky import RunEngine
    except ImportError:
        return None
    done = _finished_status()

    class Device:
        parent = None

        def __init__(self, name: str, width: int) -> None:
            self.name, self.values = name, np.zeros(width).tolist()

        def set(self, value: Any) -> Any:
            self.values = list(value)
            return done

        def trigger(self) -> Any:
            return done

        def read(self) -> dict[str, Any]:
            return {self.name: {"value": self.values, "timestamp": time.time()}}

        def describe(self) -> dict[str, Any]:
            return {self.name: {"source": "simulated", "dtype": "array", "shape": [len(self.values)]}}

        def read_configuration(self) -> dict[str, Any]:
            return {}

        def describe_configuration(self) -> dict[str, Any]:
            return {}

    pressure, mocap = Device("pressure", CHAMBERS), Device("mocap", 3 * MARKERS)

    @bpp.run_decorator()
    def plan() -> Any:
        for number in range(captures):
            yield from bps.mv(pressure, [float(number % 50)] * CHAMBERS)
            yield from bps.sleep(0)
            yield from bps.trigger_and_read([pressure, mocap])

    def timed(subscribe: Callable[[Any], None]) -> float:
        engine = RunEngine({}, context_managers=[])
        subscribe(engine)
        begin = time.perf_counter()
        engine(plan())
        took_s = time.perf_counter() - begin
        engine.loop.call_soon_threadsafe(engine.loop.stop)
        return took_s / captures * 1e3

    def with_log(engine: Any) -> None:
        file = (folder / "documents.jsonl").open("w")

        def write(name: str, document: dict[str, Any]) -> None:
            file.write(json.dumps([name, document], default=str) + "\n")
            if name == "event":
                file.flush()
                os.fsync(file.fileno())

        engine.subscribe(write)

    return timed(lambda _: None), timed(with_log)


def _finished_status() -> Any:
    class Finished:
        done, success = True, True

        def add_callback(self, callback: Callable[[Any], None]) -> None:
            callback(self)

        def exception(self, timeout: float | None = None) -> None:
            return None

    return Finished()


def soak(folder: Path, hours: float) -> dict[str, float]:
    """A long campaign on the simulated clock: memory at a tenth and at the end, files, and what is lost."""
    import psutil

    clock = SimulatedClock(1e9)
    count = int(hours * 3600 / 4.0)
    memory: list[float] = []
    process = psutil.Process()

    class Long(Captures):
        def steps(self, rig: RigInfo) -> Steps:
            for number, step in enumerate(super().steps(rig)):
                if number % max(1, 3 * count // 20) == 0:
                    memory.append(process.memory_info().rss / 1e6)
                yield step

    begin = time.perf_counter()
    run(Long(count=count), make_rig(clock, 20.0, 10.0), folder, clock)
    logs = sorted(folder.glob("log.*"))
    in_run = memory[len(memory) // 2 :]  # the first half is the dry run's
    return {
        "captures": count,
        "took_s": time.perf_counter() - begin,
        "early_mb": in_run[2],
        "late_mb": in_run[-1],
        "files": len(logs),
        "largest_mb": max(path.stat().st_size for path in logs) / 1e6,
        "total_mb": sum(path.stat().st_size for path in logs) / 1e6,
    }


def main() -> None:
    """Measure everything and write the section."""
    parser = argparse.ArgumentParser(
        description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter
    )
    parser.add_argument("--quick", action="store_true", help="smaller numbers, to see that it works")
    parser.add_argument("--out", type=Path, default=Path(__file__).parent / "RESULTS.md")
    options = parser.parse_args()
    quick = options.quick
    with tempfile.TemporaryDirectory() as name:
        folder = Path(name)
        lines = [
            f"`python benchmarks/campaign.py` on {platform.machine()}, {os.cpu_count()} cores, "
            f"Python {platform.python_version()}.",
            "",
            "| What | Measured | Asked for |",
            "|---|---|---|",
        ]
        mean, worst = overhead(folder / "overhead", 3 if quick else 20)
        lines.append(
            f"| overhead of a 3 s capture, real clock, {MARKERS} markers at {FRAME_HZ:g} Hz, {CHAMBERS} pressures at "
            f"{SAMPLE_HZ:g} Hz | {100 * mean:.2f} % (worst {100 * worst:.2f} %) | at most 2 % |"
        )
        rates = writing(folder, 2000 if quick else 20000)
        lines.append(
            f"| log writing, frames of {MARKERS} markers: labrig | {rates['labrig']:,.0f} /s | |\n"
            f"| the mcap library's writer, messages encoded as it goes | {rates['encoded']:,.0f} /s "
            f"(labrig: {100 * rates['labrig'] / rates['encoded']:.0f} %) | at least 80 % |\n"
            f"| the same, messages encoded beforehand | {rates['raw']:,.0f} /s "
            f"(labrig: {100 * rates['labrig'] / rates['raw']:.0f} %) | |"
        )
        minutes = 3 if quick else 60
        took_s, processor_s, captures, size = opening(folder / "hour", minutes)
        lines.append(
            f"| opening {minutes} min as xarray: {captures} captures, {size:.0f} MB | {took_s:.2f} s "
            f"({processor_s:.2f} s of one core) | at most 3 s |"
        )
        count = 100 if quick else 2000
        ours = [step_cost(folder / f"steps{durable:d}", count, durable) for durable in (False, True)]
        lines.append(
            f"| cost of a capture (3 steps), nothing waited for, logged: labrig | {ours[0]:.2f} ms | |\n"
            f"| the same, fsynced at each of the 3 steps | {ours[1]:.2f} ms | |"
        )
        theirs = bluesky_cost(folder, count)
        if theirs is None:
            lines.append("| the same plan under bluesky | not installed | |")
        else:
            import bluesky

            lines.append(
                f"| the same plan under bluesky {bluesky.__version__}'s RunEngine, nothing kept "
                f"| {theirs[0]:.2f} ms | |\n"
                f"| the same, documents as JSON, fsynced at each event | {theirs[1]:.2f} ms | |"
            )
        long = soak(folder / "soak", 0.5 if quick else 24)
        lines.append(
            f"| soak, {long['captures']:.0f} captures on the simulated clock in {long['took_s']:.0f} s: memory early "
            f"and late | {long['early_mb']:.0f} MB, {long['late_mb']:.0f} MB | flat |\n"
            f"| its log | {long['files']:.0f} files, {long['total_mb']:.0f} MB, largest {long['largest_mb']:.0f} MB | |"
        )
    write_section(options.out, "## Campaigns", lines)
    print("\n".join(lines))


if __name__ == "__main__":
    main()
