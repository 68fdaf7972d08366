"""Limits, slew, trips and the confirmed vent, over a wire in memory; a state machine of all of it."""

import time

import numpy as np
import pytest
from hypothesis import settings
from hypothesis import strategies as st
from hypothesis.stateful import RuleBasedStateMachine, invariant, precondition, rule

from labrig_drivers import Channel, DeviceError, RealClock, VentNotConfirmedError
from labrig_drivers._recording import Recorder, read_pieces
from labrig_drivers._transport import LinkError
from labrig_drivers._wired_pressure import PressureOptions, WiredPressure, WireError
from tests.waiting import wait_for

CHANNELS = (Channel("a", 0, 60), Channel("b", -20, 40))


class MemoryWire:
    """A device that is a few numbers: it reads what it was set to, unless it is stuck, mute or unplugged."""

    def __init__(self):
        self.set_kpa = np.zeros(2)
        self.stuck_kpa = None
        self.mute = self.unplugged = self.refuses = False
        self.is_open = False
        self.written = []
        self.stops = 0
        self.closes = 0

    def _live(self):
        if self.unplugged or not self.is_open:
            raise LinkError("lost the wire")

    def open(self):
        if self.unplugged:
            raise LinkError("cannot open the wire")
        self.is_open = True
        self.set_kpa = np.zeros(2)

    def identify(self):
        self._live()
        return "a wire", {}

    def write(self, pressure_kpa):
        self._live()
        if self.refuses:
            raise WireError("the device refuses")
        self.set_kpa = pressure_kpa.copy()
        self.written.append((time.monotonic(), pressure_kpa.copy()))

    def poll(self, timeout_s):
        time.sleep(min(timeout_s, 0.001))
        self._live()
        if self.mute:
            return []
        return [self.set_kpa.copy() if self.stuck_kpa is None else np.array(self.stuck_kpa, float)]

    def stop(self):
        self._live()
        self.set_kpa = np.zeros(2)
        self.stops += 1

    def close(self):
        self.is_open = False
        self.closes += 1


@pytest.fixture
def wire():
    return MemoryWire()


@pytest.fixture
def make(wire):
    """A device over the wire, connected; closed after the test."""
    made = []

    def make(channels=CHANNELS, **options):
        device = WiredPressure("pressure", "memory", channels, RealClock(), wire, PressureOptions(**options))
        made.append(device)
        device.connect()
        return device

    yield make
    for device in made:
        device.close()


def test_a_second_try_to_connect_is_recorded_as_well(wire, tmp_path):
    """What passes after a first connect that failed is in the recording, until the device is closed."""
    recorder = Recorder(tmp_path / "a.wire", "memory", "pressure")
    opened = wire.open

    def says_so():
        recorder.piece(True, b"open")
        opened()

    wire.open, wire.unplugged = says_so, True
    device = WiredPressure(
        "pressure", "memory", CHANNELS, RealClock(), wire, PressureOptions(), recorder=recorder
    )
    with pytest.raises(DeviceError, match="cannot open the wire"):
        device.connect()
    wire.unplugged = False
    device.connect()
    device.close()
    assert [piece.data for piece in read_pieces(tmp_path / "a.wire")] == [b"open", b"open"]


def test_set_points_reach_the_wire_and_are_read_back(wire, make):
    """What is set is written, and the samples show it."""
    device = make()
    device.set(np.array([30.0, -10.0]))
    wait_for(lambda: any(s.pressure_kpa.tolist() == [30, -10] for s in device.samples()))
    assert wire.set_kpa.tolist() == [30, -10]


@pytest.mark.parametrize(
    ("target", "text"),
    [
        ([60.1, 0], "pressure: a set to 60.1 kPa, its limits are 0 to 60 kPa; nothing was moved"),
        ([0, -20.5], "pressure: b set to -20.5 kPa, its limits are -20 to 40 kPa; nothing was moved"),
        ([np.nan, 0], "pressure: a set to nan kPa, its limits are 0 to 60 kPa; nothing was moved"),
        ([0, np.inf], "pressure: b set to inf kPa, its limits are -20 to 40 kPa; nothing was moved"),
        ([1, 2, 3], "pressure: 3 set-points for 2 channels"),
    ],
)
def test_outside_the_limits_nothing_is_written(wire, make, target, text):
    """A set-point outside a channel's limits, or no number, is refused before anything is written."""
    device = make()
    with pytest.raises(DeviceError) as error:
        device.set(np.array(target, float))
    assert str(error.value) == text
    assert wire.written == []


def test_slew_is_kept(wire, make):
    """Set-points approach the target in steps of the channel's slew, and end on it."""
    device = make([Channel("a", 0, 60, slew_kpa_s=100.0), Channel("b", 0, 60, slew_kpa_s=50.0)], ramp_hz=50.0)
    device.set(np.array([10.0, 10.0]))
    wait_for(lambda: wire.set_kpa.tolist() == [10, 10])
    steps = np.diff([np.zeros(2), *[kpa for _, kpa in wire.written]], axis=0)
    assert np.all(steps <= np.array([2.0, 1.0]) + 1e-9)
    assert len(steps) == 10
    device.vent()
    assert wire.set_kpa.tolist() == [0, 0]  # at once


def test_vent_is_confirmed_by_reading(wire, make):
    """A vent returns only after readings near ambient."""
    device = make()
    device.set(np.array([50.0, 20.0]))
    report = device.vent()
    assert np.all(np.abs(report.pressure_kpa) < 3)
    assert wire.stops >= 1


def test_vent_that_does_not_succeed_says_what_is_still_up(wire, make):
    """If the pressure does not fall the vent names the channels and what they read."""
    device = make(over_kpa=1000.0)
    wire.stuck_kpa = [50.0, 0.5]
    with pytest.raises(VentNotConfirmedError) as error:
        device.vent(timeout_s=0.3)
    assert str(error.value) == (
        "pressure: vent not confirmed within 0.3 s: a reads 50.0 kPa; relieve the pressure by hand"
    )
    with pytest.raises(DeviceError) as error:
        device.set(np.array([1.0, 0.0]))
    assert str(error.value) == ("pressure: the last vent is not confirmed; vent again before any set-point")
    wire.stuck_kpa = None
    device.vent()
    device.set(np.array([1.0, 0.0]))


def test_a_channel_without_reading_is_not_confirmed(wire, make):
    """NaN is no confirmation where there was a reading before."""
    device = make()
    wait_for(device.samples)
    wire.stuck_kpa = [np.nan, 0.0]
    with pytest.raises(VentNotConfirmedError, match=r"a reads nan kPa; relieve the pressure by hand$"):
        device.vent(timeout_s=0.2)


def test_old_readings_confirm_nothing(wire, make):
    """Readings from before the vent do not count: a device that has gone mute is not confirmed."""
    device = make(stale_after_s=60.0)
    wait_for(device.samples)
    wire.mute = True
    time.sleep(0.05)
    with pytest.raises(VentNotConfirmedError, match=r"^pressure: vent not confirmed within 0\.2 s: "):
        device.vent(timeout_s=0.2)


def test_silence_trips_and_only_a_vent_helps(wire, make):
    """Without readings the device is stopped and takes no set-point until a vent is confirmed."""
    device = make(stale_after_s=0.1)
    device.set(np.array([20.0, 0.0]))
    wire.mute = True
    wait_for(lambda: wire.stops == 1)
    assert wire.set_kpa.tolist() == [0, 0]
    device.samples()
    for call in (lambda: device.set(np.zeros(2)), device.samples):
        with pytest.raises(
            DeviceError,
            match=r"^pressure: no pressure reading for 0\.\d s; stopped, and no set-point is taken until a "
            r"vent is confirmed$",
        ):
            call()
    wire.mute = False
    device.vent()
    device.set(np.array([5.0, 0.0]))


def test_over_pressure_trips(wire, make):
    """A reading well above a limit stops the device and names the channel."""
    device = make()
    wire.stuck_kpa = [75.0, 0.0]
    wait_for(lambda: wire.stops == 1)
    device.samples()
    with pytest.raises(DeviceError) as error:
        device.set(np.zeros(2))
    assert str(error.value) == (
        "pressure: a reads 75.0 kPa, its limits are 0 to 60 kPa; stopped, and no set-point is taken until a "
        "vent is confirmed"
    )


def test_one_wild_reading_does_not_trip(wire, make):
    """A single reading above the limits is no reason to stop."""
    device = make()
    device._take(np.array([500.0, 0.0]))
    device.set(np.array([10.0, 0.0]))
    wait_for(lambda: wire.set_kpa[0] == 10)
    assert wire.stops == 0


def test_a_lost_link_is_named_and_a_vent_opens_it_again(wire, make):
    """After the link is lost every call says so; a vent reconnects and confirms, or says why not."""
    device = make()
    device.set(np.array([20.0, 0.0]))
    wire.unplugged = True
    wait_for(lambda: not wire.is_open)
    device.samples()
    with pytest.raises(DeviceError, match=r"^pressure: lost the wire$"):
        device.set(np.zeros(2))
    with pytest.raises(VentNotConfirmedError) as error:
        device.vent(timeout_s=0.2)
    assert str(error.value) == (
        "pressure: vent not confirmed within 0.2 s: cannot open the wire; relieve the pressure by hand"
    )
    wire.unplugged = False
    device.vent()
    device.set(np.array([5.0, 0.0]))


def test_a_refused_write_is_the_callers_error(wire, make):
    """What the device says against a set-point reaches the caller, and the link stays."""
    device = make()
    wire.refuses = True
    with pytest.raises(DeviceError, match=r"^pressure: the device refuses$"):
        device.set(np.array([5.0, 0.0]))
    assert wire.is_open


def test_an_unexpected_error_is_no_end(wire, make):
    """An error that nobody foresaw is reported like a lost link, and a vent still works."""
    device = make()
    wire.poll = lambda timeout_s: 1 / 0
    wait_for(lambda: not wire.is_open)
    device.samples()
    with pytest.raises(DeviceError, match=r"^pressure: unexpected ZeroDivisionError: division by zero$"):
        device.set(np.zeros(2))
    del wire.poll
    device.vent()


def test_samples_are_bounded(make):
    """Samples that nobody fetches push out the oldest, and are counted."""
    device = make(max_samples=5)
    wait_for(lambda: device.dropped > 0)
    assert len(device.samples()) <= 5


def test_not_connected(wire):
    """Before connecting, calls are refused; a failed connect leaves nothing behind."""
    device = WiredPressure("pressure", "memory", CHANNELS, RealClock(), wire, PressureOptions())
    with pytest.raises(DeviceError, match=r"^pressure: not connected$"):
        device.samples()
    with pytest.raises(VentNotConfirmedError, match=r"^pressure: vent not confirmed: not connected$"):
        device.vent()
    wire.unplugged = True
    with pytest.raises(DeviceError, match=r"^pressure: cannot open the wire$"):
        device.connect()
    wire.unplugged = False
    device.connect()
    device.close()
    device.close()
    assert not wire.is_open


class PressureMachine(RuleBasedStateMachine):
    """Any order of calls and mishaps: the wire never sees a set-point outside the limits."""

    def __init__(self):
        super().__init__()
        self.wire = MemoryWire()
        options = PressureOptions(stale_after_s=5.0, call_s=2.0, ramp_hz=500.0)
        self.device = WiredPressure("pressure", "memory", CHANNELS, RealClock(), self.wire, options)
        self.device.connect()
        self.healthy = True

    @rule(a=st.floats(0, 60), b=st.floats(-20, 40))
    def set_inside(self, a, b):
        if not self.healthy:
            with pytest.raises(DeviceError, match=r"^pressure: lost the wire"):
                self.device.set(np.array([a, b]))
            return
        self.device.set(np.array([a, b]))
        wait_for(lambda: self.wire.set_kpa.tolist() == [a, b])

    @rule(a=st.one_of(st.floats(60.001, 1e9), st.just(float("nan")), st.floats(-1e9, -0.001)))
    def set_outside(self, a):
        before = len(self.wire.written)
        with pytest.raises(DeviceError, match="nothing was moved"):
            self.device.set(np.array([a, 0.0]))
        assert len(self.wire.written) == before or not self.healthy

    @rule()
    def read(self):
        try:
            samples = self.device.samples()
        except DeviceError:
            assert not self.healthy
        else:
            times = [sample.time_s for sample in samples]
            assert times == sorted(times)

    @precondition(lambda self: self.healthy)
    @rule()
    def unplug(self):
        self.wire.unplugged = True
        self.healthy = False
        wait_for(lambda: not self.wire.is_open)

    @precondition(lambda self: not self.healthy)
    @rule()
    def plug_in_and_vent(self):
        self.wire.unplugged = False
        self.vent()
        self.healthy = True

    @precondition(lambda self: not self.healthy)
    @rule()
    def plug_in_and_connect(self):
        self.wire.unplugged = False
        self.device.connect()
        self.healthy = True
        assert self.wire.set_kpa.tolist() == [0, 0]

    @precondition(lambda self: self.healthy)
    @rule()
    def vent(self):
        report = self.device.vent(timeout_s=5)
        assert np.all(np.abs(report.pressure_kpa) < 3)
        assert self.wire.set_kpa.tolist() == [0, 0]

    @invariant()
    def never_outside_the_limits(self):
        for _, kpa in self.wire.written:
            assert 0 <= kpa[0] <= 60
            assert -20 <= kpa[1] <= 40

    def teardown(self):
        self.device.close()
        assert not self.wire.is_open


TestPressureMachine = PressureMachine.TestCase
TestPressureMachine.settings = settings(max_examples=25, stateful_step_count=15)
