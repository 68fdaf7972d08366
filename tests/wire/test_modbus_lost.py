"""A Modbus device that is switched off: what to look at is said, not how many bytes of what had come in by then."""

import pytest
from pymodbus.exceptions import ConnectionException

from labrig_drivers._modbus import ModbusOptions, ModbusWire
from labrig_drivers._modbus_map import load_map
from labrig_drivers._transport import LinkError


def test_a_connection_that_is_closed() -> None:
    """The library's own text of it is replaced; of another failure it is kept."""
    wire = ModbusWire(ModbusOptions(load_map("festo-pgva.yaml"), (0,), host="regulator"))
    wire._client = object()

    def failing(text: str):
        raise ConnectionException(text)

    closed = "Connection unexpectedly closed 0.004 seconds into read of unbounded read bytes without response"
    with pytest.raises(LinkError, match=r": it closed the connection; is it on, and its cable in\?$"):
        wire._call(lambda: failing(closed))
    with pytest.raises(LinkError, match=r"no route$"):
        wire._call(lambda: failing("no route"))
