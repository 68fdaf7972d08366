"""The OpenPneu board on a TCP port, or on a pseudo terminal where the system has them."""

import contextlib
import os
import random
import select
import socket
import sys
import time

from labrig_drivers.simulated._openpneu_board import OpenPneuBoard
from labrig_drivers.simulated._threaded import Threaded

TICK_S = 0.01
MAX_UNSENT_BYTES = 1 << 20


class OpenPneuTwin(Threaded):
    """Serves a board to one host at a time, as a serial port does; opening it resets the board.

    With `pty` (POSIX only) `port` is a device path after `start`, otherwise ``socket://HOST:PORT``.
    What arrives in the `boot_s` after opening is lost. A part `interleave` of the replies has a line of
    telemetry inside while the timer runs.
    """

    def __init__(
        self,
        board: OpenPneuBoard,
        *,
        host: str = "127.0.0.1",
        tcp_port: int = 0,
        pty: bool = False,
        boot_s: float = 1.0,
        telemetry_hz: float = 30.0,
        interleave: float = 0.2,
        seed: int = 0,
    ) -> None:
        if pty and sys.platform == "win32":
            raise ValueError("Windows has no pseudo terminals: use a TCP port")
        self.board = board
        self.port = ""
        self.muted = False  # for tests: the board runs on but says nothing
        self._host, self._tcp_port, self._pty = host, tcp_port, pty
        self._boot_s, self._telemetry_hz, self._interleave = boot_s, telemetry_hz, interleave
        self._chance = random.Random(seed)
        super().__init__()
        self._stepped_at = time.monotonic()

    def start(self) -> "OpenPneuTwin":
        """Serve from a thread."""
        if self._pty:
            import pty
            import tty

            ours, theirs = pty.openpty()
            tty.setraw(theirs)
            self.port = os.ttyname(theirs)
            os.set_blocking(ours, False)
            target, arguments = self._serve_pty, (ours, theirs)
        else:
            listener = socket.create_server((self._host, self._tcp_port))
            listener.settimeout(0.05)
            self._tcp_port = listener.getsockname()[1]
            self.port = f"socket://{self._host}:{self._tcp_port}"
            target, arguments = self._serve_tcp, (listener,)
        self._begin("openpneu-twin", target, *arguments)
        return self

    def _serve_tcp(self, listener: socket.socket) -> None:
        with listener:
            while not self._stopping.is_set():
                try:
                    connection, _ = listener.accept()
                except TimeoutError:
                    self._step()
                    continue
                except OSError:
                    return
                connection.setblocking(False)
                connection.setsockopt(socket.IPPROTO_TCP, socket.TCP_NODELAY, 1)
                with connection, contextlib.suppress(ConnectionError):
                    self._session(connection.fileno(), lambda c=connection: c.recv(4096), connection.send)

    def _serve_pty(self, ours: int, theirs: int) -> None:
        # The terminal stays open at this end too, so that a host that goes is no error; each host that
        # wants a reset asks for it by opening, which a pseudo terminal does not tell: it resets once.
        try:
            self._session(ours, lambda: os.read(ours, 4096), lambda data: os.write(ours, data))
        finally:
            os.close(ours)
            os.close(theirs)

    def _step(self) -> None:
        now = time.monotonic()
        self.board.control(min(0.1, now - self._stepped_at))
        self._stepped_at = now

    def _session(self, handle: int, read, write) -> None:
        self.board.reset()
        opened = time.monotonic()
        printed = opened
        unsent = bytearray()
        while not self._stopping.is_set():
            readable, _, _ = select.select([handle], [], [], TICK_S)
            if readable:
                data = read()
                if not data:
                    return
                if time.monotonic() - opened >= self._boot_s:
                    for reply in self.board.feed(data):
                        unsent += self._mixed(reply)
            self._step()
            now = time.monotonic()
            if self.board.running and self.board.dialect == "published":
                if now - printed >= 1.0 / self._telemetry_hz:
                    printed = max(printed + 1.0 / self._telemetry_hz, now - 0.1)
                    unsent += self.board.telemetry()
            else:
                printed = now
            if self.muted or len(unsent) > MAX_UNSENT_BYTES:
                unsent.clear()
            if unsent:
                with contextlib.suppress(BlockingIOError):
                    del unsent[: write(bytes(unsent))]

    def _mixed(self, reply: bytes) -> bytes:
        streaming = self.board.running and self.board.dialect == "published"
        if not streaming or self._chance.random() >= self._interleave:
            return reply
        cut = self._chance.randrange(1, len(reply))
        return reply[:cut] + self.board.telemetry() + reply[cut:]
