"""How fast motion capture is read: frames a second from bytes, and frames lost in a long stream.

    python benchmarks/cgstream.py [--minutes 10] [--rate-hz 400] [--out cgstream.json]

Three figures:
- decoding: bytes of 34 markers to labrig's marker arrays, on one core, everything in memory;
- stream: the twin at `--rate-hz` over TCP, in a process of its own, for `--minutes`, each frame appended
  to a log that is flushed and fsynced every second; frames lost, duplicated, dropped;
- beside it the PyPI client `motioncapture` (Vicon's own C++ SDK inside, if it is installed), which hands
  out one rigid body and no markers: how many frames a second it returns from the same kind of server.
"""

import argparse
import importlib.util
import json
import multiprocessing
import os
import struct
import subprocess
import sys
import tempfile
import time
from pathlib import Path
from typing import Any

import numpy as np

from labrig.bench._report import write_section
from labrig_drivers import Channel, RealClock
from labrig_drivers._cgstream import block, packet
from labrig_drivers._cgstream_session import ClientSession
from labrig_drivers._vicon import Vicon, ViconOptions
from labrig_drivers._vicon_markers import MarkerTable
from labrig_drivers.simulated._vicon_encode import Scene, contents
from labrig_drivers.simulated._vicon_server import ViconServer
from labrig_drivers.simulated._wire_plant import SharedPlant

NAMES = tuple(f"m{number:02d}" for number in range(1, 35))

CLIENT = """
import sys, time, motioncapture
capture = motioncapture.connect("vicon", {"hostname": sys.argv[1]})
capture.waitForNextFrame()
end, count = time.monotonic() + float(sys.argv[2]), 0
while time.monotonic() < end:
    capture.waitForNextFrame()
    count += 1
print(count / float(sys.argv[2]))
"""


class WavingPlant:
    """34 markers in slow waves, some of them covered now and then: cheap, so that the client is measured."""

    channels = (Channel("c1", 0, 60),)
    marker_names = NAMES
    rest_mm = np.arange(102.0).reshape(34, 3)

    def __init__(self) -> None:
        self._chance = np.random.default_rng(0)

    def observe(self, time_s: float) -> tuple[np.ndarray, np.ndarray]:
        """Positions and statuses now."""
        position_mm = self.rest_mm + np.sin(time_s + np.arange(34.0))[:, None]
        covered = self._chance.random(34) < 0.03
        position_mm[covered] = np.nan
        return position_mm, covered.astype(np.int8)


def decoding(frames: int = 20_000, chunk_bytes: int = 65536) -> dict[str, Any]:
    """Frames a second from bytes in memory to marker arrays, of 34 markers with all usual objects."""
    scene = Scene("torso", NAMES, 400.0)
    chance = np.random.default_rng(0)
    statics = scene.static_blocks()
    enums = sorted({*statics, 5, 6, 7, 23, 26, 36, 100004})
    stream = bytearray(packet([block(100001, struct.pack(f"<{len(enums) + 1}I", len(enums), *enums))]))
    stream += packet(statics.values())
    for number in range(frames):
        position_mm = WavingPlant.rest_mm + chance.standard_normal((34, 3))
        position_mm[chance.random(34) < 0.03] = np.nan
        made = scene.frame_blocks(number, position_mm, 0.0)
        sent = {n: made[n] for n in enums if n in made}
        head = block(100004, contents(dict.fromkeys(sent, 1), statics))
        stream += packet([head, *sent.values()])
    session, table = ClientSession(), MarkerTable(NAMES)
    data = bytes(stream)
    count = seen = 0
    began = time.process_time()
    for at in range(0, len(data), chunk_bytes):
        for frame in session.receive(data[at : at + chunk_bytes]):
            _, status = table.place(frame)
            count += 1
            seen += int(status[0] == 0)
    took_s = time.process_time() - began
    assert count == frames
    return {
        "frames": frames,
        "frames_per_s": round(frames / took_s),
        "us_per_frame": round(took_s / frames * 1e6, 1),
        "mb_per_s": round(len(data) / took_s / 1e6, 1),
    }


def serve(rate_hz: float, port: Any, stop: Any) -> None:
    """The twin, in a process of its own."""
    server = ViconServer(SharedPlant(WavingPlant(), RealClock()), rate_hz=rate_hz).start()  # type: ignore[arg-type]
    port.value = server.port
    stop.wait()
    server.stop()


class Server:
    """A twin in another process; a context manager that gives its port."""

    def __init__(self, rate_hz: float) -> None:
        context = multiprocessing.get_context("spawn")
        self._port = context.Value("i", 0)
        self._stop = context.Event()
        self._process = context.Process(target=serve, args=(rate_hz, self._port, self._stop))

    def __enter__(self) -> int:
        self._process.start()
        while not self._port.value:
            time.sleep(0.01)
        return int(self._port.value)

    def __exit__(self, *_: object) -> None:
        self._stop.set()
        self._process.join()


def stream(rate_hz: float, seconds: float) -> dict[str, Any]:
    """Frames received and lost in a stream beside a log that is flushed and fsynced every second."""
    with Server(rate_hz) as port, tempfile.NamedTemporaryFile(buffering=1 << 20) as log:
        device = Vicon("mocap", NAMES, RealClock(), ViconOptions(port=port))
        device.connect()
        numbers: list[int] = []
        cpu = time.process_time()
        began = synced = time.monotonic()
        while (now := time.monotonic()) - began < seconds:
            for frame in device.frames():
                if np.all(frame.status == 2):
                    continue
                numbers.append(frame.number)
                log.write(struct.pack("<dI", frame.time_s, frame.number) + frame.position_mm.tobytes())
            if now - synced > 1.0:
                synced = now
                log.flush()
                os.fsync(log.fileno())
            time.sleep(0.02)
        cpu_s = time.process_time() - cpu
        written = log.tell()
        device.close()
    steps = np.diff(np.array(numbers))
    return {
        "rate_hz": rate_hz,
        "seconds": seconds,
        "frames": len(numbers),
        "expected": round(rate_hz * seconds),
        "lost": int(np.sum(np.maximum(steps - 1, 0))),
        "repeated_or_backward": int(np.sum(steps < 1)),
        "dropped_by_the_client": device.dropped,
        "cpu_percent": round(100 * cpu_s / seconds, 1),
        "log_mb": round(written / 1e6, 1),
    }


def vicons_own_client(rate_hz: float, seconds: float = 10.0) -> dict[str, Any] | None:
    """Frames a second that `motioncapture` returns, and that labrig's client returns in its place."""
    if importlib.util.find_spec("motioncapture") is None:
        return None
    with Server(rate_hz) as port:
        done = subprocess.run(
            [sys.executable, "-c", CLIENT, f"127.0.0.1:{port}", str(seconds)],
            capture_output=True,
            text=True,
            timeout=seconds + 30,
            check=True,
        )
    ours = stream(rate_hz, seconds)
    return {
        "rate_hz": rate_hz,
        "motioncapture_frames_per_s": round(float(done.stdout), 1),
        "labrig_frames_per_s": round(ours["frames"] / seconds, 1),
    }


def table(results: dict[str, Any]) -> list[str]:
    """The section of RESULTS.md."""
    decoding_, stream_, beside = results["decoding"], results["stream"], results["vicons_own_client"]
    lines = [
        "`python benchmarks/cgstream.py`, server and client on one computer over loopback.",
        "",
        "| What | Measured | Asked for |",
        "|---|---|---|",
        f"| decoding frames of 34 markers, one core | {decoding_['frames_per_s']:,} /s | at least 5,000 /s |",
        f"| stream at {stream_['rate_hz']:.0f} Hz for {stream_['seconds'] / 60:.0f} min beside a log fsynced "
        f"each second: frames that came | {stream_['frames']:,} of {stream_['expected']:,} | |",
        f"| of these lost, repeated or backward | {stream_['lost']}, {stream_['repeated_or_backward']} | 0 |",
        f"| processor | {stream_['cpu_percent']} % of one core | |",
    ]
    if beside:
        lines.append(
            f"| at {beside['rate_hz']:.0f} Hz, frames a second: Vicon's own client (`motioncapture`), ours | "
            f"{beside['motioncapture_frames_per_s']}, {beside['labrig_frames_per_s']} | |"
        )
    return lines


def main() -> int:
    """Measure and print; 1 when a target is missed."""
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawTextHelpFormatter)
    parser.add_argument("--minutes", type=float, default=10.0)
    parser.add_argument("--rate-hz", type=float, default=400.0)
    parser.add_argument("--out", type=Path)
    parser.add_argument("--results", type=Path, help="Markdown file whose section is to be written")
    options = parser.parse_args()
    results: dict[str, Any] = {"decoding": decoding()}
    print("decoding", results["decoding"], flush=True)
    results["vicons_own_client"] = vicons_own_client(options.rate_hz)
    print("beside motioncapture", results["vicons_own_client"], flush=True)
    results["stream"] = stream(options.rate_hz, 60.0 * options.minutes)
    print("stream", results["stream"], flush=True)
    if options.out is not None:
        options.out.write_text(json.dumps(results, indent=1), encoding="utf-8")
    if options.results is not None:
        write_section(options.results, "## Motion capture", table(results))
    well = results["decoding"]["frames_per_s"] >= 5000 and results["stream"]["lost"] == 0
    return int(not well)


if __name__ == "__main__":
    sys.exit(main())
