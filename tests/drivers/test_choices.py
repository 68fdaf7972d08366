"""What can be chosen before a device is connected, and what a controller sets together."""

import sys
from types import SimpleNamespace

import pytest

from labrig_drivers import Channel, register_maps, serial_ports, set_together

CHAMBERS = [Channel(f"c{n}", 0.0, 60.0, 100.0) for n in range(1, 5)]


def test_serial_ports_are_named_with_what_is_known_of_them(monkeypatch: pytest.MonkeyPatch) -> None:
    """By their names, in order; what says no more than the name is left out."""
    found = [("COM7", "OpenPneu (USB)"), ("/dev/ttyS0", "ttyS0"), ("COM3", "n/a"), ("COM4", None)]
    ports = [SimpleNamespace(device=name, description=about) for name, about in found]
    monkeypatch.setattr("serial.tools.list_ports.comports", lambda: ports)
    assert serial_ports() == [
        ("/dev/ttyS0", ""),
        ("COM3", ""),
        ("COM4", ""),
        ("COM7", "OpenPneu (USB)"),
    ]


def test_without_a_way_to_tell_there_are_no_ports(monkeypatch: pytest.MonkeyPatch) -> None:
    """Where pyserial is missing, or the system refuses: a name can still be typed."""

    def refuses() -> None:
        raise OSError("not here")

    monkeypatch.setattr("serial.tools.list_ports.comports", refuses)
    assert serial_ports() == []
    monkeypatch.setitem(sys.modules, "serial.tools.list_ports", None)
    assert serial_ports() == []


def test_the_maps_that_labrig_brings() -> None:
    """Those that the documentation names."""
    assert register_maps() == ("festo-pgva.yaml", "festo-vtem.yaml")


@pytest.mark.parametrize(
    ("settings", "together"),
    [
        ({}, "c1 and c2"),
        ({"outputs": [0, 2, 4, 3]}, "c2 and c4"),
        ({"outputs": [0, 2, 4, 6]}, None),
        ({"build": "full"}, None),
        ({"dialect": "table"}, None),
    ],
)
def test_chambers_of_one_pair_are_named(settings: dict[str, object], together: str | None) -> None:
    """The published firmware has one target a pair of channels; another one does not."""
    said = set_together("openpneu", {"port": "COM3", **settings}, CHAMBERS)
    assert (said is None) if together is None else said is not None and said.startswith(together)
    assert set_together("modbus", {}, CHAMBERS) is None
