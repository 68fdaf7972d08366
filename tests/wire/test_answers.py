"""Pressure controllers that refuse a command, or whose answer comes late and does not say to what."""

import os
import select
import struct
import sys
import threading
import time

import numpy as np
import pytest
from pymodbus.framer import FramerRTU

from labrig_drivers import Channel, DeviceError, RealClock, VentNotConfirmedError, _modbus, build_device
from labrig_drivers.simulated._openpneu_board import OpenPneuBoard


@pytest.fixture
def driver(closing):
    """Makes a driver with a number of chambers, not connected: `driver(kind, count, **settings)`."""

    def make(kind, count, **settings):
        channels = [Channel(f"c{number}", 0.0, 40.0) for number in range(count)]
        device = build_device(kind, settings, name="pressure", clock=RealClock(), channels=channels)
        return closing(device)

    return make


@pytest.fixture
def board_that(script, driver, shared):
    """A published board that answers a line as `answer(line)` says, or else as it should: (board, lines, driver)."""

    def start(answer):
        board, lines = OpenPneuBoard(shared, "published", "full"), []

        def talk(connection):
            connection.settimeout(0.02)
            held = b""
            while True:
                try:
                    data = connection.recv(4096)
                    if not data:
                        return
                    held += data
                except TimeoutError:
                    if board.running:
                        board.control(0.02)
                        connection.sendall(board.telemetry())
                *whole, held = held.split(b"\r\n")
                for line in whole:
                    lines.append(line.decode())
                    connection.sendall(answer(lines[-1]) or b"".join(board.feed(line + b"\r\n")))

        device = driver(
            "openpneu", 4, port=f"socket://127.0.0.1:{script(talk).port}", boot_s=0.0, build="full"
        )
        device.connect()
        return board, lines, device

    return start


@pytest.mark.parametrize(
    ("line", "words"),
    [("T=20.00", b"Error command\r\n"), ("SC=1", b"Stop All Motors\r\nError command\r\n")],
    ids=["target", "selection, behind a late answer"],
)
def test_a_refused_target_is_sent_again(board_that, until, line, words):
    """One disturbed line, the target or its selection, leaves every channel with its own target."""
    once = []

    def answer(said):
        if said == line and once:
            return once.pop()
        return b""

    board, _, device = board_that(answer)
    device.set(np.array([5.0, 0.0, 0.0, 0.0]))
    once.append(words)
    device.set(np.array([20.0, 10.0, 5.0, 0.0]))
    until(lambda: board.target_kpa[:4].tolist() == [20.0, 10.0, 5.0, 0.0])
    assert not once


def test_a_target_that_is_always_refused_is_an_error(board_that):
    """A board that does not take a target is named with its answer; the next call sends everything again."""
    refuses = [True]
    board, _, device = board_that(
        lambda said: b"Error command\r\n" if said == "T=20.00" and refuses[0] else b""
    )
    with pytest.raises(DeviceError, match=r"^pressure: the board at \S+: 'Error command' to set-points$"):
        device.set(np.array([20.0, 10.0, 0.0, 0.0]))
    refuses[0] = False
    device.vent()
    device.set(np.array([20.0, 10.0, 0.0, 0.0]))
    assert board.target_kpa[:4].tolist() == [20.0, 10.0, 0.0, 0.0]


def test_a_board_that_refuses_zero_does_not_run_again_after_a_stop(board_that, until):
    """While the old target is in the board its pumps stay off, and the vent is not confirmed although all read 0."""
    refuses = []
    board, lines, device = board_that(
        lambda said: b"Error command\r\n" if said == "T=0.00" and refuses else b""
    )
    device.set(np.array([30.0, 0.0, 0.0, 0.0]))
    until(device.samples)
    refuses.append(True)
    del lines[:]
    with pytest.raises(
        VentNotConfirmedError, match=r": 'Error command' to set-points; relieve the pressure by hand$"
    ):
        device.vent(timeout_s=0.5)
    assert "V" in lines
    assert "C" not in lines
    refuses.clear()
    device.vent()
    assert not board.target_kpa.any()


@pytest.mark.parametrize("late_s", [0.7, 1.2])
def test_a_late_reading_is_not_taken_for_another_channels(script, driver, until, late_s):
    """One answer of the table that comes late costs a round; every reading stays with its own chamber."""
    wait_s = []

    def talk(connection):
        held = b""
        while data := connection.recv(4096):
            *lines, held = (held + data).split(b"\r\n")
            for line in lines:
                name, _, value = line.decode().partition("=")
                if name == "PREAD" and wait_s:
                    time.sleep(wait_s.pop())
                time.sleep(0.008)
                words = {"AT+ADD": "ADD=01", "PSET": value.replace(",", "="), "PREAD": f"Val={value}.00"}
                connection.sendall(words.get(name, "OK").encode() + b"\r\n")

    port = f"socket://127.0.0.1:{script(talk).port}"
    device = driver("openpneu", 9, port=port, boot_s=0.0, build="full", stale_after_s=5.0)
    device.connect()
    until(device.samples)
    wait_s.append(late_s)
    read = []
    until(lambda: not wait_s and (read.extend(device.samples()) or len(read) > 20))
    assert [sample.pressure_kpa.tolist() for sample in read] == [list(range(9))] * len(read)


class SlowRegulator:
    """An RTU device on a pseudo terminal that answers in turn, and one request when `late_s` is over."""

    def __init__(self, registers):
        import pty
        import tty

        self._ours, self._theirs = pty.openpty()
        tty.setraw(self._theirs)
        self.port = os.ttyname(self._theirs)
        self.late_s = []
        self._registers = registers
        self._stopping = threading.Event()
        self._thread = threading.Thread(target=self._run)
        self._thread.start()

    def _run(self):
        held = b""
        while not self._stopping.is_set():
            if not select.select([self._ours], [], [], 0.05)[0]:
                continue
            held += os.read(self._ours, 4096)
            while len(held) >= 8:
                request, held = held[:8], held[8:]
                time.sleep(self.late_s.pop() if self.late_s and request[1] == 4 else 0.02)
                os.write(self._ours, self._answer(request))

    def _answer(self, request):
        if request[1] == 6:
            return request
        address, count = struct.unpack(">HH", request[2:6])
        values = [self._registers.get(address + index, 0) for index in range(count)]
        body = request[:2] + bytes([2 * count]) + struct.pack(f">{count}H", *values)
        return body + FramerRTU.compute_CRC(body).to_bytes(2, "big")

    def stop(self):
        self._stopping.set()
        self._thread.join()
        os.close(self._ours)
        os.close(self._theirs)


@pytest.mark.skipif(sys.platform == "win32", reason="Windows has no pseudo terminals")
def test_a_late_answer_over_rtu_is_not_taken_for_another_registers(driver, closing, until, monkeypatch):
    """An answer over RTU does not name its register: one that comes late is neither a fault nor a pressure."""
    monkeypatch.setattr(_modbus, "FAULTS_EVERY_S", 0.0)
    regulator = closing(SlowRegulator({271: 200}))
    settings = {"serial": regulator.port, "map": "festo-pgva.yaml", "timeout_s": 0.3, "stale_after_s": 5.0}
    device = driver("modbus", 1, **settings)
    device.connect()
    until(device.samples)
    for _ in range(3):
        regulator.late_s.append(0.4)
        until(lambda: not regulator.late_s)
        read = []
        until(lambda read=read: read.extend(device.samples()) or len(read) > 4)
        assert {float(sample.pressure_kpa[0]) for sample in read} == {20.0}
