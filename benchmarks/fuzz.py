"""Fuzzes every parser that reads what a device sends: no crash, no hang, bounded memory.

    python benchmarks/fuzz.py [--inputs 1000000] [--seed 0] [--only NAME] [--out fuzz.json]

Inputs are valid sessions that were damaged (bytes flipped, cut, repeated, spliced, lengths made absurd),
and plain noise. A parser may return events or raise its own error; anything else is a finding, printed
with the input in hex. The table says how many inputs were read and how long the slowest one took.
"""

import argparse
import json
import random
import struct
import sys
import time
import tracemalloc
from collections.abc import Callable
from pathlib import Path
from types import SimpleNamespace
from typing import Any

import numpy as np

from labrig.bench._report import write_section
from labrig_drivers._artec_files import ScanFileError, parse
from labrig_drivers._cgstream import MAGIC, CgstreamError, block, packet
from labrig_drivers._cgstream_session import ClientSession
from labrig_drivers._modbus import ModbusOptions, ModbusWire
from labrig_drivers._modbus_map import load_map
from labrig_drivers._openpneu_stream import StreamParser, telemetry_line
from labrig_drivers._recording import RecordingError, parse_piece
from labrig_drivers._transport import LinkError
from labrig_drivers._vicon_markers import MarkerTable
from labrig_drivers._wired_pressure import WireError
from labrig_drivers.simulated._artec_twin import obj_bytes, ply_bytes, stl_bytes, xyz_bytes
from labrig_drivers.simulated._openpneu_board import OpenPneuBoard
from labrig_drivers.simulated._vicon_encode import Scene, contents
from labrig_drivers.simulated._vicon_server import TwinClient, ViconServer

SLOW_S = 2.0
ABSURD = (0, 1, 0x7FFFFFFF, 0x80000000, 0xFFFFFFFF, 0xFFFF, MAGIC)


def damaged(chance: random.Random, seeds: list[bytes]) -> bytes:
    """A seed with up to four wounds, or now and then noise."""
    if chance.random() < 0.05:
        return chance.randbytes(chance.randrange(200))
    data = bytearray(chance.choice(seeds))
    for _ in range(chance.randrange(5)):
        if not data:
            break
        at = chance.randrange(len(data))
        wound = chance.randrange(6)
        if wound == 0:
            data[at] = chance.randrange(256)
        elif wound == 1:
            del data[at:]
        elif wound == 2:
            del data[at : at + chance.randrange(1, 12)]
        elif wound == 3:
            data[at:at] = data[at : at + chance.randrange(1, 40)]
        elif wound == 4:
            data[at : at + 4] = struct.pack("<I", chance.choice(ABSURD))
        else:
            other = chance.choice(seeds)
            data[at:] = other[chance.randrange(len(other)) :]
    return bytes(data)


def vicon_client(chance: random.Random) -> tuple[list[bytes], Callable[[bytes], None]]:
    """What a DataStream server sends, through session and marker table."""
    names = ("m1", "m2", "m3")
    scene = Scene("arm", names)
    statics = scene.static_blocks()
    made = scene.frame_blocks(7, np.arange(9.0).reshape(3, 3), 0.0, np.ones((2, 3)))
    enums = sorted({*statics, *made, 42, 100004})
    hello = packet([block(100001, struct.pack(f"<{len(enums) + 1}I", len(enums), *enums))])
    head = block(100004, contents(dict.fromkeys(made, 1), [1, 2]))
    seeds = [
        hello + packet([*statics.values(), *made.values()]),
        hello + packet([*statics.values()]) + packet([head, *made.values()]),
        packet([head, *statics.values(), *made.values(), block(42, bytes(8)), block(100003, b"")]),
        *[packet([data]) for data in (*statics.values(), *made.values())],
    ]
    table = MarkerTable(names)

    def read(data: bytes) -> None:
        session = ClientSession(max_packet_bytes=1 << 16)
        session.accept_all()
        size = chance.choice((7, 64, 100_000))
        try:
            for at in range(0, len(data), size):
                for frame in session.receive(data[at : at + size]):
                    position, _ = table.place(frame)
                    assert position.shape == (3, 3)
        except CgstreamError:
            return
        assert session._reader.pending_bytes <= (1 << 16) + 8
        assert len(session.outgoing()) < 100 * (len(data) + 10)

    return seeds, read


def openpneu_driver(chance: random.Random) -> tuple[list[bytes], Callable[[bytes], None]]:
    """What an OpenPneu board sends."""
    line = telemetry_line((0.0, -5.25, 100.0, 4.0, 5.0, 6.0, 7.0, 8.0, 9.0, 60.0))
    seeds = [
        line,
        b"Timer St" + line + b"arts...\r\n" + line,
        b"OK;Successful\r\nOpenPneu2.0\r\n",
        b"ADD=01\r\n3=20.00\r\nVal=1.5\r\n",
        b"Stop All Motors\r" + line + b"\n",
    ]

    def read(data: bytes) -> None:
        parser = StreamParser()
        size = chance.choice((1, 7, 1000))
        for at in range(0, len(data), size):
            parser.feed(data[at : at + size])
        assert len(parser._line) + len(parser._candidate) < 1000

    return seeds, read


class _NoPlant:
    """A plant for a board that nobody listens to."""

    channels = (None,) * 4

    def command(self, pressure_kpa: Any) -> None:
        """Nothing moves."""

    def pressure_kpa(self) -> np.ndarray:
        """Ambient."""
        return np.zeros(4)


def openpneu_twin(chance: random.Random) -> tuple[list[bytes], Callable[[bytes], None]]:
    """What a host sends to the OpenPneu twin, in both dialects."""
    boards = [OpenPneuBoard(_NoPlant(), dialect) for dialect in ("published", "table")]  # type: ignore[arg-type]
    seeds = [
        b"AT\r\nSC=3\r\nT=12.5\r\nC\r\n",
        b"ST=2\r\nV\r\nP\r\nPP\r\nAT+PRESSURE\r\nAT+VERSION\r\n",
        b"PSET=3,20\r\nPSET:1,2,3;\r\nPREAD=9\r\nCON\r\nAT+RST\r\n",
    ]

    def read(data: bytes) -> None:
        board = chance.choice(boards)
        board.feed(data)
        assert len(board._line) <= 128

    return seeds, read


def modbus_driver(chance: random.Random) -> tuple[list[bytes], Callable[[bytes], None]]:
    """What a Modbus server answers, through pymodbus and the driver."""
    from pymodbus.client import ModbusTcpClient

    wire = ModbusWire(ModbusOptions(load_map("festo-vtem.yaml"), (0, 1, 2, 3), host="127.0.0.1"))
    client = ModbusTcpClient("127.0.0.1", timeout=0.001, retries=0)
    client.socket = object()  # type: ignore[assignment]
    client.connect = lambda: True  # type: ignore[method-assign]
    client.close = lambda: None  # type: ignore[method-assign]
    answers: list[bytes] = []
    client.transaction.low_level_send = lambda request, addr=None: len(request)
    client.transaction.count_until_disconnect = client.transaction.max_until_disconnect = 1 << 60
    client.recv = lambda size: answers.pop(0) if answers else b""  # type: ignore[method-assign]
    wire._client = client
    registers = struct.pack(">5H", 1, 2, 0x8000, 0xFFFF, 9)

    def answer(body: bytes, transaction: int) -> bytes:
        return struct.pack(">HHHB", transaction, 0, len(body) + 1, 1) + body

    def read(data: bytes) -> None:
        before = client.transaction.next_tid
        whole = struct.pack(">H", 1 if before >= 65000 else before + 1) + data[2:]
        cut = chance.randrange(len(whole) + 1)
        answers[:] = [whole[:cut], whole[cut:]]
        wire._next_poll = 0.0
        try:
            wire.poll(0.0)
        except (LinkError, WireError):
            return

    seeds = [
        answer(b"\x03\x0a" + registers, 0),
        answer(b"\x83\x02", 0),
        answer(b"\x06\x9c\x43\x00\x03", 0),
        answer(b"\x03\x02\x00\x83", 0),
    ]
    return seeds, read


def vicon_twin(chance: random.Random) -> tuple[list[bytes], Callable[[bytes], None]]:
    """What a client sends to the DataStream twin."""
    plant = SimpleNamespace(marker_names=("m1",), plant=SimpleNamespace(rest_mm=np.zeros((1, 3))))
    server = ViconServer(plant)  # type: ignore[arg-type]
    enums = struct.pack("<5I", 4, 1, 2, 5, 6)
    seeds = [
        packet([block(100001, enums)]) + packet([block(100002, b"\x01")]),
        packet([block(100002, b"\0"), block(100008, struct.pack("<I", 1)), block(42, bytes(8))]),
        packet([block(100007, struct.pack("<4I", 1, 6, 1, 1)), block(100003, b""), block(42, bytes(8))]),
    ]

    def read(data: bytes) -> None:
        client = TwinClient(None)  # type: ignore[arg-type]
        size = chance.choice((7, 100_000))
        try:
            for at in range(0, len(data), size):
                server.take(client, data[at : at + size])
        except CgstreamError:
            return
        assert len(client.pings) <= 64
        assert client.reader.pending_bytes <= len(data)

    return seeds, read


def recordings(chance: random.Random) -> tuple[list[bytes], Callable[[bytes], None]]:
    """Lines of a recording of a session."""
    del chance
    seeds = [
        b"0.000100 > 41540d0a\n0.5 < 4f4b\n",
        b"1e3 < 00\n",
        b"12.25 > \n",
        b"0 < " + b"ab" * 200 + b"\n",
    ]
    path = Path("a.wire")

    def read(data: bytes) -> None:
        for number, line in enumerate(data.decode("ascii", "replace").splitlines()):
            try:
                piece = parse_piece(line, path, number)
            except RecordingError:
                continue
            assert piece.time_s >= 0
            assert len(piece.data) <= len(line)

    return seeds, read


def scan_files(chance: random.Random) -> tuple[list[bytes], Callable[[bytes], None]]:
    """Scan files of every format."""
    vertices = np.array([[0.0, 0, 0], [100, 0, 0], [0, 100, 0], [100, 100, 10]])
    triangles = np.array([[0, 1, 2], [1, 3, 2]])
    text_ply = (
        "ply\nformat ascii 1.0\nelement vertex 3\nproperty float x\nproperty float y\nproperty float z\n"
        "element face 1\nproperty list uchar int vertex_indices\nend_header\n"
        "0 0 0\n1 0 0\n0 1 0\n3 0 1 2\n"
    )
    text_stl = (
        "solid a\nfacet normal 0 0 1\nouter loop\nvertex 0 0 0\nvertex 1 0 0\nvertex 0 1 0\nendloop\n"
        "endfacet\nendsolid a\n"
    )
    kinds = {
        "a.obj": [obj_bytes(vertices, triangles, "a.mtl", seams=True)],
        "a.ply": [ply_bytes(vertices, triangles), text_ply.encode()],
        "a.stl": [stl_bytes(vertices, triangles), text_stl.encode()],
        "a.xyz": [xyz_bytes(vertices, triangles)],
    }

    def read(data: bytes) -> None:
        name = _kind_of(data)
        try:
            geometry = parse(data, name)
        except ScanFileError:
            return
        assert np.isfinite(geometry.vertices).all()
        assert len(geometry.triangles) == 0 or geometry.triangles.max() < len(geometry.vertices)

    def _kind_of(data: bytes) -> str:
        if data.startswith(b"ply"):
            return "a.ply"
        if data.startswith((b"solid", b"exported")):
            return "a.stl"
        if b"v " in data:
            return "a.obj"
        return chance.choice(list(kinds))

    return [seed for seeds in kinds.values() for seed in seeds], read


PARSERS = {
    "vicon client": vicon_client,
    "vicon twin": vicon_twin,
    "openpneu driver": openpneu_driver,
    "openpneu twin": openpneu_twin,
    "modbus driver": modbus_driver,
    "scan files": scan_files,
    "recordings": recordings,
}


def fuzz(name: str, inputs: int, seed: int) -> dict[str, Any]:
    """Feed `inputs` damaged inputs to a parser; the figures, and the first findings in hex."""
    chance = random.Random(f"{seed} {name}")
    seeds, read = PARSERS[name](chance)
    findings: list[str] = []
    slowest_s = 0.0
    _one(read, damaged(chance, seeds), findings)
    tracemalloc.start()
    for _ in range(min(2000, inputs)):  # memory, on a part: tracing is slow
        _one(read, damaged(chance, seeds), findings)
    peak_bytes = tracemalloc.get_traced_memory()[1]
    tracemalloc.stop()
    began = time.perf_counter()
    for _ in range(inputs):
        if len(findings) > 20:
            break
        data = damaged(chance, seeds)
        before = time.perf_counter()
        _one(read, data, findings)
        took_s = time.perf_counter() - before
        if took_s > slowest_s:
            slowest_s = took_s
            if took_s > SLOW_S:
                findings.append(f"took {took_s:.1f} s: {data.hex()}")
    return {
        "parser": name,
        "inputs": inputs,
        "seconds": round(time.perf_counter() - began, 1),
        "slowest_ms": round(slowest_s * 1e3, 2),
        "peak_kb": round(peak_bytes / 1024),
        "findings": findings,
    }


def _one(read: Callable[[bytes], None], data: bytes, findings: list[str]) -> None:
    try:
        read(data)
    except Exception as error:
        findings.append(f"{type(error).__name__}: {error}: {data.hex()}")


def table(results: list[dict[str, Any]]) -> list[str]:
    """The section of RESULTS.md."""
    lines = [
        "`python benchmarks/fuzz.py`: a finding is a hang, a crash, or any error but the device's own.",
        "",
        "| Parser | inputs | findings | slowest, ms | peak memory, kB |",
        "|---|---|---|---|---|",
    ]
    for r in results:
        findings, slowest, peak = len(r["findings"]), r["slowest_ms"], r["peak_kb"]
        lines.append(f"| {r['parser']} | {r['inputs']:,} | {findings} | {slowest} | {peak} |")
    return lines


def main() -> int:
    """Fuzz, print the table; 1 if anything was found."""
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawTextHelpFormatter)
    parser.add_argument("--inputs", type=int, default=1_000_000)
    parser.add_argument("--seed", type=int, default=0)
    parser.add_argument("--only", choices=list(PARSERS))
    parser.add_argument("--out", type=Path)
    parser.add_argument("--results", type=Path, help="Markdown file whose section is to be written")
    options = parser.parse_args()
    results = []
    print(f"{'parser':18} {'inputs':>9} {'seconds':>8} {'slowest ms':>11} {'peak kB':>8} findings")
    for name in [options.only] if options.only else PARSERS:
        result = fuzz(name, options.inputs, options.seed)
        results.append(result)
        print(
            f"{name:18} {result['inputs']:9} {result['seconds']:8} {result['slowest_ms']:11} "
            f"{result['peak_kb']:8} {len(result['findings'])}",
            flush=True,
        )
        for finding in result["findings"]:
            print(f"  {finding[:400]}")
    if options.out is not None:
        options.out.write_text(json.dumps(results, indent=1), encoding="utf-8")
    if options.results is not None:
        write_section(options.results, "## Fuzzed parsers", table(results))
    return int(any(result["findings"] for result in results))


if __name__ == "__main__":
    sys.exit(main())
