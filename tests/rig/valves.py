"""Chambers that live in the test's own process, and a pressure controller that reaches them over loopback.

Like the real boards, `Valves` has no watchdog: it holds the last set-point for ever. That makes it the witness of
whether anybody vented after a runner was killed.
"""

import contextlib
import json
import math
import socket
import socketserver
import threading
import time
from typing import Any

import numpy as np

from labrig_drivers import (
    Channel,
    Clock,
    DeviceError,
    Identity,
    PressureSample,
    VentNotConfirmedError,
    VentReport,
)

TIME_CONSTANT_S = 0.05


class Valves:
    """A server on a free loopback port: `{"set": [...]}` or `{"read": true}`, one JSON line each."""

    def __init__(self, chambers: int = 2) -> None:
        self._lock = threading.Lock()
        self._start = self._target = np.zeros(chambers)
        self._since = time.monotonic()
        self.sets = 0
        self.links: list[socket.socket] = []
        valves = self

        class Handler(socketserver.StreamRequestHandler):
            def handle(self) -> None:
                valves.links.append(self.connection)
                try:
                    for line in self.rfile:
                        self.wfile.write((json.dumps(valves.answer(json.loads(line))) + "\n").encode())
                except (OSError, ValueError):
                    return

        class Server(socketserver.ThreadingTCPServer):
            daemon_threads = True
            allow_reuse_address = True

        self._server = Server(("127.0.0.1", 0), Handler)
        self.port = self._server.server_address[1]
        self._thread = threading.Thread(target=self._server.serve_forever, args=(0.02,))
        self._thread.start()

    def answer(self, request: dict[str, Any]) -> Any:
        """Carry out one request."""
        with self._lock:
            if "set" in request:
                self._start, self._since = self._now(), time.monotonic()
                self._target = np.array(request["set"], float)
                self.sets += 1
            return self._now().tolist()

    def _now(self) -> Any:
        share = math.exp(-(time.monotonic() - self._since) / TIME_CONSTANT_S)
        return self._target + (self._start - self._target) * share

    @property
    def pressure_kpa(self) -> float:
        """The highest pressure in any chamber now."""
        with self._lock:
            return float(np.abs(self._now()).max())

    def wait_for(self, low_kpa: float, high_kpa: float, within_s: float) -> float:
        """Wait until the highest pressure is in a range; returns how long it took, or fails."""
        begin = time.monotonic()
        while not low_kpa <= self.pressure_kpa <= high_kpa:
            assert time.monotonic() - begin < within_s, (
                f"still {self.pressure_kpa:.1f} kPa after {within_s} s"
            )
            time.sleep(0.005)
        return time.monotonic() - begin

    def cut_links(self) -> None:
        """Break every connection, as if the cable was pulled."""
        for link in self.links:
            try:
                link.shutdown(socket.SHUT_RDWR)
            except OSError:
                continue
        self.links.clear()

    def close(self) -> None:
        """Stop serving."""
        self.cut_links()
        self._server.shutdown()
        self._server.server_close()
        self._thread.join()


class ValveClient:
    """The pressure controller of a rig whose chambers are `Valves`."""

    def __init__(
        self,
        name: str,
        clock: Clock,
        channels: tuple[Channel, ...],
        port: int,
        identify_s: float = 0.0,
        hangs_at: float = math.inf,
        empties_s: float = 0.0,
    ) -> None:
        self.name, self.clock, self.channels, self.port = name, clock, channels, port
        self._identify_s, self._hangs_at, self._empties_s = identify_s, hangs_at, empties_s
        self._socket: socket.socket | None = None
        self._file: Any = None
        self._last_s = 0.0

    def connect(self) -> None:
        """Open the link anew."""
        self.close()
        try:
            self._socket = socket.create_connection(("127.0.0.1", self.port), timeout=2.0)
        except OSError as error:
            raise DeviceError(f"{self.name}: port {self.port}: {error}") from None
        self._file = self._socket.makefile("rw")

    def identify(self) -> Identity:
        """Valves, after a while."""
        time.sleep(self._identify_s)
        return Identity(self.name, "valves", "valves of a test")

    def close(self) -> None:
        """Release the link."""
        if self._file is not None:
            with contextlib.suppress(OSError):
                self._file.close()
        if self._socket is not None:
            self._socket.close()
        self._socket = self._file = None

    def _ask(self, request: dict[str, Any]) -> Any:
        if self._file is None:
            raise DeviceError(f"{self.name}: not connected")
        try:
            self._file.write(json.dumps(request) + "\n")
            self._file.flush()
            line = self._file.readline()
        except OSError as error:
            raise DeviceError(f"{self.name}: the link is lost: {error}") from None
        if not line:
            raise DeviceError(f"{self.name}: the link is lost")
        return np.array(json.loads(line), float)

    def set(self, pressure_kpa: Any) -> None:
        """Command set-points; from `hangs_at` kPa on it never comes back."""
        if np.max(pressure_kpa) >= self._hangs_at:
            time.sleep(600.0)
        self._ask({"set": np.asarray(pressure_kpa).tolist()})

    def samples(self) -> list[PressureSample]:
        """One measurement, every 20 ms at most."""
        now_s = self.clock.now_s()
        if now_s - self._last_s < 0.02:
            return []
        self._last_s = now_s
        return [PressureSample(now_s, self._ask({"read": True}))]

    def vent(self, timeout_s: float = 10.0) -> VentReport:
        """Vent and confirm; not before `empties_s`, as long lines take."""
        begin_s = self.clock.now_s()
        self.set(np.zeros(len(self.channels)))
        time.sleep(self._empties_s)
        while np.abs(pressure := self._ask({"read": True})).max() > 0.5:
            if self.clock.now_s() - begin_s > timeout_s:
                raise VentNotConfirmedError(f"{self.name}: not vented after {timeout_s:g} s")
            self.clock.sleep(0.01)
        return VentReport(pressure, self.clock.now_s() - begin_s)
