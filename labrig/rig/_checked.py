"""What a driver says is held against what it was asked for, before the rest of labrig relies on it.

A driver may be anybody's. A vent is believed only when readings that came after it say so, too; what a method
returns must be what the protocol asks for; and no measurement may come from the future.
"""

import contextlib
import math
from collections.abc import Sequence
from typing import Any

import numpy as np

from labrig._errors import LabrigError
from labrig._own_code import FAULTS
from labrig.arrays import Floats
from labrig.rig._config import RigConfig
from labrig.rig._last_words import BY_HAND, by_hand
from labrig.rig._markers import order_in
from labrig_drivers import (
    Clock,
    DeviceError,
    Identity,
    MarkerFrame,
    MarkerStatus,
    PressureSample,
    Scan,
    VentNotConfirmedError,
    VentReport,
)

AHEAD_S = 1.0
"""How far ahead of labrig's clock a measurement may be dated, s; what is farther comes from another clock."""

_TICK_S = 0.02
_FRESH_S = 1.0
_MOMENT_S = 0.3
"""A driver whose vent failed has so long to show, by a reading, that its link is well, s."""


class _Checked:
    """A device whose every failure is a `DeviceError` that names its class and method."""

    def __init__(self, device: Any, name: str, clock: Clock) -> None:
        self._device, self.name, self._clock = device, name, clock
        self._called = getattr(device, "called", type(device).__name__)

    def __getattr__(self, attribute: str) -> Any:
        if attribute == "_device":  # a copy that is not filled yet
            raise AttributeError(attribute)
        return getattr(self._device, attribute)

    def connect(self) -> None:
        """Open the link."""
        self._call("connect")

    def identify(self) -> Identity:
        """Ask the device who it is."""
        return self._expect(self._call("identify"), Identity, "identify")

    def close(self) -> None:
        """Release the link; never raises."""
        with contextlib.suppress(*FAULTS):
            self._device.close()

    def _call(self, method: str, *arguments: Any) -> Any:
        try:
            return getattr(self._device, method)(*arguments)
        except (DeviceError, LabrigError):
            raise
        except FAULTS as error:
            raise self._wrong(method, f"raised {type(error).__name__}: {error}") from error

    def _wrong(self, method: str, what: str) -> DeviceError:
        return DeviceError(f"{self.name}: {self._called}.{method}() {what}")

    def _expect(self, value: Any, kind: type[Any], method: str) -> Any:
        if not isinstance(value, kind):
            raise self._wrong(method, f"returned {_kind(value)}, not {_article(kind)}; correct the driver")
        return value

    def _list(self, method: str, kind: type[Any]) -> Sequence[Any]:
        found = self._call(method)
        if not isinstance(found, list | tuple):
            raise self._wrong(
                method, f"returned {_kind(found)}, not a list of {kind.__name__}; correct the driver"
            )
        return [self._expect(each, kind, method) for each in found]

    def _array(self, values: Any, shape: tuple[int, ...], method: str, what: str) -> Floats:
        try:
            array = np.asarray(values, float)
        except (TypeError, ValueError):
            raise self._wrong(method, f"gave {what} that are no numbers; correct the driver") from None
        if array.shape != shape:
            got, wanted = " x ".join(map(str, array.shape)) or "one", " x ".join(map(str, shape))
            raise self._wrong(method, f"gave {got} {what} where there are {wanted}; correct the driver")
        return array

    def _check_time(self, time_s: Any, method: str) -> None:
        if not isinstance(time_s, int | float | np.number) or not math.isfinite(time_s):
            raise self._wrong(method, f"gave the time {time_s!r}; take times from the clock that it is given")
        ahead_s = time_s - self._clock.now_s()
        if ahead_s > AHEAD_S:
            raise self._wrong(
                method,
                f"gave a time that is {ahead_s:.4g} s ahead of labrig's clock; "
                "take times from the clock that it is given",
            )


class CheckedPressure(_Checked):
    """A pressure controller whose vent is confirmed by readings that come after it, whatever the driver says."""

    def __init__(self, device: Any, config: RigConfig, name: str, clock: Clock) -> None:
        super().__init__(device, name, clock)
        self.channels = config.channels
        self._limit_kpa = config.safety.vented_kpa
        self._fresh_s = max(_FRESH_S, config.safety.stale_pressure_s)
        self._kept: list[PressureSample] = []
        self._measures = np.zeros(len(config.chambers), bool)
        self._last: tuple[float, Floats] | None = None
        self._taken = 0

    def set(self, pressure_kpa: Floats) -> None:
        """Command set-points."""
        self._call("set", pressure_kpa)

    def samples(self) -> list[PressureSample]:
        """Every measurement since the last call; raises `DeviceError` for one of a wrong shape or a later time."""
        self._take()
        kept, self._kept = self._kept, []
        for sample in kept:
            self._check_time(sample.time_s, "samples")
        return kept

    def vent(self, timeout_s: float = 10.0) -> VentReport:
        """Vent, and confirm it by the report and by readings that come afterwards.

        Raises `VentNotConfirmedError` with what every chamber reads. Where nothing is read at all the link is opened
        anew before, for the next attempt.
        """
        began_s = self._clock.now_s()
        with contextlib.suppress(DeviceError, LabrigError):
            self._take()
        before = self._taken
        try:
            self._check_report(self._call("vent", timeout_s))
            pressure_kpa = self._fresh(began_s + timeout_s)
        except (DeviceError, LabrigError) as error:
            raise self._unconfirmed(error, self._taken > before) from error
        return VentReport(pressure_kpa, self._clock.now_s() - began_s)

    def _take(self) -> int:
        """Keep what is new for whoever asks next; returns how much that was."""
        found = self._list("samples", PressureSample)
        for sample in found:
            pressure_kpa = self._array(sample.pressure_kpa, (len(self.channels),), "samples", "pressures")
            self._measures |= np.isfinite(pressure_kpa)
            self._last = self._clock.now_s(), pressure_kpa
            self._kept.append(PressureSample(sample.time_s, pressure_kpa))
        self._taken += len(found)
        return len(found)

    def _check_report(self, report: Any) -> None:
        self._expect(report, VentReport, "vent")
        pressure_kpa = self._array(report.pressure_kpa, (len(self.channels),), "vent", "pressures")
        if up := self._still_up(pressure_kpa):
            raise DeviceError(f"{self.name}: vent not confirmed: it is reported that {up}")

    def _fresh(self, end_s: float) -> Floats:
        """What the chambers read after the driver called them vented."""
        self._take()  # from before
        silent_s = self._clock.now_s() + self._fresh_s
        heard = 0
        while True:
            heard += self._take()
            if heard and self._last is not None and not self._still_up(self._last[1]):
                return self._last[1]
            if self._clock.now_s() >= (max(end_s, silent_s) if heard else silent_s):
                break
            self._clock.sleep(_TICK_S)
        if not heard or self._last is None:
            raise DeviceError(f"{self.name}: vent not confirmed: no pressure was measured after it")
        raise DeviceError(f"{self.name}: vent not confirmed: {self._still_up(self._last[1])}")

    def _still_up(self, pressure_kpa: Floats) -> str:
        """The chambers that are not vented, in words. One that never had a reading has no sensor."""
        if not np.isfinite(pressure_kpa).any():
            return "no chamber gives a reading"
        blind = ~np.isfinite(pressure_kpa) & ~self._measures
        calm = blind | (np.abs(pressure_kpa) <= self._limit_kpa)
        return ", ".join(
            f"{channel.name} reads {_text(value)}"
            for channel, value, well in zip(self.channels, pressure_kpa, calm, strict=True)
            if not well
        )

    def _unconfirmed(self, error: Exception, heard: bool) -> VentNotConfirmedError:
        with contextlib.suppress(DeviceError, LabrigError):
            end_s = self._clock.now_s() + _MOMENT_S
            while not (heard := self._take() > 0 or heard) and self._clock.now_s() < end_s:
                self._clock.sleep(_TICK_S)
        if not heard:
            with contextlib.suppress(Exception):  # the link may be gone; opening it again does no harm
                self._device.connect()
        text = str(error).removesuffix(f"; {BY_HAND}")
        return VentNotConfirmedError(by_hand(f"{text} ({self._reads(heard)})"))

    def _reads(self, now: bool) -> str:
        """What every chamber reads, or read last."""
        if self._last is None:
            return "no pressure was read"
        time_s, pressure_kpa = self._last
        values = ", ".join(
            f"{channel.name} {_text(value)}"
            for channel, value in zip(self.channels, pressure_kpa, strict=True)
        )
        if now:
            return f"pressures now: {values}"
        return f"pressures {self._clock.now_s() - time_s:.0f} s ago: {values}"


class CheckedMocap(_Checked):
    """A motion capture whose frames have one position for each marker that is seen, and a time that is not ahead.

    Its markers come in the order of rig.yaml, whatever the driver's own order is. What a driver says of a marker
    that it does not see, such as where it was last, is no measurement; one without a position is not seen.
    """

    def __init__(self, device: Any, config: RigConfig, name: str, clock: Clock) -> None:
        super().__init__(device, name, clock)
        self._wanted = config.markers
        self._order: Sequence[int] | None = None

    @property
    def marker_names(self) -> Sequence[str]:
        """The markers, in the order of the frames."""
        return self._wanted or self._device.marker_names

    def connect(self) -> None:
        """Open the link, and find each marker of rig.yaml among the driver's own."""
        super().connect()
        own = tuple(map(str, getattr(self._device, "marker_names", None) or self._wanted))
        try:
            if not own:
                raise ValueError("is empty, and rig.yaml names no markers")
            self._order = order_in(own, self._wanted)
        except ValueError as error:
            raise DeviceError(f"{self.name}: {self._called}.marker_names {error}") from None

    def frames(self) -> list[MarkerFrame]:
        """Every frame since the last call."""
        return [self._checked(frame) for frame in self._list("frames", MarkerFrame)]

    def _checked(self, frame: MarkerFrame) -> MarkerFrame:
        self._check_time(frame.time_s, "frames")
        count = len(getattr(self._device, "marker_names", None) or self._wanted)
        position_mm = self._array(frame.position_mm, (count, 3), "frames", "coordinates")
        status = self._array(frame.status, (count,), "frames", "states of markers").astype(np.int8)
        if self._order is not None:
            position_mm, status = position_mm[self._order], status[self._order]
        known = np.isfinite(position_mm).all(axis=1)
        status[(status == MarkerStatus.SEEN) & ~known] = MarkerStatus.OCCLUDED
        position_mm = np.where((status == MarkerStatus.SEEN)[:, None], position_mm, np.nan)
        return MarkerFrame(float(frame.time_s), frame.number, position_mm, status)


class CheckedScanner(_Checked):
    """A scanner whose scans are scans."""

    def scan(self, timeout_s: float = 120.0) -> Scan:
        """Wait for the next complete scan."""
        return self._expect(self._call("scan", timeout_s), Scan, "scan")


def _text(value: float) -> str:
    return f"{round(float(value), 1) + 0.0:.1f} kPa" if math.isfinite(value) else "nothing (NaN)"


def _kind(value: Any) -> str:
    return "None" if value is None else _article(type(value))


def _article(kind: type[Any]) -> str:
    name = kind.__name__
    return f"{'an' if name[0] in 'aeiouAEIOU' else 'a'} {name}"
