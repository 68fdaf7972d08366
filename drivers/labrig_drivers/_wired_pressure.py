"""What every pressure controller on a wire shares: limits, slew, trips, and a vent that is confirmed.

The wire itself (`PressureWire`) is a small class for each kind of device; one thread owns it. The devices
that it speaks to have neither limits nor a watchdog of their own that one could rely on.
"""

import queue
import threading
import time
from collections import deque
from collections.abc import Callable, Sequence
from concurrent.futures import Future
from concurrent.futures import TimeoutError as FutureTimeoutError
from dataclasses import dataclass
from typing import Any

import numpy as np
from numpy.typing import NDArray

from labrig_drivers._clock import Clock
from labrig_drivers._pressure_wire import PressureWire, WireError
from labrig_drivers._protocols import (
    Channel,
    DeviceError,
    Identity,
    PressureSample,
    VentNotConfirmedError,
    VentReport,
)
from labrig_drivers._recording import Recorder
from labrig_drivers._transport import LinkError

POLL_S = 0.02
CALM_SAMPLES = 3
OVER_SAMPLES = 3
LEAVE_S = 0.5  # after a failed start, for the thread to end in


@dataclass(frozen=True)
class PressureOptions:
    """Limits of trust: times in s, pressures in kPa.

    Without a measurement for `stale_after_s`, or with one more than `over_kpa` above a channel's highest
    (below its lowest) limit `OVER_SAMPLES` times in a row, the device is stopped and refuses set-points
    until a vent is confirmed: every channel within `vent_below_kpa` of ambient `CALM_SAMPLES` times. A channel
    that never gave a finite reading has no sensor, and is not waited for, as long as another one has.
    """

    stale_after_s: float = 1.0
    over_kpa: float = 10.0
    vent_below_kpa: float = 3.0
    call_s: float = 8.0
    open_s: float = 12.0
    ramp_hz: float = 20.0
    max_samples: int = 65536


class WiredPressure:
    """A `PressureController` over a `PressureWire`.

    Set-points approach what was asked for at each channel's `slew_kpa_s`; a vent does not wait for that.
    `connect` leaves every set-point at ambient.
    """

    def __init__(
        self,
        name: str,
        kind: str,
        channels: Sequence[Channel],
        clock: Clock,
        wire: PressureWire,
        options: PressureOptions,
        check: Callable[[NDArray[np.float64]], str | None] = lambda _: None,
        recorder: Recorder | None = None,
    ) -> None:
        self.name = name
        self.kind = kind
        self.channels = tuple(channels)
        self.dropped = 0
        self._clock = clock
        self._wire = wire
        self._options = options
        self._check = check
        self._recorder = recorder
        count = len(self.channels)
        self._low = np.array([channel.min_kpa for channel in self.channels])
        self._high = np.array([channel.max_kpa for channel in self.channels])
        self._step_kpa = np.array([channel.slew_kpa_s for channel in self.channels]) / options.ramp_hz
        self._target = np.zeros(count)
        self._commanded = np.zeros(count)
        self._samples: deque[PressureSample] = deque(maxlen=options.max_samples)
        self._requests: queue.SimpleQueue[tuple[Callable[[], Any], Future]] = queue.SimpleQueue()
        self._thread: threading.Thread | None = None
        self._left: threading.Thread | None = None
        self._stopping = threading.Event()
        self._open = False
        self._venting = False
        self._problem: str | None = None
        self._latest: NDArray[np.float64] | None = None
        self._measures = np.zeros(count, bool)
        self._heard_at = 0.0
        self._stepped_at = 0.0
        self._calm = 0
        self._over = 0

    def connect(self) -> None:
        """Open the link; set-points are at ambient afterwards and measurements come in.

        Raises `DeviceError` after `open_s`, and while an earlier call still hangs: that one holds the wire.
        """
        if self._thread is None:
            if self._hangs():
                raise DeviceError(f"{self.name}: {self._no_link()}")
            self._stopping.clear()
            self._thread = threading.Thread(target=self._run, name=f"{self.name}-wire", daemon=True)
            self._thread.start()
        if self._open and self._problem is None:
            return
        try:
            self._request(self._reopen, self._options.open_s)
        except DeviceError:
            self._end(LEAVE_S)
            raise

    def identify(self) -> Identity:
        """Ask the device who it is."""
        description, details = self._request(self._wire.identify)
        return Identity(self.name, self.kind, description, details)

    def set(self, pressure_kpa: NDArray[np.float64]) -> None:
        """Command set-points, kPa, (C,). Outside the limits nothing moves."""
        target = np.array(pressure_kpa, float)
        self._refuse_bad(target)
        self._raise_problem()
        self._request(lambda: self._aim(target))

    def samples(self) -> list[PressureSample]:
        """Every measurement since the last call, oldest first; at most `max_samples` are kept."""
        if self._thread is None:
            raise DeviceError(f"{self.name}: {self._no_link()}")
        samples: list[PressureSample] = []
        while self._samples:
            samples.append(self._samples.popleft())
        if not samples:
            self._raise_problem()
        return samples

    def vent(self, timeout_s: float = 10.0) -> VentReport:
        """Bring every channel to ambient, at once, and confirm it; tries a lost link again until then."""
        began = time.monotonic()
        if self._thread is None:
            raise VentNotConfirmedError(f"{self.name}: vent not confirmed: {self._no_link()}")
        trouble = ""
        stopped = False
        asked_at = float("-inf")
        while (now := time.monotonic()) - began < timeout_s:
            if now - asked_at > 1.0:
                asked_at = now
                left_s = max(0.1, timeout_s - (now - began))
                try:
                    self._request(self._stop if stopped else self._begin_vent, left_s)
                    stopped, trouble = True, ""
                except DeviceError as error:
                    stopped, trouble = False, str(error).removeprefix(f"{self.name}: ")
            if self._calm >= CALM_SAMPLES and self._latest is not None and not trouble:
                self._venting = False
                self._problem = None
                return VentReport(self._latest.copy(), time.monotonic() - began)
            time.sleep(0.005)
        raise VentNotConfirmedError(
            f"{self.name}: vent not confirmed within {timeout_s:g} s: {trouble or self._still_up()}; "
            "relieve the pressure by hand"
        )

    def close(self) -> None:
        """Leave the device at rest and release the link; never raises.

        What does not come back in `call_s` is left behind: should it come back later, it does this then.
        """
        self._end(self._options.call_s)
        if self._recorder is not None:
            self._recorder.close()

    def _end(self, wait_s: float) -> None:
        self._stopping.set()
        thread, self._thread = self._thread, None
        if thread is not None:
            self._left = thread
            thread.join(wait_s)

    # Everything below runs in the wire's thread, except where it says otherwise.

    def _run(self) -> None:
        while not self._stopping.is_set():
            self._answer()
            if not self._open:
                self._stopping.wait(POLL_S)
                continue
            try:
                self._ramp()
                for measured in self._wire.poll(POLL_S):
                    self._take(measured)
                self._watch()
            except (LinkError, WireError) as error:
                self._lose(str(error))
            except Exception as error:  # the thread that can vent must not die of anything
                self._lose(f"unexpected {type(error).__name__}: {error}")
        self._wire.close()
        self._open = False
        self._answer(DeviceError(f"{self.name}: closed"))

    def _answer(self, refusal: DeviceError | None = None) -> None:
        while True:
            try:
                call, future = self._requests.get_nowait()
            except queue.Empty:
                return
            if not future.set_running_or_notify_cancel():
                continue
            if refusal is not None:
                future.set_exception(refusal)
                continue
            try:
                future.set_result(call())
            except WireError as error:
                future.set_exception(DeviceError(f"{self.name}: {error}"))
            except LinkError as error:
                self._lose(str(error))
                future.set_exception(DeviceError(f"{self.name}: {error}"))
            except DeviceError as error:
                future.set_exception(error)
            except Exception as error:
                self._lose(f"unexpected {type(error).__name__}: {error}")
                future.set_exception(DeviceError(f"{self.name}: {self._problem}"))

    def _reopen(self) -> None:
        self._wire.close()
        self._open = False
        self._target[:] = self._commanded[:] = 0.0
        self._calm = self._over = 0
        self._latest = None
        try:
            self._wire.open()
        except (LinkError, WireError):
            self._wire.close()
            raise
        self._open = True
        self._venting = False
        self._problem = None
        self._heard_at = time.monotonic()

    def _aim(self, target: NDArray[np.float64]) -> None:
        self._raise_problem()  # it may have come up since the caller looked
        if not self._open:
            raise LinkError("the link is down")
        if self._venting:
            raise DeviceError(f"{self.name}: the last vent is not confirmed; vent again before any set-point")
        self._target = target
        self._ramp()

    def _ramp(self) -> None:
        now = time.monotonic()
        if self._venting or np.array_equal(self._target, self._commanded):
            return
        if now - self._stepped_at < 1.0 / self._options.ramp_hz:
            return
        self._stepped_at = now
        change = np.clip(self._target - self._commanded, -self._step_kpa, self._step_kpa)
        commanded = self._commanded + change
        near = np.abs(self._target - commanded) < 1e-9
        commanded[near] = self._target[near]
        self._wire.write(commanded)
        self._commanded = commanded

    def _begin_vent(self) -> None:
        self._stop()
        for measured in self._wire.poll(0.0):  # from before the device had stopped: confirms nothing
            self._take(measured)
        self._calm = 0

    def _stop(self) -> None:
        self._target = np.zeros(len(self.channels))
        self._commanded = np.zeros(len(self.channels))
        if not self._open:
            self._reopen()
        self._venting = True
        self._wire.stop()

    def _take(self, measured: NDArray[np.float64]) -> None:
        self._heard_at = time.monotonic()
        self._latest = measured
        if len(self._samples) == self._samples.maxlen:
            self.dropped += 1
        self._samples.append(PressureSample(self._clock.now_s(), measured))
        self._measures |= np.isfinite(measured)
        calm = self._measures.any() and not self._is_up(measured).any()
        self._calm = self._calm + 1 if calm else 0
        margin = self._options.over_kpa
        over = bool(np.any((measured > self._high + margin) | (measured < self._low - margin)))
        self._over = self._over + 1 if over else 0

    def _is_up(self, measured: NDArray[np.float64]) -> NDArray[np.bool_]:
        return self._measures & ~(np.abs(measured) < self._options.vent_below_kpa)

    def _watch(self) -> None:
        if self._problem is not None:
            return
        silent_s = time.monotonic() - self._heard_at
        if silent_s > self._options.stale_after_s:
            self._trip(f"no pressure reading for {silent_s:.1f} s")
        elif self._over >= OVER_SAMPLES and self._latest is not None:
            outside = np.maximum(self._latest - self._high, self._low - self._latest)
            worst = int(np.nanargmax(outside))
            channel = self.channels[worst]
            self._trip(
                f"{channel.name} reads {self._latest[worst]:.1f} kPa, its limits are "
                f"{channel.min_kpa:g} to {channel.max_kpa:g} kPa"
            )

    def _trip(self, why: str) -> None:
        self._target[:] = 0.0
        self._commanded[:] = 0.0
        problem = f"{why}; stopped, and no set-point is taken until a vent is confirmed"
        try:
            self._wire.stop()
        except (LinkError, WireError) as error:
            problem = f"{why}; and it could not be stopped: {error}"
        self._problem = problem

    def _lose(self, why: str) -> None:
        self._open = False
        self._target[:] = 0.0
        self._commanded[:] = 0.0
        self._wire.close()
        self._problem = why  # last: who reads it may count on the device being at rest, if it can be reached

    # The caller's thread again.

    def _request(self, call: Callable[[], Any], timeout_s: float | None = None) -> Any:
        if self._thread is None:
            raise DeviceError(f"{self.name}: {self._no_link()}")
        limit_s = self._options.call_s if timeout_s is None else timeout_s
        future: Future = Future()
        self._requests.put((call, future))
        try:
            return future.result(limit_s)
        except FutureTimeoutError:
            future.cancel()
            raise DeviceError(f"{self.name}: did not answer within {limit_s:.2g} s") from None

    def _hangs(self) -> bool:
        return self._left is not None and self._left.is_alive()

    def _no_link(self) -> str:
        if self._hangs():
            return "an earlier call hangs and holds the port; unplug the device and plug it in again"
        return "not connected"

    def _raise_problem(self) -> None:
        problem = self._problem
        if problem is not None:
            raise DeviceError(f"{self.name}: {problem}")

    def _refuse_bad(self, target: NDArray[np.float64]) -> None:
        if target.shape != (len(self.channels),):
            raise DeviceError(f"{self.name}: {target.size} set-points for {len(self.channels)} channels")
        for channel, value in zip(self.channels, target, strict=True):
            if not channel.min_kpa <= value <= channel.max_kpa:  # NaN fails this too
                raise DeviceError(
                    f"{self.name}: {channel.name} set to {value:g} kPa, its limits are "
                    f"{channel.min_kpa:g} to {channel.max_kpa:g} kPa; nothing was moved"
                )
        problem = self._check(target)
        if problem is not None:
            raise DeviceError(f"{self.name}: {problem}")

    def _still_up(self) -> str:
        latest = self._latest
        if latest is None or not self._measures.any():
            return "no pressure reading"
        still = [
            f"{channel.name} reads {value:.1f} kPa"
            for channel, value, up in zip(self.channels, latest, self._is_up(latest), strict=True)
            if up
        ]
        return ", ".join(still) or "the readings stopped"
