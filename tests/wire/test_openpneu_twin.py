"""The OpenPneu twin, as any program sees it: exact bytes, and the firmware's quirks."""

import socket
import time

import numpy as np
import pytest

from labrig_drivers._openpneu_stream import Reply, StreamParser, Telemetry
from labrig_drivers.simulated._openpneu_board import OpenPneuBoard
from labrig_drivers.simulated._openpneu_twin import OpenPneuTwin
from labrig_drivers.simulated._wire_plant import SharedPlant


@pytest.fixture
def twin(shared, closing):
    """Starts a twin: `twin(dialect, build, **settings)`."""

    def start(dialect="published", build="full", outputs=None, **settings):
        board = OpenPneuBoard(shared, dialect, build, outputs)
        return closing(OpenPneuTwin(board, **{"boot_s": 0.0, "interleave": 0.5, **settings}).start())

    return start


class Terminal:
    """A raw connection to a twin, as any other program would make it."""

    def __init__(self, port):
        host, number = port.removeprefix("socket://").split(":")
        self.socket = socket.create_connection((host, int(number)), 5)
        self.socket.settimeout(0.05)
        self.parser = StreamParser()

    def ask(self, data, seconds=0.25):
        """Send bytes; the replies and the telemetry of the time after."""
        self.socket.sendall(data)
        events = []
        end = time.monotonic() + seconds
        while time.monotonic() < end:
            try:
                events += self.parser.feed(self.socket.recv(4096))
            except TimeoutError:
                continue
        replies = [event.text for event in events if isinstance(event, Reply)]
        return replies, [event.pressure_kpa for event in events if isinstance(event, Telemetry)]

    def stop(self):
        self.socket.close()


def test_published_dialect_is_byte_exact(twin, closing):
    """Each command of the published firmware gets the bytes of its reply, errors included."""
    terminal = closing(Terminal(twin(interleave=0.0).port))
    for line, reply in (
        (b"AT\r\n", b"OK;Successful\r\n"),
        (b"AT+ADDRESS\r\n", b"OpenPneu2.0\r\n"),
        (b"AT+VERSION\r\n", b"Version 2.0OK\r\n"),
        (b"nonsense\r\n", b"Error command\r\n"),
        (b"AT\n", b"Error end check\r\n"),
        (b"V\r\n", b"Timer Pauses...\r\nStop All Motors\r\n"),
        (b"T=5\r\nAT\r\n", b"OK;Successful\r\n"),  # T= has no reply
        (b"C\r\n", b"Timer Starts...\r\n"),
    ):
        terminal.socket.sendall(line)
        got = b""
        while len(got) < len(reply):
            got += terminal.socket.recv(len(reply) - len(got))
        assert got == reply


def test_table_dialect_is_byte_exact(twin, closing):
    """Each command of the web page's table gets the bytes of its reply."""
    terminal = closing(Terminal(twin("table").port))
    assert terminal.ask(b"AT\r\nAT+ADD\r\nPSET=1,20\r\nPSET:1,2,3,4;\r\n") == (
        ["OK", "ADD=01", "1=20.00", "OK"],
        [],
    )
    assert terminal.ask(b"PREAD=2\r\n") == (["Val=0.00"], [])
    terminal.ask(b"CON\r\n")
    replies, _ = terminal.ask(b"PREAD=2\r\n")
    assert replies == ["Val=3.00"]


def test_telemetry_streams_at_thirty_hertz_and_lands_in_replies(twin, closing):
    """While the timer runs telemetry comes unsolicited, and some of it inside replies."""
    terminal = closing(Terminal(twin(interleave=1.0).port))
    assert terminal.ask(b"C\r\n", 0.1)[0] == ["Timer Starts..."]
    terminal.socket.sendall(b"AT+ADDRESS\r\n")
    raw = b""
    while raw.count(b";\r\n") < 12:
        raw += terminal.socket.recv(4096)
    assert b"OpenPneu2.0\r\n" not in raw
    replies = [event.text for event in StreamParser().feed(raw) if isinstance(event, Reply)]
    assert "OpenPneu2.0" in replies


def test_published_quirks(twin, closing, plant):
    """A target serves its pair, only 2 and 3 are driven, odd sensors mirror the even ones, nothing is clamped."""
    terminal = closing(Terminal(twin(build="published", outputs=(0, 1, 2, 3)).port))
    _, telemetry = terminal.ask(b"SC=2\r\nT=20\r\nSC=0\r\nT=30\r\nSC=77\r\nT=9\r\nC\r\n", 0.5)
    assert telemetry[-1][:4] == pytest.approx((0.0, 0.0, 20.0, 20.0), abs=0.1)
    assert plant.commands[-1].tolist() == [0, 0, 20, 20]
    terminal.ask(b"SC=3\r\nT=500\r\n", 0.1)
    assert plant.commands[-1].tolist() == [0, 0, 180, 180]  # as far as the pumps go
    terminal.ask(b"T=abc\r\n", 0.05)
    assert terminal.ask(b"AT\r\n", 0.1)[0] == ["OK;Successful"]


def test_published_pumps_stay_on_above_the_range(twin, closing, plant):
    """Above 100 kPa the published loop no longer acts: a target of 0 changes nothing, V does."""
    terminal = closing(Terminal(twin(build="published", outputs=(0, 1, 2, 3)).port))
    _, telemetry = terminal.ask(b"SC=2\r\nT=130\r\nC\r\n", 0.5)
    assert telemetry[-1][2] > 100
    _, telemetry = terminal.ask(b"T=0\r\n", 0.5)
    assert telemetry[-1][2] > 130
    terminal.ask(b"V\r\n", 0.1)
    assert plant.commands[-1].tolist() == [0, 0, 0, 0]


def test_full_build_clamps_and_drives_each_channel(twin, closing):
    """The corrected build drives every channel on its own, inside the range."""
    terminal = closing(Terminal(twin().port))
    _, telemetry = terminal.ask(b"SC=0\r\nT=20\r\nSC=1\r\nT=500\r\nC\r\n", 0.5)
    assert telemetry[-1][:4] == pytest.approx((20.0, 100.0, 0.0, 0.0), abs=0.1)


def test_opening_resets_the_board(twin, closing, until, plant):
    """A new host finds the board reset, and deaf until it has booted."""
    running = twin(boot_s=0.3)
    first = Terminal(running.port)
    assert first.ask(b"AT\r\n", 0.1)[0] == []
    time.sleep(0.3)
    first.ask(b"SC=0\r\nT=20\r\nC\r\n", 0.1)
    first.stop()
    assert plant.commands[-1].tolist() == [20, 0, 0, 0]  # nothing watches the host
    closing(Terminal(running.port))
    until(lambda: plant.commands[-1].tolist() == [0, 0, 0, 0])


def test_shared_plant_time_never_runs_backward(small_plant_class):
    """Twins on threads of their own give the plant times that do not decrease."""

    class WildClock:
        times = iter([5.0, 4.0, 6.0])

        def now_s(self):
            return next(self.times)

        def sleep(self, duration_s):
            raise AssertionError

    plant = small_plant_class()
    seen = []
    plant.pressure_kpa = lambda time_s: seen.append(time_s) or np.zeros(4)
    shared = SharedPlant(plant, WildClock())
    for _ in range(3):
        shared.pressure_kpa()
    assert seen == [5.0, 5.0, 6.0]


def test_pyserial_talks_to_the_twin(twin):
    """pyserial's own socket handler, as other programs use it, gets the board's replies."""
    import serial

    with serial.serial_for_url(twin(interleave=0.0).port, timeout=5) as port:
        port.write(b"AT\r\n")
        assert port.readline() == b"OK;Successful\r\n"
        port.write(b"C\r\n")
        assert port.readline() == b"Timer Starts...\r\n"
        assert port.readline() == b"T" + b",".join([b"0.00"] * 10) + b";\r\n"
