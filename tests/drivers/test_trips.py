"""Which readings stop a device, and which confirm a vent: counted one by one, over a wire whose readings are a list."""

import time
from collections import deque

import numpy as np
import pytest

from labrig_drivers import Channel, DeviceError, RealClock, VentNotConfirmedError
from labrig_drivers._wired_pressure import PressureOptions, WiredPressure, WireError
from tests.waiting import wait_for

CHANNELS = (Channel("a", 0, 60), Channel("b", -20, 40))
FINE, CALM = (20.0, 10.0), (1.0, -1.0)
ABOVE, BELOW = (70.5, 0.0), (0.0, -30.5)


class ScriptedWire:
    """A device that says what it was told to: at each poll one batch of readings, and nothing when all are said."""

    def __init__(self):
        self.batches, self.after_stop = deque(), deque()
        self.every_s = 0.0
        self.idle = self.stops = 0
        self.stuck = False
        self.written = []
        self._next_s = 0.0

    def say(self, *readings):
        """One reading at each of the next polls."""
        self.batches.extend([np.array(reading)] for reading in readings)

    def open(self):
        pass

    def close(self):
        pass

    def write(self, pressure_kpa):
        self.written.append(pressure_kpa.tolist())

    def poll(self, timeout_s):
        now_s = time.monotonic()
        if now_s < self._next_s:
            time.sleep(min(timeout_s, self._next_s - now_s))
            return []
        self._next_s = now_s + self.every_s
        if self.batches:
            return self.batches.popleft()
        self.idle += 1
        time.sleep(0.001)
        return []

    def stop(self):
        if self.stuck:
            raise WireError("the valve is stuck")
        self.stops += 1
        self.batches.extend(self.after_stop)
        self.after_stop.clear()


@pytest.fixture
def wire():
    return ScriptedWire()


@pytest.fixture
def device(wire):
    """A device over the wire that does not mind silence; closed after the test."""
    options = PressureOptions(stale_after_s=600.0, ramp_hz=1000.0)
    device = WiredPressure("pressure", "scripted", CHANNELS, RealClock(), wire, options)
    device.connect()
    yield device
    device.close()


def hear(wire, *readings):
    """Let the device take in readings, and what it does about the last one."""
    idle = wire.idle
    wire.say(*readings)
    wait_for(lambda: not wire.batches and wire.idle > idle + 1)


@pytest.mark.parametrize(
    ("outside", "text"),
    [
        (ABOVE, "a reads 70.5 kPa, its limits are 0 to 60 kPa"),
        (BELOW, "b reads -30.5 kPa, its limits are -20 to 40 kPa"),
    ],
    ids=["above", "below"],
)
def test_the_third_reading_outside_the_limits_stops_the_device(wire, device, outside, text):
    """Above the highest or below the lowest limit: three readings in a row trip, and no more are waited for."""
    hear(wire, outside, outside, outside)
    assert wire.stops == 1
    with pytest.raises(DeviceError) as error:
        device.set(np.zeros(2))
    assert (
        str(error.value) == f"pressure: {text}; stopped, and no set-point is taken until a vent is confirmed"
    )


@pytest.mark.parametrize("outside", [ABOVE, BELOW], ids=["above", "below"])
def test_two_readings_outside_the_limits_do_not(wire, device, outside):
    """Two readings outside, one inside and two outside again are no reason to stop."""
    hear(wire, outside, outside, FINE, outside, outside)
    assert wire.stops == 0
    device.set(np.array([10.0, 0.0]))


def test_a_reading_within_the_margin_does_not_trip(wire, device):
    """What is less than `over_kpa` outside the limits is the controller's overshoot."""
    hear(wire, *[(69.5, -29.5)] * 10)
    assert wire.stops == 0


def test_after_a_trip_nothing_is_driven_any_more(wire, device):
    """The set-point from before is forgotten: no write follows the stop."""
    device.set(np.array([20.0, 0.0]))
    wait_for(lambda: wire.written)
    hear(wire, ABOVE, ABOVE, ABOVE)
    assert wire.stops == 1
    idle = wire.idle
    wait_for(lambda: wire.idle > idle + 50)
    assert wire.written == [[20.0, 0.0]]


def test_a_device_that_cannot_be_stopped_takes_no_set_point(wire, device):
    """When the stop itself fails that is said, and set-points are refused."""
    wire.stuck = True
    hear(wire, ABOVE, ABOVE, ABOVE)
    with pytest.raises(DeviceError) as error:
        device.set(np.zeros(2))
    assert str(error.value) == (
        "pressure: a reads 70.5 kPa, its limits are 0 to 60 kPa; and it could not be stopped: the valve is stuck"
    )


def test_three_calm_readings_confirm_a_vent(wire, device):
    """Each channel near ambient, three times in a row after the stop."""
    hear(wire, FINE)
    wire.after_stop.extend([[], *([np.array(CALM)] for _ in range(3))])
    assert device.vent().pressure_kpa.tolist() == list(CALM)


@pytest.mark.parametrize(
    "readings",
    [
        [CALM, CALM],
        [CALM, CALM, FINE, CALM, CALM],
        [(1.0, -10.0)] * 5,  # vacuum
        [CALM, CALM, (np.nan, 0.0)] * 2,
    ],
    ids=["two", "two and two", "vacuum", "no sensor"],
)
def test_fewer_than_three_calm_readings_in_a_row_confirm_nothing(wire, device, readings):
    """Neither two, nor three with another between them, nor any under vacuum or without a sensor."""
    hear(wire, FINE)
    wire.after_stop.extend([[], *([np.array(reading)] for reading in readings)])
    with pytest.raises(VentNotConfirmedError, match=r"^pressure: vent not confirmed within 0\.3 s: "):
        device.vent(timeout_s=0.3)


def test_a_channel_without_a_sensor_is_not_waited_for(wire, device):
    """Of a channel that never gave a reading none can confirm the vent: the others do."""
    wire.after_stop.extend([[], *([np.array((1.0, np.nan))] for _ in range(3))])
    assert device.vent().pressure_kpa[0] == 1.0


def test_without_any_sensor_no_vent_is_confirmed(wire, device):
    """Where no channel ever gave a reading nothing says that the chambers are empty."""
    wire.after_stop.extend([[], *([np.array((np.nan, np.nan))] for _ in range(5))])
    with pytest.raises(VentNotConfirmedError) as error:
        device.vent(timeout_s=0.3)
    assert str(error.value) == (
        "pressure: vent not confirmed within 0.3 s: no pressure reading; relieve the pressure by hand"
    )


@pytest.mark.parametrize("after", [0, 2], ids=["nothing", "two"])
def test_calm_readings_from_before_the_vent_do_not_count(wire, device, after):
    """A device that read calm all the time, and says too little after the stop, is not confirmed."""
    hear(wire, *[CALM] * 5)
    wire.after_stop.extend([[], *([np.array(CALM)] for _ in range(after))])
    with pytest.raises(VentNotConfirmedError, match=r"^pressure: vent not confirmed within 0\.3 s: "):
        device.vent(timeout_s=0.3)


def test_readings_that_came_while_the_device_was_being_stopped_do_not_count(wire, device):
    """A batch that waited behind the stop is from before it: it is logged, and confirms nothing."""
    wire.after_stop.append([np.array(CALM)] * 3)
    with pytest.raises(VentNotConfirmedError, match=r"^pressure: vent not confirmed within 0\.9 s: "):
        device.vent(timeout_s=0.9)
    assert len(device.samples()) == 3


def test_a_device_that_reads_seldom_can_be_vented(wire, device):
    """At two and a half readings a second three calm ones take longer than the stop is sent again."""
    wire.every_s = 0.4
    wire.say(*[CALM] * 100)
    assert device.vent().pressure_kpa.tolist() == list(CALM)
