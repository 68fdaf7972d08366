"""Modbus regulators: the driver against a real pymodbus server with the registers of a map."""

import os
import select
import sys
import threading

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from labrig_drivers import Channel, DeviceError, RealClock, VentNotConfirmedError, build_device
from labrig_drivers._modbus import from_counts, signed, spans, to_counts
from labrig_drivers._modbus_map import MAPS, RegisterMapError, load_map
from labrig_drivers._wired_pressure import WireError
from labrig_drivers.simulated._modbus_twin import ModbusTwin
from labrig_drivers.simulated._wire_plant import SharedPlant

CHANNELS = tuple(Channel(name, 0.0, 60.0) for name in ("c1", "c2", "c3", "c4"))


@pytest.fixture
def twin(shared, closing):
    """Starts a twin of a map: `twin(name, **settings)`."""
    return lambda name="festo-vtem.yaml", **more: closing(ModbusTwin(shared, load_map(name), **more).start())


@pytest.fixture
def driver(closing):
    """Makes a driver: `driver(port, **settings)`, not connected."""

    def make(port, channels=CHANNELS, **settings):
        settings = {"host": "127.0.0.1", "port": port, "map": "festo-vtem.yaml", **settings}
        return closing(
            build_device("modbus", settings, name="pressure", clock=RealClock(), channels=channels)
        )

    return make


@pytest.fixture
def registers(closing):
    """A plain pymodbus client on a port, as any other program would use it."""
    from pymodbus.client import ModbusTcpClient

    def connect(port):
        client = ModbusTcpClient("127.0.0.1", port=port, timeout=2, retries=0)
        assert client.connect()
        return closing(client)

    return connect


def test_vtem_drives_reads_and_vents(twin, driver, until, plant):
    """The slots that are used are started; targets are reached, read back and vented."""
    device = driver(twin().port)
    device.connect()
    target = np.array([10.0, 20.0, 30.0, 40.0])
    device.set(target)
    until(lambda: any(np.allclose(s.pressure_kpa, target, atol=0.15) for s in device.samples()))
    assert plant.commands[-1].tolist() == [10, 20, 30, 40]
    assert np.all(np.abs(device.vent().pressure_kpa) < 3)


def test_vtem_registers(twin, driver, registers, plant):
    """On the wire: app 3 in the slots' command registers, mbar in the set-points, state 2 in the status."""
    running = twin()
    device = driver(running.port)
    device.connect()
    device.set(np.array([10.0, 20.0, 30.0, 40.0]))
    other = registers(running.port)
    written = other.read_holding_registers(40003, count=6, device_id=1).registers
    assert written == [3, 100, 200, 3, 300, 400]
    assert other.read_holding_registers(45395, count=1, device_id=1).registers == [0x83]
    assert other.read_holding_registers(45401, count=1, device_id=1).registers == [61]  # slot 2: not used
    device.close()
    assert other.read_holding_registers(40003, count=6, device_id=1).registers == [3, 0, 0, 3, 0, 0]
    assert not plant.commands[-1].any()


def test_pgva_registers(small_plant_class, closing, driver, registers, until):
    """PGVA: the pump is switched on, the set-point is int16 mbar in 4112, the output is read from 271."""
    plant = small_plant_class(chambers=("c1",))
    twin = closing(ModbusTwin(SharedPlant(plant, RealClock()), load_map("festo-pgva.yaml")).start())
    device = driver(twin.port, [Channel("c1", -40, 40)], map="festo-pgva.yaml")
    device.connect()
    device.set(np.array([-25.0]))
    other = registers(twin.port)
    assert other.read_holding_registers(4112, count=1, device_id=1).registers == [65536 - 250]
    assert other.read_holding_registers(4120, count=1, device_id=1).registers == [1]
    until(lambda: other.read_input_registers(271, count=1, device_id=1).registers == [65536 - 250])
    until(lambda: any(abs(s.pressure_kpa[0] + 25) < 0.15 for s in device.samples()))
    assert set(device.identify().details) >= {"status", "warning", "error", "vacuum_mbar"}


def test_a_fault_register_is_reported(small_plant_class, closing, driver, until):
    """A regulator that reports an error is named with the number; what it holds is let go."""
    plant = small_plant_class(chambers=("c1",))
    twin = closing(ModbusTwin(SharedPlant(plant, RealClock()), load_map("festo-pgva.yaml")).start())
    device = driver(twin.port, [Channel("c1", 0, 40)], map="festo-pgva.yaml")
    device.connect()
    device.set(np.array([20.0]))
    twin.faults["error"] = 7
    with pytest.raises(DeviceError) as error:
        until(lambda: device.samples() and False)
    assert str(error.value) == (
        f"pressure: Festo PGVA-1 at 127.0.0.1:{twin.port} reports error 7 (register 282; its manual says "
        "what that is)"
    )
    assert not plant.commands[-1].any()


def test_server_death_and_return(twin, driver, until):
    """A server that dies is an error that names the device; when it is back a vent reconnects."""
    first = twin()
    device = driver(first.port)
    device.connect()
    device.set(np.array([10.0, 0.0, 0.0, 0.0]))
    first.stop()
    with pytest.raises(DeviceError, match=r"^pressure: "):
        until(lambda: device.samples() and False)
    with pytest.raises(VentNotConfirmedError, match=r"no Modbus device answers"):
        device.vent(timeout_s=0.5)
    twin(port=first.port)
    device.vent()
    device.set(np.array([10.0, 0.0, 0.0, 0.0]))


def test_wrong_unit_or_map_is_refused_by_the_device(twin, driver):
    """An address that the device does not have comes back as an error that names it."""
    running = twin("festo-pgva.yaml", outputs=(0, 0, 0, 0))
    with pytest.raises(DeviceError) as error:
        driver(running.port).connect()
    assert str(error.value) == (
        f"pressure: 127.0.0.1:{running.port} refuses writing holding register 40004 (Modbus exception 2): is "
        "this the right map and unit? (Festo VTEM through CPX, unit 1)"
    )


def test_a_silent_device(script, driver):
    """A server that accepts and never answers is given up in bounded time."""
    server = script(lambda connection: all(connection.recv(100) for _ in range(100)))
    with pytest.raises(DeviceError, match=r"^pressure: lost the Modbus device at 127\.0\.0\.1:\d+: "):
        driver(server.port, timeout_s=0.2).connect()


@pytest.mark.parametrize(
    "answer", [b"", b"\0", b"HTTP/1.1 400 Bad Request\r\n\r\n", b"\xff" * 300, bytes(50)]
)
def test_an_answer_that_is_nonsense(script, driver, answer):
    """Whatever a server of another kind answers, the error names the device."""

    def talk(connection):
        connection.recv(1000)
        connection.sendall(answer)

    with pytest.raises(DeviceError, match=r"^pressure: .*127\.0\.0\.1:\d+"):
        driver(script(talk).port, timeout_s=0.2).connect()


def test_unplugging_at_any_byte(twin, script, driver):
    """The line is cut after any number of bytes: connect, set and vent end in time, naming the device."""
    import socket

    running = twin()

    def talk(connection):
        left = budget[0]
        with socket.create_connection(("127.0.0.1", running.port), 5) as upstream:
            while left > 0:
                ready, _, _ = select.select([connection, upstream], [], [], 5)
                if connection in ready:
                    data = connection.recv(4096)
                    if not data:
                        return
                    upstream.sendall(data)
                if upstream in ready:
                    data = upstream.recv(4096)[:left]
                    connection.sendall(data)
                    left -= len(data)
                if not ready:
                    return
        budget[0] = 0

    def use(device):
        device.connect()
        for _ in range(200):
            device.set(np.array([5.0, 5.0, 5.0, 5.0]))
            device.set(np.zeros(4))

    for first in (0, 1, 6, 11, 12, 13, 40, 47, 55, 200, 500):
        budget = [first]
        device = driver(script(talk).port, timeout_s=0.1)
        with pytest.raises(DeviceError, match=r"^pressure: "):
            use(device)
        with pytest.raises(VentNotConfirmedError, match=r"^pressure: vent not confirmed"):
            device.vent(timeout_s=0.2)


@pytest.mark.skipif(sys.platform == "win32", reason="Windows has no pseudo terminals")
def test_rtu_over_a_serial_line(small_plant_class, closing, until):
    """The same registers over RTU on a serial line (two pseudo terminals, joined)."""
    line = closing(SerialLine())
    plant = small_plant_class(chambers=("c1",))
    closing(
        ModbusTwin(SharedPlant(plant, RealClock()), load_map("festo-pgva.yaml"), serial=line.ends[0]).start()
    )
    options = {"serial": line.ends[1], "map": "festo-pgva.yaml"}
    device = closing(
        build_device("modbus", options, name="pressure", clock=RealClock(), channels=[Channel("c1", 0, 40)])
    )
    device.connect()
    device.set(np.array([20.0]))
    until(lambda: any(abs(s.pressure_kpa[0] - 20) < 0.15 for s in device.samples()))
    device.vent()


class SerialLine:
    """Two pseudo terminals; what goes into one comes out of the other."""

    def __init__(self):
        import pty
        import tty

        pairs = [pty.openpty(), pty.openpty()]
        for _, theirs in pairs:
            tty.setraw(theirs)
        self._handles = [handle for pair in pairs for handle in pair]
        self.ends = [os.ttyname(theirs) for _, theirs in pairs]
        self._ours = [ours for ours, _ in pairs]
        self._stopping = threading.Event()
        self._thread = threading.Thread(target=self._run)
        self._thread.start()

    def _run(self):
        while not self._stopping.is_set():
            ready, _, _ = select.select(self._ours, [], [], 0.05)
            for handle in ready:
                other = self._ours[1 - self._ours.index(handle)]
                os.write(other, os.read(handle, 4096))

    def stop(self):
        self._stopping.set()
        self._thread.join()
        for handle in self._handles:
            os.close(handle)


@given(st.floats(-3276.8, 3276.7))
def test_counts_are_int16(value_kpa):
    """Every pressure in range survives the register, negative ones in two's complement."""
    register = to_counts(value_kpa, 0.1)
    assert 0 <= register <= 0xFFFF
    assert from_counts(register, 0.1) == pytest.approx(value_kpa, abs=0.0501)


def test_counts_that_do_not_fit():
    """A pressure beyond int16 is refused, not wrapped."""
    assert to_counts(-0.1, 0.1) == 0xFFFF
    assert signed(0x8000) == -32768
    with pytest.raises(WireError) as error:
        to_counts(4000.0, 0.1)
    assert str(error.value) == "4000 kPa does not fit an int16 of 0.1 kPa"


@settings(max_examples=200)
@given(st.lists(st.integers(0, 65535), min_size=1, max_size=40))
def test_reads_cover_what_is_asked_for(addresses):
    """Every address is in exactly one read, and no read is longer than Modbus allows."""
    found = spans(addresses)
    assert all(1 <= count <= 125 for _, count in found)
    for address in addresses:
        assert sum(first <= address < first + count for first, count in found) == 1


@pytest.mark.parametrize("file", sorted(path.name for path in MAPS.glob("*.yaml")))
def test_shipped_maps_load(file):
    """The maps that come with labrig are valid."""
    assert load_map(file).setpoint.addresses


@pytest.mark.parametrize(
    ("change", "text"),
    [
        (
            lambda text: text.replace("[4112]", "[4112, 4113]"),
            "the map: measured: needs 2 addresses, one for each set-point",
        ),
        (lambda text: text.replace("kpa_per_count: 0.1\n", ""), "kpa_per_count: Field required"),
        (
            lambda text: text.replace("[error]", "[eror]"),
            "the map: faults: 'eror' is not among the registers",
        ),
        (lambda text: text + "speed: 9\n", "speed: Extra inputs are not permitted"),
        (
            lambda text: text.replace("setpoint: {table: holding", "setpoint: {table: input"),
            "the map: setpoint: only holding registers can be written",
        ),
    ],
)
def test_wrong_maps_are_named(tmp_path, change, text):
    """A map that cannot be used says which field is wrong."""
    file = tmp_path / "map.yaml"
    file.write_text(change((MAPS / "festo-pgva.yaml").read_text()))
    with pytest.raises(RegisterMapError) as error:
        load_map(file)
    assert str(error.value) == f"{file}: {text}"


@pytest.mark.parametrize(
    ("channels", "settings", "text"),
    [
        (
            CHANNELS,
            {"map": "nope.yaml"},
            "map: nope.yaml: no such register map (labrig brings festo-pgva.yaml, festo-vtem.yaml)",
        ),
        (
            CHANNELS,
            {"map": "festo-pgva.yaml"},
            "outputs [0, 1, 2, 3] are not different outputs from 0 to 0 of Festo PGVA-1",
        ),
        (
            [Channel("c1", 0, 60)],
            {"map": "festo-pgva.yaml"},
            "c1 may not be set from 0 to 60 kPa: Festo PGVA-1 does -45 to 45 kPa",
        ),
        (CHANNELS, {"host": None}, "give either host (Modbus TCP) or serial (RTU)"),
        (CHANNELS, {"unit_id": 300}, "unit_id: Input should be less than or equal to 247"),
    ],
)
def test_settings_that_cannot_be(driver, channels, settings, text):
    """What the map cannot do for the rig is refused before anything is connected."""
    with pytest.raises(DeviceError) as error:
        driver(1, channels, **settings)
    assert str(error.value) == f"pressure: {text}"


def test_nothing_listens(driver):
    """A port without a server is named."""
    import socket

    with socket.create_server(("127.0.0.1", 0)) as listener:
        port = listener.getsockname()[1]
    with pytest.raises(DeviceError) as error:
        driver(port).connect()
    assert str(error.value) == (
        f"pressure: no Modbus device answers at 127.0.0.1:{port} within 1 s (right address, switched on?)"
    )


def test_a_devices_own_watchdog_vents_when_nobody_speaks(
    tmp_path, shared, closing, driver, until, monkeypatch
):
    """Set at the start, named in the identity; when the link is cut with chambers under pressure, they are vented."""
    text = (MAPS / "festo-vtem.yaml").read_text(encoding="utf-8")
    path = tmp_path / "watched.yaml"
    path.write_text(text + "watchdog: {address: 40100, value: 500, timeout_s: 0.5}\n", encoding="utf-8")
    twin = closing(ModbusTwin(shared, load_map(path)).start())
    device = driver(twin.port, map=str(path))
    device.connect()
    assert device.identify().details["watchdog"] == "0.5 s"
    device.set(np.array([20.0, 20.0, 20.0, 20.0]))
    until(lambda: shared.pressure_kpa().min() > 19.0)
    client = device._wire._client
    monkeypatch.setattr("pymodbus.client.ModbusTcpClient.connect", lambda _: False)
    client.close()  # as a computer that dies: no set-point 0 is sent
    until(lambda: shared.pressure_kpa().max() < 1.0)


def test_a_watchdog_that_is_not_kept_is_no_watchdog(tmp_path, shared, closing, driver, monkeypatch):
    """The register is read back: a device that does not keep it is not used."""
    text = (MAPS / "festo-vtem.yaml").read_text(encoding="utf-8")
    path = tmp_path / "watched.yaml"
    path.write_text(text + "watchdog: {address: 40100, value: 500, timeout_s: 0.5}\n", encoding="utf-8")
    twin = ModbusTwin(shared, load_map(path))
    monkeypatch.setattr(twin, "_read_all", lambda _: {40100: 7})
    closing(twin.start())
    with pytest.raises(DeviceError, match="does not keep its watchdog: register 40100 reads 7 after 500"):
        driver(twin.port, map=str(path)).connect()


def test_a_misspelt_name_in_a_map_says_what_was_meant(tmp_path):
    """Both the name that is there and the one that is missing are shown."""
    text = (MAPS / "festo-pgva.yaml").read_text(encoding="utf-8").replace("kpa_per_count", "kpa_per_counts")
    path = tmp_path / "mine.yaml"
    path.write_text(text, encoding="utf-8")
    with pytest.raises(RegisterMapError) as caught:
        load_map(path)
    assert str(caught.value) == f"{path}: kpa_per_counts: there is no such field; did you mean kpa_per_count?"


def test_a_register_that_a_map_names_twice_is_refused(tmp_path):
    """The last of two addresses is not taken silently: the line and the key are named."""
    path = tmp_path / "map.yaml"
    path.write_text("name: x\nkpa_per_count: 0.1\nkpa_per_count: 1\n")
    with pytest.raises(RegisterMapError, match=r"line 3: kpa_per_count is given twice \(first in line 2\)"):
        load_map(path)
