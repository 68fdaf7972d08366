"""A recorded session that answers again: the device's bytes, in the order and at the pace of the recording."""

import contextlib
import itertools
import select
import socket
import threading
import time
from pathlib import Path

from labrig_drivers._recording import Piece, read_header, read_pieces
from labrig_drivers.simulated._threaded import Threaded

PATIENCE_S = 2.0
MAX_HELD_BYTES = 1 << 20


class ReplayTwin(Threaded):
    """Serves one recording on a TCP port, from its beginning for each connection, one at a time.

    What the device said is sent once the client has sent as many bytes as the host had by then, or after
    `patience_s`. `differing` counts the pieces in which the client said something else than the host did,
    `missing` those that it did not say. `speed` 2 plays twice as fast.
    """

    def __init__(
        self,
        recording: Path,
        *,
        host: str = "127.0.0.1",
        port: int = 0,
        speed: float = 1.0,
        patience_s: float = PATIENCE_S,
    ) -> None:
        self.kind = read_header(recording)["kind"]
        self.host, self.port = host, port
        self.differing = 0
        self.missing = 0
        self._recording = recording
        self._speed = speed
        self._patience_s = patience_s
        super().__init__()

    def start(self) -> "ReplayTwin":
        """Listen and answer from a thread."""
        listener = socket.create_server((self.host, self.port))
        listener.settimeout(0.05)
        self.port = listener.getsockname()[1]
        self._begin("replay", self._serve, listener)
        return self

    def _serve(self, listener: socket.socket) -> None:
        with listener:
            while not self._stopping.is_set():
                try:
                    connection, _ = listener.accept()
                except TimeoutError:
                    continue
                with connection, contextlib.suppress(OSError):
                    connection.settimeout(self._patience_s)
                    self._play(_Conversation(connection, self._stopping))

    def _play(self, client: "_Conversation") -> None:
        pieces = read_pieces(self._recording)
        first = next(pieces, None)
        if first is None:
            return
        began, before_s = time.monotonic(), first.time_s
        for piece in itertools.chain([first], pieces):
            if piece.sent:
                self._expect(client, piece)
                began, before_s = time.monotonic(), piece.time_s
            else:
                due = began + (piece.time_s - before_s) / self._speed
                client.collect_until(due)
                client.send(piece.data)
            if self._stopping.is_set():
                return

    def _expect(self, client: "_Conversation", piece: Piece) -> None:
        said = client.take(len(piece.data), self._patience_s)
        if said is None:
            self.missing += 1
        elif said != piece.data:
            self.differing += 1


class _Conversation:
    """One connection; what the client says is held until it is asked for."""

    def __init__(self, connection: socket.socket, stopping: threading.Event) -> None:
        self._connection = connection
        self._stopping = stopping
        self._held = bytearray()

    def send(self, data: bytes) -> None:
        self._connection.sendall(data)

    def collect_until(self, deadline: float) -> None:
        while not self._stopping.is_set():
            left_s = deadline - time.monotonic()
            self._receive(max(0.0, min(left_s, 0.05)))
            if left_s <= 0:
                return

    def take(self, count: int, patience_s: float) -> bytes | None:
        deadline = time.monotonic() + patience_s
        while len(self._held) < count:
            if time.monotonic() > deadline or self._stopping.is_set():
                return None
            self._receive(0.02)
        said = bytes(self._held[:count])
        del self._held[:count]
        return said

    def _receive(self, timeout_s: float) -> None:
        readable, _, _ = select.select([self._connection], [], [], timeout_s)
        if not readable:
            return
        data = self._connection.recv(65536)
        if not data:
            raise ConnectionResetError
        self._held += data
        if len(self._held) > MAX_HELD_BYTES:
            del self._held[:-MAX_HELD_BYTES]
