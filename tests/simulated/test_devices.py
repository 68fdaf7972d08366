"""In-process simulated devices behave as the protocols say, on a simulated clock."""

from pathlib import Path

import numpy as np
import pytest

from labrig_drivers import (
    DeviceError,
    MotionCapture,
    PressureController,
    Scanner,
    SimulatedClock,
    VentNotConfirmedError,
)
from labrig_drivers.simulated import SimulatedMocap, SimulatedPressure, SimulatedScanner, build_plant

RIG = {
    "chambers": [{"name": f"c{i}", "min_kpa": 0, "max_kpa": 60} for i in range(1, 10)],
    "simulated": {"surface": "mannequin"},
}


@pytest.fixture
def clock() -> SimulatedClock:
    """A clock that costs no waiting."""
    return SimulatedClock()


def test_the_devices_are_what_the_protocols_ask_for(clock: SimulatedClock) -> None:
    """Each simulated device has every member of its protocol."""
    plant = build_plant(RIG, Path())
    assert isinstance(SimulatedPressure(plant, clock), PressureController)
    assert isinstance(SimulatedMocap(plant, clock), MotionCapture)
    assert isinstance(SimulatedScanner(plant, clock), Scanner)


def test_frames_are_all_those_since_the_last_call(clock: SimulatedClock) -> None:
    """Polled now and then, motion capture gives every frame once, evenly spaced."""
    mocap = SimulatedMocap(build_plant(RIG, Path()), clock, rate_hz=100.0)
    mocap.connect()
    frames = mocap.frames()
    for pause_s in (0.003, 0.5, 0.0, 1.497):
        clock.sleep(pause_s)
        frames += mocap.frames()
    assert [frame.number for frame in frames] == list(range(201))
    np.testing.assert_allclose(np.diff([frame.time_s for frame in frames]), 0.01, atol=1e-5)
    assert frames[0].position_mm.shape == (34, 3)


def test_polling_does_not_change_what_is_seen() -> None:
    """The same campaign polled twenty times a second or once gives the same frames."""

    def campaign(polls: int) -> np.ndarray:
        clock = SimulatedClock()
        plant = build_plant({**RIG, "simulated": {"surface": "mannequin", "occlusion": 0.2}}, Path())
        pressure, mocap = SimulatedPressure(plant, clock), SimulatedMocap(plant, clock, rate_hz=50.0)
        pressure.connect()
        mocap.connect()
        frames = mocap.frames()
        for level in (10.0, 50.0):
            pressure.set(np.full(9, level))
            for _ in range(polls):
                clock.sleep(2.0 / polls)
                frames += mocap.frames()
        return np.stack([frame.position_mm for frame in frames])

    np.testing.assert_allclose(campaign(40), campaign(4), atol=0.05)


def test_a_set_point_outside_the_limits_moves_nothing(clock: SimulatedClock) -> None:
    """The message names device, chamber and limits, and the pressures stay."""
    pressure = SimulatedPressure(build_plant(RIG, Path()), clock)
    pressure.connect()
    wanted = np.zeros(9)
    wanted[2] = 61.0
    with pytest.raises(DeviceError) as error:
        pressure.set(wanted)
    assert str(error.value) == "pressure: c3: 61 kPa is outside 0..60 kPa; nothing was moved"
    clock.sleep(1.0)
    assert np.abs(pressure.samples()[-1].pressure_kpa).max() < 0.5


def test_a_vent_is_confirmed_by_reading(clock: SimulatedClock) -> None:
    """Venting takes as long as the air needs, and says what was read; too short a timeout is an error."""
    pressure = SimulatedPressure(build_plant(RIG, Path()), clock)
    pressure.connect()
    pressure.set(np.full(9, 50.0))
    clock.sleep(3.0)
    with pytest.raises(
        VentNotConfirmedError, match=r"^pressure: c\d still reads \d+\.\d kPa 0\.2 s after venting$"
    ):
        pressure.vent(timeout_s=0.2)
    report = pressure.vent()
    assert np.abs(report.pressure_kpa).max() < 1.0
    assert report.took_s < 1.0


def test_a_device_that_is_not_connected_says_so(clock: SimulatedClock) -> None:
    """Before connect and after close every call is an error that names the device."""
    mocap = SimulatedMocap(build_plant(RIG, Path()), clock, name="cameras")
    for _ in range(2):
        with pytest.raises(DeviceError) as error:
            mocap.frames()
        assert str(error.value) == "cameras: not connected"
        mocap.connect()
        assert mocap.identify().name == "cameras"
        mocap.close()


def test_a_scan_shows_the_surface(clock: SimulatedClock) -> None:
    """A scan takes its time, and its vertices lie on the inflated surface within the noise."""
    plant = build_plant(RIG, Path())
    plant.command(clock.now_s(), np.full(9, 40.0))
    scanner = SimulatedScanner(plant, clock, takes_s=15.0)
    scanner.connect()
    began_s = clock.now_s()
    scan = scanner.scan()
    assert clock.now_s() - began_s == pytest.approx(15.0)
    error = scan.vertices_mm - plant.surface(clock.now_s())[0]
    assert np.sqrt(np.mean(error**2)) == pytest.approx(0.05, rel=0.05)
    assert len(scan.sha256) == 64
    with pytest.raises(DeviceError) as failure:
        scanner.scan(timeout_s=5.0)
    assert str(failure.value) == "scanner: no complete scan within 5 s"
