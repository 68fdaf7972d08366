"""A DataStream server over the plant: what Vicon's software sends, at 100-400 Hz, to any client."""

import contextlib
import selectors
import socket
import struct
import time
from collections import deque
from dataclasses import dataclass, field

import numpy as np
from numpy.typing import NDArray

from labrig_drivers._cgstream import (
    STATIC_OBJECTS,
    CgObject,
    CgstreamError,
    PacketReader,
    block,
    blocks,
    packet,
)
from labrig_drivers._cgstream_objects import decode_ping, decode_set
from labrig_drivers.simulated._threaded import Threaded
from labrig_drivers.simulated._vicon_encode import LATENCIES_S, Scene, contents, vector
from labrig_drivers.simulated._wire_plant import SharedPlant

LATENCY_S = sum(LATENCIES_S.values())
MAX_CLIENTS = 16
MAX_REQUEST_BYTES = 1 << 16
MAX_UNSENT_BYTES = 4 << 20
MAX_LATE_FRAMES = 100


@dataclass
class TwinClient:
    """One connection, as the server sees it."""

    connection: socket.socket
    reader: PacketReader = field(default_factory=lambda: PacketReader(MAX_REQUEST_BYTES))
    unsent: bytearray = field(default_factory=bytearray)
    enabled: frozenset[int] = frozenset()
    streaming: bool = False
    requests: int = 0
    statics_sent: bool = False
    pings: list[int] = field(default_factory=list)


class ViconServer(Threaded):
    """Streams the markers of a plant; `start` binds, `stop` ends it and its connections.

    Occluded markers are left out of the frame. A client that does not read loses whole frames, never
    parts of one. `port` 0 takes a free port; the one in use is `port` after `start`.
    """

    def __init__(
        self,
        plant: SharedPlant,
        *,
        subject: str = "mannequin",
        rate_hz: float = 100.0,
        up: str = "z",
        host: str = "127.0.0.1",
        port: int = 0,
        ghosts_mm: NDArray[np.float64] | None = None,
    ) -> None:
        self.host, self.port = host, port
        self.frames_sent = 0
        self.frames_skipped = 0
        self._plant = plant
        self._ghosts_mm = ghosts_mm
        self._scene = Scene(subject, plant.marker_names, rate_hz, y_up=up == "y")
        self._statics = self._scene.static_blocks()
        rest_mm = np.asarray(plant.plant.rest_mm, float)
        self._rest_mm = rest_mm
        self._supported = frozenset(
            {*self._statics, *self._scene.frame_blocks(0, rest_mm, 0.0), CgObject.CONTENTS, CgObject.PING}
        )
        self._number = 0
        self._clients: list[TwinClient] = []
        self._due: deque[tuple[float, dict[int, bytes]]] = deque()
        super().__init__()

    def start(self) -> "ViconServer":
        """Listen and stream from a thread."""
        listener = socket.create_server((self.host, self.port))
        listener.setblocking(False)
        self.port = listener.getsockname()[1]
        self._begin("vicon-twin", self._serve, listener)
        return self

    def _serve(self, listener: socket.socket) -> None:
        began = time.perf_counter()
        sent = 0
        with selectors.DefaultSelector() as selector:
            selector.register(listener, selectors.EVENT_READ)
            try:
                while not self._stopping.is_set():
                    due = began + (sent + 1) / self._scene.rate_hz
                    first = min(due, self._due[0][0]) if self._due else due
                    wait_s = min(0.1, max(0.0, first - time.perf_counter()))
                    for key, _ in selector.select(wait_s):
                        if key.data is None:
                            self._accept(listener, selector)
                        else:
                            self._read(key.data, selector)
                    now = time.perf_counter()
                    if now - due > MAX_LATE_FRAMES / self._scene.rate_hz:
                        skipped = int((now - due) * self._scene.rate_hz)
                        self.frames_skipped += skipped
                        self._number += skipped
                        sent += skipped
                    elif now >= due:
                        self._expose(now)
                        sent += 1
                    while self._due and self._due[0][0] <= now:
                        self._deliver(self._due.popleft()[1])
                    self._flush(selector)
            finally:
                for client in list(self._clients):
                    self._drop(client, selector)
                listener.close()
                self._due.clear()

    def _accept(self, listener: socket.socket, selector: selectors.BaseSelector) -> None:
        with contextlib.suppress(OSError):
            connection, _ = listener.accept()
            if len(self._clients) >= MAX_CLIENTS:
                connection.close()
                return
            connection.setblocking(False)
            connection.setsockopt(socket.IPPROTO_TCP, socket.TCP_NODELAY, 1)
            client = TwinClient(connection)
            numbers = (struct.pack("<I", number) for number in sorted(self._supported))
            client.unsent += packet([block(CgObject.OBJECT_ENUMS, vector(numbers))])
            self._clients.append(client)
            selector.register(connection, selectors.EVENT_READ, client)

    def _drop(self, client: TwinClient, selector: selectors.BaseSelector) -> None:
        if client in self._clients:
            self._clients.remove(client)
            selector.unregister(client.connection)
            client.connection.close()

    def _read(self, client: TwinClient, selector: selectors.BaseSelector) -> None:
        try:
            data = client.connection.recv(1 << 16)
            if not data:
                self._drop(client, selector)
                return
            self.take(client, data)
        except BlockingIOError:
            return
        except (OSError, CgstreamError):
            self._drop(client, selector)

    def take(self, client: TwinClient, data: bytes) -> None:
        """Act on what a client sent; `CgstreamError` when it makes no sense."""
        for body in client.reader.feed(data):
            for number, payload in blocks(body):
                self._handle(client, number, payload)

    def _handle(self, client: TwinClient, number: int, payload: bytes) -> None:
        if number == CgObject.OBJECT_ENUMS:
            enabled = decode_set(payload, "ObjectEnums") & self._supported
            if enabled != client.enabled:
                client.enabled, client.statics_sent = enabled, False
        elif number == CgObject.REQUEST_FRAME:
            client.streaming = payload[:1] == b"\x01"
            client.requests = min(client.requests + (not client.streaming), 1)
        elif number == CgObject.REQUEST_NEXT_FRAME:
            client.requests = min(client.requests + 1, 2)
        elif number == CgObject.PING and len(client.pings) < 64:
            client.pings.append(decode_ping(payload))

    def _expose(self, now: float) -> None:
        number = self._number
        self._number += 1
        if not any(client.streaming or client.requests for client in self._clients):
            return
        position_mm, _ = self._plant.observe()
        made = self._scene.frame_blocks(
            number, position_mm, self._plant.clock.now_s(), self._ghosts_mm, self._rest_mm
        )
        self._due.append((now + LATENCY_S, made))

    def _deliver(self, made: dict[int, bytes]) -> None:
        for client in self._clients:
            if not (client.streaming or client.requests):
                continue
            if len(client.unsent) > MAX_UNSENT_BYTES:
                self.frames_skipped += 1
                continue
            client.requests = max(0, client.requests - 1)
            client.unsent += self._packet(client, made)
            self.frames_sent += 1

    def _packet(self, client: TwinClient, made: dict[int, bytes]) -> bytes:
        sent: dict[int, bytes] = {}
        if not client.statics_sent:
            sent.update(self._statics)
        sent.update(made)
        sent = {number: data for number, data in sent.items() if number in client.enabled}
        unchanged = (STATIC_OBJECTS & client.enabled) if client.statics_sent else frozenset()
        client.statics_sent = True
        counts = dict.fromkeys(sent, 1)
        pings = [block(CgObject.PING, struct.pack("<Q", number)) for number in client.pings]
        client.pings.clear()
        if pings:
            counts[CgObject.PING] = len(pings)
        head = (
            [block(CgObject.CONTENTS, contents(counts, unchanged))]
            if CgObject.CONTENTS in client.enabled
            else []
        )
        return packet([*head, *sent.values(), *pings])

    def _flush(self, selector: selectors.BaseSelector) -> None:
        for client in list(self._clients):
            if client.pings and not (client.streaming or client.requests):
                pings = [block(CgObject.PING, struct.pack("<Q", number)) for number in client.pings]
                client.pings.clear()
                client.unsent += packet(pings)
            if not client.unsent:
                continue
            try:
                done = client.connection.send(client.unsent)
                del client.unsent[:done]
            except BlockingIOError:
                continue
            except OSError:
                self._drop(client, selector)
