"""A device that says nothing of use is silent, whatever arrives and however it is dated; no step waits for ever."""

from collections.abc import Callable
from dataclasses import replace
from pathlib import Path
from typing import Any

import numpy as np
import pytest

from labrig import LabrigError
from labrig.campaign import (
    Actuate,
    Procedure,
    Record,
    Recording,
    RigInfo,
    Scan,
    Settle,
    Step,
    Steps,
    dry_run,
    read_completed,
    run,
)
from labrig.log import summarise
from labrig_drivers import DeviceError, MarkerStatus


class Hold(Procedure):
    """Under pressure for half a minute."""

    def steps(self, rig: RigInfo) -> Steps:
        """Up, and a long hold with one recording."""
        yield Actuate((40.0, 30.0))
        yield Settle(20.0)
        yield Record(1.0)
        yield Settle(10.0)


class Night(Procedure):
    """Under pressure for a minute."""

    def steps(self, rig: RigInfo) -> Steps:
        """Up, and two recordings on the way."""
        yield Actuate((40.0, 30.0))
        for _ in range(2):
            yield Settle(30.0)
            yield Record(1.0)


@pytest.fixture
def meddle(fake: Any, monkeypatch: pytest.MonkeyPatch) -> Callable[..., None]:
    """Change what a device's method returns while the chambers are under pressure, for so long."""

    def change(device: str, method: str, how: Callable[[Any], Any], for_s: float = np.inf) -> None:
        driver = getattr(fake, device)._device
        original, began_s = getattr(driver, method), []

        def meddled() -> list[Any]:
            found, now_s = original(), fake.clock.now_s()
            if fake.pressure_kpa.max() < 20.0:
                return found
            began_s.append(now_s)
            return [how(each) for each in found] if now_s - began_s[0] <= for_s else found

        monkeypatch.setattr(driver, method, meddled)

    return change


def _nan(chambers: slice) -> Callable[[Any], Any]:
    def blind(sample: Any) -> Any:
        pressure_kpa = sample.pressure_kpa.copy()
        pressure_kpa[chambers] = np.nan
        return replace(sample, pressure_kpa=pressure_kpa)

    return blind


def _later(by_s: float) -> Callable[[Any], Any]:
    return lambda each: replace(each, time_s=each.time_s + by_s)


@pytest.mark.parametrize(("chambers", "names"), [(slice(2), "c1, c2"), (slice(1, 2), "c2")])
def test_readings_that_are_nan_end_the_run(
    fake: Any, meddle: Any, tmp_path: Path, chambers: slice, names: str
) -> None:
    """A chamber that had a reading and has none for a second: as if nothing was measured."""
    meddle("pressure", "samples", _nan(chambers))
    with pytest.raises(DeviceError, match=rf"^pressure: no reading \(NaN\) from {names} for 1\.\d s"):
        run(Hold(), fake.rig, tmp_path / "run", fake.clock)
    assert fake.pressure_kpa.max() <= 0.5
    assert max(command for _, command in fake.pressure.world.commands) == (40.0, 30.0)


def test_frames_without_a_marker_end_the_run(fake: Any, meddle: Any, tmp_path: Path) -> None:
    """With the light out frames go on coming, all markers hidden: a night of such captures is worth nothing."""

    def dark(frame: Any) -> Any:
        hidden = np.full(len(frame.status), MarkerStatus.OCCLUDED, np.int8)
        return replace(frame, position_mm=np.full(frame.position_mm.shape, np.nan), status=hidden)

    meddle("mocap", "frames", dark)
    with pytest.raises(
        DeviceError, match=r"no marker was seen for 3\d s \(the limit is 30 s\); look at the cameras"
    ):
        run(Night(), fake.rig, tmp_path / "run", fake.clock)
    assert fake.pressure_kpa.max() <= 0.5


def test_a_short_gap_is_warned_of(fake: Any, meddle: Any, tmp_path: Path) -> None:
    """Half a second without a reading ends nothing, and is said once."""
    meddle("pressure", "samples", _nan(slice(2)), 0.5)
    run(Hold(), fake.rig, tmp_path / "run", fake.clock)
    told = [text for _, text in summarise(tmp_path / "run").events if "NaN" in text]
    assert told == ["no reading (NaN) from c1, c2"]


@pytest.mark.parametrize(
    ("device", "method", "by_s", "text"),
    [
        (
            "pressure",
            "samples",
            60.0,
            r"pressure: fake_devices.py: FakePressure.samples\(\) gave a time that is (59|60).* s ahead of",
        ),
        (
            "mocap",
            "frames",
            3600.0,
            r"mocap: fake_devices.py: FakeMocap.frames\(\) gave a time that is 3[56]\d\d s ahead of",
        ),
        ("pressure", "samples", -60.0, r"pressure: what it measures is dated 60.* s before labrig's clock"),
        (
            "pressure",
            "samples",
            -8.0,
            r"pressure: what it measures is dated 8.* s before labrig's clock; it comes late, as where this computer "
            r"is too busy to read it \(the limit is 1 s\); check its link",
        ),
        (
            "pressure",
            "samples",
            -1.7e9,
            r"pressure: what it measures is dated .*; its driver takes times from another clock than it was given",
        ),
        ("mocap", "frames", -60.0, r"mocap: what it measures is dated 60.* s before labrig's clock"),
        (
            "mocap",
            "frames",
            -5.0,
            r"mocap: frames arrive, and none is dated .* the last is 5.* s before labrig's",
        ),
        (
            "mocap",
            "frames",
            0.9,
            r"mocap: frames arrive, and none is dated .* the last is 0.* s ahead of labrig's",
        ),
    ],
)
def test_what_is_dated_by_another_clock_ends_the_run(
    fake: Any, meddle: Any, tmp_path: Path, device: str, method: str, by_s: float, text: str
) -> None:
    """Ahead or behind, pressures or frames: the run ends, vented, instead of going on under pressure."""
    meddle(device, method, _later(by_s))

    class Short(Hold):
        def steps(self, rig: RigInfo) -> Steps:
            yield Actuate((40.0, 30.0))
            yield Settle(3.0)
            yield Record(0.2)

    with pytest.raises(DeviceError, match=rf"^{text}"):
        run(Short(), fake.rig, tmp_path / "run", fake.clock)
    assert fake.pressure_kpa.max() <= 0.5
    again = [text for _, text in summarise(tmp_path / "run").events if "recording again" in text]
    assert len(again) == (2 if "frames arrive" in text else 0)


def test_a_camera_too_slow_for_the_recording_ends_the_run(fake: Any, tmp_path: Path) -> None:
    """A frame every three seconds never falls into a recording of one: the chambers are not held for ever."""
    fake.mocap.faults["thinned"] = 60
    end_s = fake.clock.now_s() + 600.0

    def in_time() -> None:
        if fake.clock.now_s() > end_s:
            fake.clock.on_sleep = lambda: None  # the vent may go on
            pytest.fail("it records again and again, under pressure")

    fake.clock.on_sleep = in_time
    with pytest.raises(
        DeviceError, match=r"no frame came in 3 recordings of 1 s in a row: they are 3 s apart"
    ):
        run(Night(), fake.rig, tmp_path / "run", fake.clock)
    assert fake.pressure_kpa.max() <= 0.5


def stale(frame: Any) -> Any:
    """The frame of a stream that is lost: nothing is known of any marker."""
    status = np.full(len(frame.status), MarkerStatus.STALE, np.int8)
    return replace(frame, position_mm=np.full_like(frame.position_mm, np.nan), status=status)


def test_a_recording_of_stale_frames_is_made_again(fake: Any, meddle: Any, tmp_path: Path) -> None:
    """A driver that says of its lost stream that every marker is stale gives no capture of nothing."""

    class Gap(Hold):
        def steps(self, rig: RigInfo) -> Steps:
            yield Actuate((40.0, 30.0))
            yield Settle(3.0)
            yield Record(1.0)

    meddle("mocap", "frames", stale, 4.0)
    run(Gap(), fake.rig, tmp_path / "run", fake.clock)
    recording = read_completed(tmp_path / "run")[-1].result
    assert isinstance(recording, Recording)
    assert recording.seen[0] == 1.0


def test_cameras_that_begin_late_are_waited_for(fake: Any, monkeypatch: Any, tmp_path: Path) -> None:
    """Stale frames before the first look say nothing of the markers: only after 5 s of them a run does not begin."""
    frames, begun_s = fake.mocap.frames, [fake.clock.now_s() + 3.0]

    def late() -> list[Any]:
        return [frame if frame.time_s > begun_s[0] else stale(frame) for frame in frames()]

    monkeypatch.setattr(fake.mocap, "frames", late)
    run(Hold(), fake.rig, tmp_path / "run", fake.clock)
    assert any(isinstance(done.result, Recording) for done in read_completed(tmp_path / "run"))
    begun_s[0] = np.inf
    with pytest.raises(DeviceError, match=r"^mocap: nothing was received within 5 s"):
        run(Hold(), fake.rig, tmp_path / "other", fake.clock)


def test_a_run_begins_with_a_reading_from_after_the_vent(
    make_rig: Callable[..., Any], monkeypatch: pytest.MonkeyPatch, tmp_path: Path
) -> None:
    """Where pressures are read seldom the next one is waited for: what confirmed the vent is too old to begin on."""
    fake = make_rig(safety={"stale_pressure_s": 10.0})
    driver = fake.pressure._device
    driver.faults["creep_kpa"] = 10.0
    often = driver.samples

    def seldom() -> list[Any]:
        since_s = driver.vents[-1] if driver.vents else -np.inf
        return [each for each in often() if not 0.05 < each.time_s - since_s < 2.0]

    monkeypatch.setattr(driver, "samples", seldom)
    with pytest.raises(DeviceError, match=r"c1 reads 10.0 kPa although it is vented"):
        run(Hold(), fake.rig, tmp_path / "run", fake.clock)


@pytest.mark.parametrize(
    "step",
    [
        lambda: Settle(float("inf")),
        lambda: Settle(float("nan")),
        lambda: Record(float("inf")),
        lambda: Scan(float("inf")),
        lambda: Settle(-1),
        lambda: Record("1"),  # type: ignore[arg-type]
    ],
)
def test_no_step_lasts_for_ever(config: Any, step: Callable[[], Step]) -> None:
    """A time without an end, or that is none, is refused before anything moves, in a dry run, too."""

    class Endless(Procedure):
        def steps(self, rig: RigInfo) -> Steps:
            yield Actuate((40.0, 30.0))
            yield step()

    refusal = r"\((duration|timeout)_s=(inf|nan|-1|'1')\): give a time in s that ends, 0 or more$"
    with pytest.raises(LabrigError, match=refusal):
        step()
    with pytest.raises(LabrigError, match=refusal):
        dry_run(Endless(), config)


@pytest.mark.parametrize("given", [{"c1": 20}, 20, ["a", "b"]])
def test_a_set_point_that_is_none_says_how_one_is_written(given: Any) -> None:
    """One line, for a person who writes a procedure."""
    with pytest.raises(
        LabrigError, match=r"^Actuate\(.*\): give numbers in kPa .*; rig.setpoint\(c1=30\) makes"
    ):
        Actuate(given)
