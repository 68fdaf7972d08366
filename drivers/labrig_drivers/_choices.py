"""What a person may choose from before a device is connected: the serial ports of this computer, register maps."""


def serial_ports() -> list[tuple[str, str]]:
    """The serial ports that this computer has, by name, each with what is known of it; none is opened.

    Where the system does not tell, there are none.
    """
    try:
        from serial.tools.list_ports import comports

        found = [(str(port.device), _about(port.description, port.device)) for port in comports()]
    except (ImportError, OSError, ValueError):
        return []
    return sorted(found)


def _about(description: str | None, device: str) -> str:
    """What the system says of a port, where it says more than its name."""
    said = " ".join((description or "").split())
    return "" if said in ("n/a", device, device.rpartition("/")[2]) else said


def register_maps() -> tuple[str, ...]:
    """The names of the register maps that come with labrig."""
    from labrig_drivers._modbus_map import MAPS

    return tuple(sorted(path.name for path in MAPS.glob("*.yaml")))
