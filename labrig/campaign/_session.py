"""One session of a run: polls the devices, logs what they say, and notices when the rig is no longer safe."""

import math
import threading
from collections.abc import Callable
from dataclasses import dataclass, field, replace
from pathlib import Path

import numpy as np

from labrig._errors import LabrigError
from labrig.arrays import Floats
from labrig.campaign._observe import Observation
from labrig.campaign._order import Order
from labrig.campaign._signals import SignalGuard
from labrig.campaign._steps import Ask, Completed, Settle, Step
from labrig.log import LogWriter, Topic
from labrig.rig import PressureWatch, Rig, Silence, dated
from labrig.run_contents import Advice, StepResult
from labrig_drivers import DeviceError, MarkerFrame, MarkerStatus, PressureSample, frames_missing

_LOG_THERE_S = 1.0
_MANY_LOST = 0.1
"""The share of a recording's frames that may be lost unsaid."""

_SETTLING_S = 2.0
"""How much of a wait is kept: at its end one looks at its last moments."""

TICK_S = 0.05
"""How often devices are asked what is new while the run waits, s."""

SEGMENT_BYTES = 512 * 1024 * 1024
SEGMENT_STEPS = 10_000
"""A segment that has grown to this is closed at the end of a step, and the next one begun: the index of a file is
kept in memory until the file is closed."""


class Control:
    """Asks a run to pause, go on or end, from any thread; a pause begins before the next actuation, vented.

    `attended` says that somebody can end a pause; without, a run that would pause for a fault ends instead.
    """

    def __init__(self, *, attended: bool = False) -> None:
        self._paused = threading.Event()
        self.attended = attended
        self.ended: str | None = None

    @property
    def paused(self) -> bool:
        """Whether a pause was asked for."""
        return self._paused.is_set()

    def pause(self) -> None:
        """Finish the hold that is being recorded, then vent and wait."""
        self._paused.set()

    def go_on(self) -> None:
        """End the pause."""
        self._paused.clear()

    def end(self, why: str) -> None:
        """End the run at once, vented; `why` is what it says of it."""
        self.ended = self.ended or why

    def toggle(self) -> None:
        """Pause, or go on."""
        if self.paused:
            self.go_on()
        else:
            self.pause()


class LogGoneError(LabrigError):
    """The file that the run is logged to is no longer there."""


@dataclass
class Held:
    """Frames and samples since the present step began; during a Settle those of its last moments alone."""

    frames: list[MarkerFrame] = field(default_factory=list)
    samples: list[PressureSample] = field(default_factory=list)

    def forget_before(self, time_s: float) -> None:
        """Let go of what is older, but for the last of each: hours of it would fill the memory."""
        for measured in (self.frames, self.samples):
            old = next((at for at, each in enumerate(measured) if each.time_s >= time_s), len(measured) - 1)
            del measured[: max(old, 0)]


class Session:
    """The rig, the log and the observers of one run, between which the steps move data."""

    def __init__(
        self,
        rig: Rig,
        open_log: Callable[[], LogWriter] | None,
        observation: Observation,
        signals: SignalGuard,
        control: Control,
        tick_s: float = TICK_S,
    ) -> None:
        self.rig, self.clock = rig, rig.clock
        self._open_log = open_log
        self.log = open_log() if open_log is not None else None
        self.observation, self.signals, self.control = observation, signals, control
        self.tick_s = tick_s
        self.commanded_kpa: Floats = np.zeros(len(rig.config.chambers))
        self.held, self._settles = Held(), False
        self._steps_in_segment = 0
        now_s = self.clock.now_s()
        self._log_seen_s = now_s
        self._order, self._frame_order = Order(), Order()
        self._pressures = PressureWatch(rig.config, rig.pressure.name, now_s)
        self._frames, self._seen = Silence(now_s), Silence(now_s)
        self._said_lost = False
        self.on_tick: Callable[[], None] = _nothing
        self.advise: Callable[[Ask], Advice] = _no_advice

    def now_s(self) -> float:
        """The time now on the run's clock."""
        return self.clock.now_s()

    def wait_until(self, time_s: float) -> None:
        """Poll the devices until `time_s`, and once more then."""
        while True:
            self.poll()
            remaining_s = time_s - self.clock.now_s()
            if remaining_s <= 0:
                return
            self.clock.sleep(min(self.tick_s, remaining_s))

    def ramp_tick_s(self, target_kpa: Floats) -> float:
        """How often set-points are sent on the way to a target, s."""
        return self.tick_s

    def wait_for_frames(self) -> None:
        """Poll until the cameras look again; `poll` raises `DeviceError` when that takes too long."""
        before = len(self.held.frames)
        while not any(map(is_alive, self.held.frames[before:])):
            self.clock.sleep(self.tick_s)
            self.poll()

    def poll(self) -> None:
        """Take in and log what the devices have; raises `DeviceError` when the rig is not safe to go on with."""
        self.signals.check(self.control.ended)
        with self.signals.shield():
            samples = self._order.of(self.rig.pressure.samples())
            frames = self._frame_order.of(self.rig.mocap.frames()) if self.rig.mocap is not None else []
            self.held.samples += samples
            self.held.frames += [replace(frame, position_mm=_as_logged(frame)) for frame in frames]
            if self._settles:
                self.held.forget_before(self.clock.now_s() - _SETTLING_S)
            self._write(samples, frames)
        self._hear(samples, frames)
        for sample in samples:
            self.observation.tell("sample", sample)
        for frame in frames:
            self.observation.tell("frame", frame)
        self.on_tick()
        self._check(samples)
        self._check_log()

    def _hear(self, samples: list[PressureSample], frames: list[MarkerFrame]) -> None:
        now_s = self.clock.now_s()
        for missing in self._pressures.hear(samples, now_s):
            self.event(f"no reading (NaN) from {missing}", "WARNING")
        if any(is_alive(frame) for frame in frames):
            self._frames.hear(frames[-1].time_s, now_s)
        if any((frame.status == MarkerStatus.SEEN).any() or not frame.status.size for frame in frames):
            self._seen.hear(now_s, now_s)

    def _write(self, samples: list[PressureSample], frames: list[MarkerFrame]) -> None:
        if self.log is None:
            return
        for sample in samples:
            self.log.measured(sample)
        for frame in frames:
            self.log.frame(frame)

    def _check(self, samples: list[PressureSample]) -> None:
        now_s = self.clock.now_s()
        self._pressures.check(samples, now_s)
        if self.rig.mocap is None:
            return
        limit_s, name = self.rig.config.safety.lost_mocap_s, self.rig.mocap.name
        silent_s = self._frames.lasts_s(now_s)
        if silent_s > limit_s:
            what = dated(silent_s) if self._frames.behind(now_s) else f"no frame for {silent_s:.0f} s"
            raise DeviceError(f"{name}: {what} (the limit is {limit_s:g} s); check its stream")
        unseen_s = self._seen.lasts_s(now_s)
        if unseen_s > limit_s:
            raise DeviceError(
                f"{name}: frames come, and no marker was seen for {unseen_s:.0f} s (the limit is {limit_s:g} s); look "
                "at the cameras and the light"
            )

    def last_read(self) -> str:
        """What the chambers read last, in brackets; empty before anything was read."""
        if (latest := self._pressures.latest) is None:
            return ""
        chambers = zip(self.rig.config.chambers, latest.pressure_kpa, strict=True)
        values = ", ".join(f"{chamber.name} {value:.1f} kPa" for chamber, value in chambers)
        return f" (pressures before it: {values})"

    def _check_log(self) -> None:
        """A folder that somebody deletes does not stop the writing: it must be looked for."""
        if self.log is None or self.clock.now_s() - self._log_seen_s < _LOG_THERE_S:
            return
        self._log_seen_s = self.clock.now_s()
        if self.log.gone:
            self._log_seen_s = math.inf  # said once; what comes now is the vent and the end
            raise LogGoneError(f"{self.log.path} was deleted or moved while the run went on")

    def count_lost(self, frames: list[MarkerFrame]) -> int:
        """How many frames of a recording did not arrive; where they are many that is said, once."""
        lost = frames_missing(frames)
        if lost > _MANY_LOST * (len(frames) + lost) and not self._said_lost:
            self._said_lost = True
            self.event(
                f"{lost} of {len(frames) + lost} frames were lost while recording; look at the network and at what "
                "else this computer does (said once; the log counts them in every recording)",
                "WARNING",
            )
        return lost

    def forget_silence(self) -> None:
        """Begin the staleness checks anew, after something that did not poll."""
        for watch in (self._pressures, self._frames, self._seen):
            watch.forget(self.clock.now_s())

    def command(self, target_kpa: Floats, reason: str) -> None:
        """Send a set-point and log it as one of an actuation's."""
        now_s = self.clock.now_s()
        with self.signals.shield():
            self.rig.pressure.set(target_kpa)
        self.commanded_kpa = np.array(target_kpa, float)
        self.log_command(now_s, target_kpa, event=False, reason=reason)

    def log_command(self, time_s: float, setpoint_kpa: Floats, *, event: bool, reason: str) -> None:
        """Log what was commanded."""
        if self.log is not None:
            with self.signals.shield():
                self.log.command(time_s, setpoint_kpa, event=event, reason=reason)
        self.observation.tell("commanded", time_s, tuple(float(value) for value in setpoint_kpa))

    def event(self, text: str, level: str = "INFO") -> None:
        """A line for people, in the log and for the observers."""
        if self.log is not None:
            with self.signals.shield():
                self.log.event(self.now_s(), text, level)
        self.observation.tell("event", self.now_s(), text, level)

    def step_message(self, completed: Completed, state: str, result: StepResult | None = None) -> None:
        """Log a step's STARTED, DONE or FAILED; DONE makes everything so far durable."""
        import json

        from labrig_schema import step_pb2

        if self.log is None:
            return
        with self.signals.shield():
            self.log.write(
                Topic.STEP,
                self.now_s(),
                index=completed.index,
                kind=completed.step.kind,
                state=step_pb2.Step.State.Value(state),
                step_json=json.dumps(completed.step.to_dict()),
                result_json=json.dumps(result) if result is not None else "",
                started_s=completed.started_s,
                ended_s=completed.ended_s,
                wall_s=self.clock.wall_s(),
            )
            if state == "DONE":
                self.log.step_done()
                self._rotate()

    def _rotate(self) -> None:
        if self.log is None or self._open_log is None:
            return
        self._steps_in_segment += 1
        if self.log.size_bytes() > SEGMENT_BYTES or self._steps_in_segment >= SEGMENT_STEPS:
            self.log.close()
            self.log = self._open_log()
            self._steps_in_segment = 0

    def begin_step(self, step: Step, index: int) -> None:
        """Forget what arrived before, and say that a step begins."""
        self.held, self._settles = Held(), isinstance(step, Settle)
        self.observation.tell("step_started", index, step)

    @property
    def folder(self) -> Path | None:
        """The run's folder; None in a dry run."""
        return self.log.path.parent if self.log is not None else None


def _nothing() -> None:
    return


def _no_advice(_ask: Ask) -> Advice:
    return {}


def is_alive(frame: MarkerFrame) -> bool:
    """Whether the cameras look at all: some marker is seen or known to be hidden, not all of them stale."""
    return not frame.status.size or bool(frame.status.min() < MarkerStatus.STALE)


def _as_logged(frame: MarkerFrame) -> Floats:
    """The positions with the precision of the log, so that a replay gives back exactly these."""
    return np.asarray(frame.position_mm, np.float32).astype(np.float64)
