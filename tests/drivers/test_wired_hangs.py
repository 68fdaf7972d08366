"""A call into a port that does not come back holds nobody up."""

import threading

import pytest

from labrig_drivers import DeviceError, RealClock, VentNotConfirmedError
from labrig_drivers._wired_pressure import PressureOptions, WiredPressure
from tests.drivers.test_wired_pressure import CHANNELS, MemoryWire
from tests.waiting import wait_for

HANGS = "an earlier call hangs and holds the port; unplug the device and plug it in again"


class HangingWire(MemoryWire):
    """A wire of which the call `stuck` does not come back before it is `freed`."""

    def __init__(self, stuck):
        super().__init__()
        self.stuck, self.freed, self.hangs = stuck, threading.Event(), threading.Event()

    def _hang(self, call):
        if call == self.stuck and not self.freed.is_set():
            self.hangs.set()
            self.freed.wait(10.0)
            self.freed.set()

    def open(self):
        self._hang("open")
        super().open()

    def poll(self, timeout_s):
        self._hang("poll")
        return super().poll(timeout_s)


def test_a_port_that_hangs_while_it_is_opened_holds_nobody_up():
    """`connect` gives up while the port hangs; only when that came back, at rest, is the wire used again."""
    wire = HangingWire("open")
    device = WiredPressure("pressure", "memory", CHANNELS, RealClock(), wire, PressureOptions(open_s=0.1))
    with pytest.raises(DeviceError, match=r"^pressure: did not answer within 0\.1 s$"):
        device.connect()
    assert not wire.freed.is_set()
    for call in (device.connect, device.samples, device.identify):
        with pytest.raises(DeviceError) as error:
            call()
        assert str(error.value) == f"pressure: {HANGS}"
    with pytest.raises(VentNotConfirmedError) as error:
        device.vent()
    assert str(error.value) == f"pressure: vent not confirmed: {HANGS}"
    wire.freed.set()
    wait_for(lambda: not device._left.is_alive())
    assert not wire.is_open
    device.connect()
    device.vent()
    device.close()


def test_a_device_that_hangs_can_be_closed():
    """`close` comes back while the port hangs; the device is left at rest when the port comes back."""
    wire = HangingWire("poll")
    device = WiredPressure("pressure", "memory", CHANNELS, RealClock(), wire, PressureOptions(call_s=0.1))
    device.connect()
    wire.hangs.wait(10.0)
    device.close()
    assert not wire.freed.is_set()
    wire.freed.set()
    wait_for(lambda: not wire.is_open)
