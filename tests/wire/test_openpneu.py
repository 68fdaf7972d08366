"""The OpenPneu driver against its twin: both dialects, pairs, trips, and unplugging anywhere."""

import sys
import time

import numpy as np
import pytest

from labrig_drivers import Channel, DeviceError, RealClock, VentNotConfirmedError, _openpneu, build_device
from labrig_drivers.simulated._openpneu_board import OpenPneuBoard
from labrig_drivers.simulated._openpneu_twin import OpenPneuTwin

CHANNELS = tuple(Channel(name, 0.0, 60.0) for name in ("c1", "c2", "c3", "c4"))


@pytest.fixture
def twin(shared, closing):
    """Starts a twin: `twin(dialect, build, **settings)`."""

    def start(dialect="published", build="full", outputs=None, **settings):
        board = OpenPneuBoard(shared, dialect, build, outputs)
        return closing(OpenPneuTwin(board, **{"boot_s": 0.0, "interleave": 0.5, **settings}).start())

    return start


@pytest.fixture
def driver(closing):
    """Makes a driver: `driver(port, **settings)`, not connected."""

    def make(port, channels=CHANNELS, **settings):
        settings = {"port": port, "boot_s": 0.0, "build": "full", **settings}
        return closing(
            build_device("openpneu", settings, name="pressure", clock=RealClock(), channels=channels)
        )

    return make


@pytest.mark.parametrize("dialect", ["published", "table"])
def test_driver_finds_the_dialect_and_drives(twin, driver, until, dialect):
    """The dialect is found by asking; targets are reached, read back and vented in both."""
    device = driver(twin(dialect).port)
    device.connect()
    identity = device.identify()
    assert identity.details["dialect"] == dialect
    target = np.array([10.0, 20.0, 30.0, 40.0])
    device.set(target)
    until(lambda: any(np.allclose(s.pressure_kpa, target, atol=0.1) for s in device.samples()))
    report = device.vent()
    assert np.all(report.pressure_kpa < 3)
    device.set(target)


@pytest.mark.skipif(sys.platform == "win32", reason="Windows has no pseudo terminals")
def test_driver_over_a_serial_port(twin, driver, until):
    """The same through a serial device instead of a socket."""
    device = driver(twin(pty=True).port)
    device.connect()
    device.set(np.array([10.0, 0.0, 0.0, 0.0]))
    until(lambda: any(abs(s.pressure_kpa[0] - 10) < 0.1 for s in device.samples()))
    device.vent()


@pytest.mark.skipif(sys.platform == "win32", reason="Windows has no pseudo terminals")
def test_a_serial_port_that_is_pulled_out(twin, driver, until):
    """A serial port that disappears is named, and so is the vent that cannot be confirmed."""
    running = twin(pty=True)
    device = driver(running.port)
    device.connect()
    running.stop()
    with pytest.raises(DeviceError, match=rf"^pressure: lost the serial port {running.port}: "):
        until(lambda: device.samples() and False)
    with pytest.raises(VentNotConfirmedError, match=rf"cannot open the serial port {running.port}: "):
        device.vent(timeout_s=0.3)


def test_outputs_map_chambers_to_the_boards_channels(twin, driver, until, plant):
    """Chambers sit on the channels that `outputs` names."""
    device = driver(twin(outputs=(9, 4, 0, 2)).port, outputs=(9, 4, 0, 2))
    device.connect()
    device.set(np.array([1.0, 2.0, 3.0, 4.0]) * 10)
    until(lambda: any(np.allclose(s.pressure_kpa, [10, 20, 30, 40], atol=0.1) for s in device.samples()))
    assert plant.commands[-1].tolist() == [10, 20, 30, 40]


def test_published_pairs_take_one_target(twin, driver, until):
    """On the published firmware unequal targets in a pair are refused, with what to do; equal ones pass."""
    device = driver(twin(build="published").port, build="published")
    device.connect()
    with pytest.raises(DeviceError) as error:
        device.set(np.array([10.0, 10.0, 20.0, 30.0]))
    assert str(error.value) == (
        "pressure: c3 and c4 are one pair and get one target on the published firmware: set them alike, or "
        "declare `build: full` if the board's is"
    )
    device.set(np.array([0.0, 0.0, 20.0, 20.0]))
    until(lambda: any(abs(s.pressure_kpa[3] - 20) < 0.1 for s in device.samples()))


@pytest.mark.parametrize("dialect", ["auto", "table"])
def test_the_other_dialect_sets_each_channel_by_itself(twin, driver, until, dialect):
    """Once the board has answered in it no pair is refused, whatever firmware the file takes for granted."""
    device = driver(twin(dialect="table").port, dialect=dialect, build="published")
    device.connect()
    device.set(np.array([10.0, 20.0, 30.0, 40.0]))
    until(lambda: any(np.allclose(s.pressure_kpa, [10, 20, 30, 40], atol=0.1) for s in device.samples()))


def test_vent_above_the_range_on_the_published_firmware(twin, driver, until, plant):
    """Where the loop no longer acts the vent still succeeds: it stops the pumps and opens the valves."""
    running = twin(build="published")
    device = driver(running.port, build="published", over_kpa=1e6)
    device.connect()
    device.set(np.array([0.0, 0.0, 60.0, 60.0]))
    until(lambda: plant.commands[-1][2] == 60)
    running.board.target_kpa[2:4] = 150.0
    until(lambda: plant.commands[-1][2] > 140)
    assert np.all(device.vent().pressure_kpa < 3)


def test_stale_telemetry_trips(twin, driver, until):
    """A board that goes silent is stopped, and the error says so; a vent that is confirmed ends it."""
    running = twin()
    device = driver(running.port, stale_after_s=0.3)
    device.connect()
    device.set(np.array([10.0, 0.0, 0.0, 0.0]))
    running.muted = True
    with pytest.raises(DeviceError, match=r"^pressure: no pressure reading for 0\.\d s; "):
        until(lambda: device.samples() and False)
    running.muted = False
    device.vent()
    device.set(np.array([10.0, 0.0, 0.0, 0.0]))


def test_vent_that_is_not_confirmed(twin, driver, plant):
    """A stuck valve is reported by chamber and reading."""
    device = driver(twin().port)
    device.connect()
    plant.stuck_kpa = 33.0
    with pytest.raises(VentNotConfirmedError) as error:
        device.vent(timeout_s=1.5)
    assert str(error.value) == (
        "pressure: vent not confirmed within 1.5 s: c1 reads 33.0 kPa, c2 reads 33.0 kPa, c3 reads 33.0 kPa, "
        "c4 reads 33.0 kPa; relieve the pressure by hand"
    )


def test_closing_stops_the_pumps(twin, driver, until, plant):
    """A driver that closes leaves the pumps off and the valves open."""
    device = driver(twin().port)
    device.connect()
    device.set(np.array([10.0, 0.0, 0.0, 0.0]))
    until(lambda: plant.commands[-1][0] == 10)
    device.close()
    until(lambda: not plant.commands[-1].any())


def test_a_twin_that_dies_and_returns(twin, driver, until, shared):
    """After the board was unplugged calls name the device; a vent opens the port again and confirms."""
    first = twin()
    device = driver(first.port)
    device.connect()
    first.stop()
    with pytest.raises(DeviceError, match=r"^pressure: "):
        until(lambda: device.samples() and False)
    with pytest.raises(VentNotConfirmedError, match=r"refuses the connection"):
        device.vent(timeout_s=0.5)
    twin(tcp_port=int(first.port.rsplit(":", 1)[1]))
    device.vent()
    device.set(np.array([10.0, 0.0, 0.0, 0.0]))


@pytest.mark.parametrize(
    ("settings", "text"),
    [
        ({"dialect": "table"}, "speaks the published dialect, not table: correct `dialect`, or leave it out"),
    ],
)
def test_a_wrong_dialect_is_named(twin, driver, settings, text):
    """A board of the other dialect than declared is recognised."""
    port = twin().port
    with pytest.raises(DeviceError) as error:
        driver(port, **settings).connect()
    assert str(error.value) == f"pressure: the board at {port} {text}"


def test_a_flood_of_anything_is_given_up_in_time(script, driver, monkeypatch):
    """A device that never stops talking is recognised as no board; nothing of it is kept."""
    monkeypatch.setattr(_openpneu, "FIND_S", 1.5)

    def talk(connection):
        while True:
            connection.sendall(b"blah\r\n" * 10_000)

    device = driver(f"socket://127.0.0.1:{script(talk).port}")
    with pytest.raises(DeviceError, match=r"^pressure: no OpenPneu board answers AT at .*; it sends b'"):
        device.connect()
    assert len(device._wire._replies) <= 64


def test_a_port_with_something_else(script, driver, monkeypatch):
    """A device that answers something else is named with what it says."""
    monkeypatch.setattr(_openpneu, "FIND_S", 1.5)

    def talk(connection):
        connection.sendall(b"login: ")
        while connection.recv(100):
            pass

    port = f"socket://127.0.0.1:{script(talk).port}"
    with pytest.raises(DeviceError) as error:
        driver(port).connect()
    assert str(error.value) == (
        f"pressure: no OpenPneu board answers AT at {port}; it sends b'login: ' (right port, 115200 baud, "
        "power on?)"
    )


@pytest.mark.parametrize(
    ("port", "text"),
    [
        ("socket://nowhere", "'socket://nowhere' is no address: write socket://HOST:PORT"),
        ("socket://h:99999", "'socket://h:99999' is no address: write socket://HOST:PORT"),
        (
            "/dev/no-such-port",
            "cannot open the serial port /dev/no-such-port: No such file or directory",
        ),
    ],
)
def test_ports_that_cannot_be_opened(driver, port, text):
    """A port that is not there is named, with the reason."""
    if port.startswith("/dev") and sys.platform == "win32":
        pytest.skip("POSIX names of serial ports")
    with pytest.raises(DeviceError) as error:
        driver(port).connect()
    assert str(error.value) == f"pressure: {text}"


HIGH = "c1 on channel 0 may not be set from 0 to 101 kPa: the board controls -100 to 100 kPa there"
LOW = "c1 on channel 3 may not be set from -5 to 10 kPa: the board controls 0 to 100 kPa there"


@pytest.mark.parametrize(
    ("channels", "settings", "text"),
    [
        ([Channel("c1", 0, 101)], {}, HIGH),
        ([Channel("c1", -5, 10)], {"outputs": [3]}, LOW),
        (CHANNELS, {"outputs": [1, 1, 2, 3]}, "outputs [1, 1, 2, 3] are not different channels from 0 to 9"),
        (CHANNELS, {"outputs": [1, 2]}, "outputs: 2 for 4 chambers"),
        ([], {}, "the rig has no chambers"),
    ],
)
def test_what_the_board_cannot_do_is_refused_at_once(driver, channels, settings, text):
    """Limits beyond what the board controls, and channels that it does not have, are refused."""
    with pytest.raises(DeviceError) as error:
        driver("socket://127.0.0.1:1", channels, **settings)
    assert str(error.value) == f"pressure: {text}"


@pytest.mark.parametrize("dialect", ["published", "table"])
@pytest.mark.parametrize("budget", [0, 3, 11, 15, 25, 60, 150, 400, 900])
def test_unplugging_at_any_byte(script, driver, shared, dialect, budget):
    """The line is cut after `budget` bytes from the board: every call ends, in time, with the device's name."""

    def talk(connection):
        board = OpenPneuBoard(shared, dialect, "full")
        connection.settimeout(0.01)
        left = budget if server.accepted == 1 else 0
        while True:
            try:
                data = connection.recv(4096)
                if not data:
                    return
            except TimeoutError:
                data = b""
            said = b"".join(board.feed(data))
            if board.running and dialect == "published":
                said += board.telemetry()
            connection.sendall(said[:left])
            left -= len(said)
            if left <= 0:
                return

    def use():
        device.connect()
        device.identify()
        for _ in range(200):
            device.set(np.array([5.0, 5.0, 5.0, 5.0]))
            device.set(np.zeros(4))

    server = script(talk)
    device = driver(f"socket://127.0.0.1:{server.port}")
    began = time.monotonic()
    with pytest.raises(DeviceError, match=r"^pressure: "):
        use()
    with pytest.raises(VentNotConfirmedError, match=r"^pressure: vent not confirmed"):
        device.vent(timeout_s=0.2)
    assert time.monotonic() - began < 60


def test_a_board_of_few_words(script, driver, until):
    """A board that answers AT and SC only, in words of its own, can be used; what it does not say is not stated."""

    def talk(connection):
        running, held = False, b""
        connection.settimeout(0.02)
        while True:
            try:
                data = connection.recv(100)
                if not data:
                    return
                held += data
            except TimeoutError:
                if running:
                    connection.sendall(b"T" + b",".join([b"1.50"] * 10) + b";\r\n")
            while b"\r\n" in held:
                line, held = held.split(b"\r\n", 1)
                said.append(line)
                running = running or line == b"C"
                if line == b"AT":
                    connection.sendall(b"OK;Successful\r\n")
                elif line.startswith(b"SC="):
                    connection.sendall(b"now " + line[3:] + b"\r\n")

    said = []
    device = driver(f"socket://127.0.0.1:{script(talk).port}")
    device.connect()
    assert said == [
        b"AT", b"SC=0", b"T=0.00", b"SC=1", b"T=0.00", b"SC=2", b"T=0.00", b"SC=3", b"T=0.00", b"AT",
        b"C",
    ]  # fmt: skip
    assert device.identify().details["version"] == "not stated"
    until(device.samples)
    del said[:]
    device.set(np.array([0.0, 12.345, 0.0, 0.0]))
    until(lambda: said in ([b"SC=1", b"T=12.35", b"AT"], [b"SC=1", b"T=12.34", b"AT"]))
    assert device.vent().pressure_kpa.tolist() == [1.5] * 4
    device.close()
    until(lambda: said[-1] == b"V")


def test_an_error_is_an_answer_whatever_signs_it_has(script, driver):
    """What a board refuses, with an apostrophe in its words, is told with them, and is not waited for as if it were
    late.
    """

    def talk(connection):
        held = b""
        while data := connection.recv(100):
            held += data
            while b"\r\n" in held:
                line, held = held.split(b"\r\n", 1)
                connection.sendall(b"OK\r\n" if line == b"AT" else b"Error: can't\r\n")

    device = driver(f"socket://127.0.0.1:{script(talk).port}")
    with pytest.raises(DeviceError, match=r"\"Error: can't\" to "):
        device.connect()
    assert not device._wire._late
