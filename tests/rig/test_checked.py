"""A driver is anybody's: what it says of a vent, and what its methods return, is held against what must be."""

from collections.abc import Callable
from pathlib import Path
from typing import Any

import numpy as np
import pytest

from labrig.rig import connect, device_makers, load_rig, vent_now
from labrig_drivers import (
    DeviceError,
    Identity,
    MarkerFrame,
    PressureSample,
    RealClock,
    SimulatedClock,
    VentNotConfirmedError,
    VentReport,
    check_devices,
)

DRIVER = """
import numpy as np
from labrig_drivers import Identity, PressureSample, VentReport

class Own:
    held = np.array([50.0, 35.0])
    def __init__(self, name, clock, channels, mode):
        self.name, self.clock, self.channels, self.mode = name, clock, channels, mode
    def connect(self): ...
    def identify(self): return Identity(self.name, "own", "a driver of a test")
    def set(self, pressure_kpa): ...
    def samples(self): return [PressureSample(self.clock.now_s(), self.held)]
    def vent(self, timeout_s=10.0):
        return VentReport(self.held if self.mode == "reports" else np.zeros(2), 0.0)
    def close(self): ...
"""


class Driver:
    """A driver that does as its fields say; each of them is what a method returns, or raises."""

    def __init__(self, clock: SimulatedClock) -> None:
        self.name, self.clock, self.channels = "pressure", clock, ()
        self.reads: Callable[[], Any] = lambda: np.zeros(2)
        self.ahead_s = 0.0
        self.report: Any = VentReport(np.zeros(2), 0.1)
        self.connected = 0
        self.answer: Any = None

    def connect(self) -> None:
        """Count."""
        self.connected += 1

    def close(self) -> None:
        """Fail, which nobody must hear of."""
        raise OSError("closed twice")

    def identify(self) -> Any:
        """Itself."""
        return Identity("pressure", "fake", "fake")

    def set(self, _pressure_kpa: Any) -> None:
        """Fail as no driver should."""
        raise KeyError("register 7")

    def samples(self) -> Any:
        """One reading, or what the test wants in place of a list."""
        if self.answer is not None:
            return self.answer
        read = self.reads()
        return [] if read is None else [PressureSample(self.clock.now_s() + self.ahead_s, read)]

    def vent(self, _timeout_s: float = 10.0) -> Any:
        """What the test wants."""
        if isinstance(self.report, Exception):
            raise self.report
        return self.report


@pytest.fixture
def driver() -> Driver:
    """A driver that is all right."""
    return Driver(SimulatedClock())


@pytest.fixture
def checked(driver: Driver, write_rig: Callable[..., Path], monkeypatch: pytest.MonkeyPatch) -> Any:
    """The same as the rest of labrig has it."""
    monkeypatch.setattr("labrig.rig._factory.own_maker", lambda *_: lambda: driver)
    return device_makers(load_rig(write_rig()), driver.clock)["pressure"]()


def test_a_vent_is_confirmed_by_what_is_read_after_it(checked: Any, driver: Driver) -> None:
    """Readings that fall after the driver called it vented are waited for; what was read is in the report."""
    end_s = driver.clock.now_s() + 2.0
    driver.reads = lambda: np.full(2, 40.0 if driver.clock.now_s() < end_s else 0.5)
    report = checked.vent(10.0)
    assert driver.clock.now_s() >= end_s
    np.testing.assert_array_equal(report.pressure_kpa, [0.5, 0.5])


NAN = float("nan")


@pytest.mark.parametrize(
    ("reported", "read", "text"),
    [
        (
            [50.0, 0.0],
            [0.0, 0.0],
            "it is reported that c1 reads 50.0 kPa (pressures now: c1 0.0 kPa, c2 0.0 kPa)",
        ),
        (
            [0.0, -8.0],
            [0.0, 0.0],
            "it is reported that c2 reads -8.0 kPa (pressures now: c1 0.0 kPa, c2 0.0 kPa)",
        ),
        ([0.0, 0.0], [0.0, 50.0], "c2 reads 50.0 kPa (pressures now: c1 0.0 kPa, c2 50.0 kPa)"),
        ([NAN, NAN], [0.0, 0.0], "it is reported that no chamber gives a reading"),
        (
            [0.0, 0.0],
            [NAN, NAN],
            "no chamber gives a reading (pressures now: c1 nothing (NaN), c2 nothing (NaN))",
        ),
        ([0.0, 0.0], None, "no pressure was measured after it (no pressure was read)"),
    ],
)
def test_a_vent_that_the_readings_do_not_confirm_is_none(
    checked: Any, driver: Driver, reported: list[float], read: list[float] | None, text: str
) -> None:
    """Neither a report of pressure nor one that the readings contradict, or that nothing is read after, is believed."""
    driver.report = VentReport(np.array(reported), 0.1)
    driver.reads = lambda: None if read is None else np.array(read)
    with pytest.raises(VentNotConfirmedError) as caught:
        checked.vent(2.0)
    assert str(caught.value).startswith(f"pressure: vent not confirmed: {text}")
    assert str(caught.value).endswith("; relieve the pressure by hand")


def test_a_sensor_that_falls_silent_is_no_missing_sensor(checked: Any, driver: Driver) -> None:
    """A chamber that never had a reading cannot be confirmed and is passed over; one that had must have one now."""
    driver.reads = lambda: np.array([0.0, NAN])
    assert np.isnan(checked.vent(1.0).pressure_kpa[1])
    driver.reads = lambda: np.array([0.0, 0.0])
    checked.samples()
    driver.reads = lambda: np.array([0.0, NAN])
    with pytest.raises(VentNotConfirmedError, match=r"c2 reads nothing \(NaN\)"):
        checked.vent(1.0)


def test_what_is_read_during_a_vent_is_not_lost(checked: Any, driver: Driver) -> None:
    """The readings that confirmed it, and those from before it, come with the next call."""
    checked.vent(1.0)
    assert len(checked.samples()) >= 3


@pytest.mark.parametrize(
    ("report", "text"),
    [
        (None, "Driver.vent() returned None, not a VentReport; correct the driver"),
        ([0.0, 0.0], "Driver.vent() returned a list, not a VentReport; correct the driver"),
        (
            VentReport(np.zeros(1), 0.1),
            "Driver.vent() gave 1 pressures where there are 2; correct the driver",
        ),
        (ValueError("7"), "Driver.vent() raised ValueError: 7"),
    ],
)
def test_a_vent_that_returns_something_else_is_named(
    checked: Any, driver: Driver, report: Any, text: str
) -> None:
    """Which method of which class returned what, and what the chambers read."""
    driver.report = report
    with pytest.raises(VentNotConfirmedError) as caught:
        checked.vent(1.0)
    assert str(caught.value) == (
        f"pressure: {text} (pressures now: c1 0.0 kPa, c2 0.0 kPa); relieve the pressure by hand"
    )


def test_lists_in_place_of_arrays_will_do(checked: Any, driver: Driver) -> None:
    """Whoever writes [0.0, 0.0] means an array."""
    driver.reads = lambda: [0.0, 0.0]
    driver.report = VentReport([0.0, 0.0], 0.1)  # type: ignore[arg-type]
    assert checked.vent(1.0).pressure_kpa.tolist() == [0.0, 0.0]
    assert checked.samples()[0].pressure_kpa.tolist() == [0.0, 0.0]


@pytest.mark.parametrize(
    ("change", "text"),
    [
        ({"answer": ()}, ""),
        ({"answer": 7}, "samples() returned an int, not a list of PressureSample; correct the driver"),
        ({"answer": [1.0]}, "samples() returned a float, not a PressureSample; correct the driver"),
        ({"reads": lambda: np.zeros(3)}, "samples() gave 3 pressures where there are 2; correct the driver"),
        ({"reads": lambda: ["x", 1]}, "samples() gave pressures that are no numbers; correct the driver"),
        (
            {"ahead_s": 60.0},
            "samples() gave a time that is 60 s ahead of labrig's clock; take times from the clock that it is given",
        ),
        ({"ahead_s": NAN}, "samples() gave the time nan; take times from the clock that it is given"),
    ],
)
def test_samples_are_what_they_should_be(checked: Any, driver: Driver, change: Any, text: str) -> None:
    """Numbers of the right count, on a clock that is not ahead; anything else is one line."""
    for name, value in change.items():
        setattr(driver, name, value)
    if not text:
        assert checked.samples() == []
        return
    with pytest.raises(DeviceError) as caught:
        checked.samples()
    assert str(caught.value) == f"pressure: Driver.{text}"


def test_whatever_a_driver_raises_names_the_method(checked: Any) -> None:
    """An exception that no driver should raise becomes one line; closing never fails."""
    with pytest.raises(DeviceError, match=r"^pressure: Driver.set\(\) raised KeyError: 'register 7'$"):
        checked.set(np.zeros(2))
    checked.close()


def test_a_dead_link_is_opened_anew_at_the_first_vent_that_fails(checked: Any, driver: Driver) -> None:
    """The next attempt has a new connection; one that answers, with pressure in it, is left as it is."""
    driver.reads = lambda: np.array([50.0, 0.0])
    with pytest.raises(VentNotConfirmedError):
        checked.vent(0.5)
    assert driver.connected == 0
    driver.report = DeviceError("pressure: it says no")
    later_s = driver.clock.now_s() + 0.1  # it measures now and then
    driver.reads = lambda: np.zeros(2) if driver.clock.now_s() >= later_s else None
    with pytest.raises(VentNotConfirmedError, match="it says no"):
        checked.vent(0.5)
    assert driver.connected == 0
    driver.reads = lambda: None
    driver.report = DeviceError("pressure: the link is lost")
    with pytest.raises(VentNotConfirmedError, match="the link is lost"):
        checked.vent(0.5)
    assert driver.connected == 1


@pytest.mark.parametrize(
    ("position", "status", "ahead_s", "text"),
    [
        (np.zeros((2, 3)), np.zeros(3), 0.0, "gave 2 x 3 coordinates where there are 3 x 3"),
        (np.zeros((3, 3)), np.zeros(2), 0.0, "gave 2 states of markers where there are 3"),
        (np.zeros((3, 3)), np.zeros(3), 3600.0, "gave a time that is 3600 s ahead of labrig's clock"),
    ],
)
def test_frames_are_what_they_should_be(
    write_rig: Callable[..., Path],
    monkeypatch: pytest.MonkeyPatch,
    position: Any,
    status: Any,
    ahead_s: float,
    text: str,
) -> None:
    """One position and one state for each marker, on a clock that is not ahead."""
    clock = SimulatedClock()

    class Camera:
        marker_names = ("m1", "m2", "m3")

        def frames(self) -> list[MarkerFrame]:
            return [MarkerFrame(clock.now_s() + ahead_s, 1, position, status)]

    monkeypatch.setattr("labrig.rig._factory.own_maker", lambda *_: Camera)
    mocap = {"kind": "python", "file": "x.py", "class": "Camera"}
    rig = load_rig(write_rig(mocap=mocap, markers=["m1", "m2", "m3"]))
    with pytest.raises(DeviceError, match=rf"^mocap: Camera.frames\(\) {text}"):
        device_makers(rig, clock)["mocap"]().frames()


@pytest.mark.parametrize("mode", ["reports", "lies"])
@pytest.mark.parametrize("command", ["run", "vent", "check"])
def test_no_command_believes_a_vent_that_did_not_happen(
    write_rig: Callable[..., Path], tmp_path: Path, mode: str, command: str
) -> None:
    """What a run does through its guard, `labrig rig vent` and `labrig rig check`: none says vented."""
    (tmp_path / "own.py").write_text(DRIVER, encoding="utf-8")
    device = {"kind": "python", "file": str(tmp_path / "own.py"), "class": "Own", "mode": mode}
    config = load_rig(
        write_rig(
            pressure=device, safety={"vent_timeout_s": 0.2, "vent_patience_s": 0.1, "guard_patience_s": 0.1}
        )
    )
    if command == "check":
        findings = check_devices(device_makers(config, SimulatedClock()), 0.1, 0.2)
        assert [finding.state for finding in findings if finding.what == "vent"] == ["bad"]
        return
    with pytest.raises(
        VentNotConfirmedError, match=r"c1 50.0 kPa, c2 35.0 kPa\); relieve the pressure by hand"
    ):
        vent_now(config) if command == "vent" else connect(config, RealClock()).__exit__(None, None, None)
