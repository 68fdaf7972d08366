"""A stop sends set-points of zero whatever the driver believes the device to have: boards have no other watchdog."""

import pytest

from labrig_drivers import Channel, RealClock, build_device
from labrig_drivers._modbus_map import load_map
from labrig_drivers.simulated._modbus_twin import ModbusTwin
from labrig_drivers.simulated._openpneu_board import OpenPneuBoard
from labrig_drivers.simulated._openpneu_twin import OpenPneuTwin

CHANNELS = tuple(Channel(name, 0.0, 60.0) for name in ("c1", "c2", "c3", "c4"))


@pytest.fixture
def connected(closing):
    """Makes a driver and connects it."""

    def make(kind, **settings):
        device = build_device(kind, settings, name="pressure", clock=RealClock(), channels=CHANNELS)
        closing(device).connect()
        return device

    return make


@pytest.mark.parametrize("dialect", ["published", "table"])
def test_openpneu_sends_zero_again(shared, closing, connected, until, plant, dialect):
    """A board that has targets which the driver did not send, as after a disturbed line, is vented all the same."""
    board = OpenPneuBoard(shared, dialect, "full")
    twin = closing(OpenPneuTwin(board, boot_s=0.0).start())
    device = connected("openpneu", port=twin.port, boot_s=0.0, build="full")
    board.target_kpa[:4] = 30.0
    until(lambda: plant.commands[-1].tolist() == [30.0] * 4)
    device.vent()
    assert board.target_kpa.tolist() == [0.0] * 10
    assert not plant.commands[-1].any()


def test_modbus_sends_zero_again(shared, closing, connected, plant):
    """Set-points that another program wrote are gone after a vent."""
    from pymodbus.client import ModbusTcpClient

    twin = closing(ModbusTwin(shared, load_map("festo-vtem.yaml")).start())
    device = connected("modbus", host="127.0.0.1", port=twin.port, map="festo-vtem.yaml")
    other = closing(ModbusTcpClient("127.0.0.1", port=twin.port, timeout=2, retries=0))
    assert other.connect()
    for address in (40004, 40005, 40007, 40008):
        other.write_register(address, 300, device_id=1)
    assert plant.commands[-1].tolist() == [30.0] * 4
    device.vent()
    assert not plant.commands[-1].any()
    assert other.read_holding_registers(40003, count=6, device_id=1).registers == [3, 0, 0, 3, 0, 0]


def test_readings_of_the_table_are_begun_anew_after_a_stop(shared, closing, connected):
    """In the dialect without telemetry no set of readings is half from before the stop and half from after it."""
    twin = closing(OpenPneuTwin(OpenPneuBoard(shared, "table", "full"), boot_s=0.0).start())
    device = connected("openpneu", port=twin.port, boot_s=0.0, build="full")
    wire, left = device._wire, []

    def stop():
        wire._partial = [0.0]
        type(wire).stop(wire)
        left.append(list(wire._partial))

    wire.stop = stop
    device.vent()
    assert left[0] == []
