"""Runs a procedure on a rig: vented first, logged always, resumed by replay."""

import contextlib
import warnings
from collections.abc import Callable, Sequence
from dataclasses import dataclass, field, replace
from pathlib import Path
from typing import Any

import numpy as np

from labrig._errors import LabrigError
from labrig._seed import whole_seed
from labrig._text import counted
from labrig.campaign._advice import Adviser
from labrig.campaign._attempt import attempt
from labrig.campaign._callback import Callback
from labrig.campaign._ending import reason_of, state_of, vent_for_sure
from labrig.campaign._execute import execute, limit_errors, vent
from labrig.campaign._observe import Observation, Observer, Progress
from labrig.campaign._plan import Plan, dry_run, rig_info
from labrig.campaign._preflight import check_disk, preflight
from labrig.campaign._procedure import Procedure
from labrig.campaign._replay import holds_to_restore, read_completed
from labrig.campaign._runfile import (
    NotResumableError,
    check_resumable,
    check_written,
    run_facts,
    write_run_yaml,
)
from labrig.campaign._scans import keep_sealed
from labrig.campaign._session import Control, LogGoneError, Session
from labrig.campaign._signals import Interrupted, SignalGuard
from labrig.campaign._steps import Actuate, Ask, Completed, Result, Settle, Step
from labrig.campaign._tally import Tally
from labrig.campaign._walk import Walk
from labrig.log import Layout, LogWriter, last_logged_s, read_run_yaml, segment_path, segment_paths
from labrig.rig import Rig, and_vented, not_vented
from labrig.run_contents import Advice
from labrig_drivers import Clock, DeviceError, RealClock, VentReport

_PROGRESS_S = 0.5


@dataclass
class Watching:
    """Who watches a run, who may pause it, and who may change its course; all of it optional."""

    observers: Sequence[Observer] = ()
    control: Control = field(default_factory=Control)
    context: dict[str, Any] = field(default_factory=dict)
    adviser: Adviser | None = None


def run(
    procedure: Procedure,
    rig: Rig,
    folder: str | Path,
    clock: Clock | None = None,
    seed: int = 0,
    progress: Callable[[Progress], None] | None = None,
    watching: Watching | None = None,
) -> Path:
    """Run a procedure on a connected rig and log it to `folder`; returns the folder.

    Every limit of the plan is checked before anything moves. However the run ends, the chambers are vented first,
    and the vent is confirmed by reading; only then does this function return or raise. It does not close the rig.

    Raises `LabrigError` (broken limits, an error in the procedure, a log that cannot be written), `DeviceError`
    (a device failed or the rig is no longer safe), `VentNotConfirmedError` (the chambers may be under pressure),
    `Interrupted` (a signal).
    """
    folder, watching, seed = Path(folder), watching or Watching(), whole_seed(seed)
    rig = rig if clock is None else replace(rig, clock=clock)
    plan = _checked_plan(procedure, rig, seed, watching.adviser)
    folder.mkdir(parents=True, exist_ok=True)
    if segment_paths(folder):
        raise LabrigError(f"{folder} holds a run already; choose another folder, or resume it")
    check_disk(folder, plan.duration_s, len(rig.config.markers))
    facts = run_facts(procedure, rig, seed, plan, watching.context)
    write_run_yaml(folder, facts)
    keep_sealed(rig.config, folder)
    return _Run(procedure, rig, folder, facts, plan, [], watching, progress).go()


def resume(
    procedure: Procedure,
    rig: Rig,
    folder: str | Path,
    clock: Clock | None = None,
    progress: Callable[[Progress], None] | None = None,
    watching: Watching | None = None,
) -> Path:
    """Go on with a run that was interrupted, after its last completed step; returns the folder.

    Raises `LabrigError` when the procedure, its parameters, the rig or its limits are not what they were, or when
    there is nothing left to do; otherwise as `run`.
    """
    folder, watching = Path(folder), watching or Watching()
    rig = rig if clock is None else replace(rig, clock=clock)
    old = read_run_yaml(folder)
    if not old:
        raise NotResumableError(f"cannot resume {folder}: it has no run.yaml that can be read")
    check_written(folder, old)
    seed = int(old.get("seed", 0))
    plan = _checked_plan(procedure, rig, seed, watching.adviser)
    check_resumable(folder, old, run_facts(procedure, rig, seed, plan, {}))
    rig.clock.advance_to(last_logged_s(folder))
    completed = read_completed(folder)
    open_end = procedure.closed_loop or watching.adviser is not None
    if not open_end and len(completed) >= len(plan.steps):
        raise LabrigError(f"{folder} is complete: all {len(completed)} steps are done")
    left = 1.0 - len(completed) / max(len(plan.steps), len(completed), 1)
    check_disk(folder, left * plan.duration_s, len(rig.config.markers))
    return _Run(procedure, rig, folder, old, plan, completed, watching, progress).go()


def _checked_plan(procedure: Procedure, rig: Rig, seed: int, adviser: Adviser | None) -> Plan:
    plan = dry_run(procedure, rig.config, seed, adviser)
    if plan.broken and not procedure.closed_loop:
        more = f" (and {len(plan.broken) - 1} more)" if len(plan.broken) > 1 else ""
        raise LabrigError(f"nothing was moved: {plan.broken[0]}{more}")
    return plan


class _Run:
    """One session of a run, from the first vent to the last."""

    def __init__(
        self,
        procedure: Procedure,
        rig: Rig,
        folder: Path,
        facts: dict[str, Any],
        plan: Plan,
        completed: list[Completed],
        watching: Watching,
        progress: Callable[[Progress], None] | None,
    ) -> None:
        self.procedure, self.rig, self.folder, self.facts = procedure, rig, folder, facts
        self.plan, self.completed, self.control = plan, completed, watching.control
        self.history = [replace(done, result=None) for done in completed]
        self.waited_s = 0.0
        self.seed = int(facts["seed"])
        self.watched = bool(watching.observers)
        observers = [*watching.observers, *([Callback(progress, self.control)] if progress else [])]
        self.observation = Observation(observers)
        self.signals = SignalGuard(self.control.toggle)
        self.adviser = watching.adviser
        self.walk = Walk(procedure, rig_info(rig.config, self.seed), self.adviser)
        self.spent_s = 0.0
        self.warnings: list[str] = []
        self.started_s = self.step_started_s = rig.clock.now_s()
        self.session: Session | None = None
        self.next_segment = max((number for number, _ in segment_paths(folder)), default=-1) + 1
        self.session_name = str(self.next_segment)
        self.tally = Tally()
        self.planned_captures = plan.captures
        self.last_progress_s = -1e9
        self.step: Step | None = None
        self.paused_at_s: float | None = None

    def go(self) -> Path:
        """Run to the end, whatever it is; returns the folder or raises what ended the run, vented."""
        error: BaseException | None = None
        vented: VentReport | DeviceError
        with self.signals:
            try:
                try:
                    self._work()
                finally:
                    self.signals.close()
            except BaseException as caught:
                error = caught
                self.signals.close()  # a signal may have come in the middle of the first
            vent_started_s = self.rig.clock.now_s()
            vented = vent_for_sure(self.rig, self._warn)
            log_error = self._write_end(error, vented, vent_started_s)
        self.walk.close()
        if isinstance(vented, VentReport):
            self.observation.tell("vented", tuple(float(value) for value in vented.pressure_kpa))
        self.observation.tell("finished", state_of(error, vented))
        self.observation.close()
        if not (error or log_error) and (word := self.signals.unheard):
            error = Interrupted(word)  # the run is complete; the next one in a loop must not begin
        self._raise(error or log_error, vented)
        if not self.watched and (text := str(self.tally)):
            warnings.warn(f"{self.folder}: {text}", RuntimeWarning, stacklevel=4)
        return self.folder

    def _warn(self, text: str) -> None:
        """Say at once what a person should do; the log hears of it when the vents are over."""
        if self.session is not None and "pressures " not in text:
            text += self.session.last_read()
        self.warnings.append(text)
        self.observation.tell("event", self.rig.clock.now_s(), text, "FATAL")

    def _work(self) -> None:
        self.session = session = Session(
            self.rig, self._open_log, self.observation, self.signals, self.control
        )
        session.on_tick = self._tick
        session.advise = self._advise
        self.observation.tell("started", rig_info(self.rig.config, self.seed), self.rig.rest_mm)
        session.forget_silence()
        vent(session, "start")
        for note in preflight(session):
            session.event(note, "WARNING")
        session.event(f"{self.procedure.procedure_name()} begins: {len(self.plan.steps)} steps")
        self.walk.run(self._carry_out, self.rig.thinking)
        if text := str(self.tally):
            session.event(text, "WARNING")

    def _open_log(self) -> LogWriter:
        chambers = self.rig.config.chambers
        rest_mm = self.rig.rest_mm
        layout = Layout(
            chambers=tuple(chamber.name for chamber in chambers),
            chamber_min=tuple(chamber.min_kpa for chamber in chambers),
            chamber_max=tuple(chamber.max_kpa for chamber in chambers),
            markers=self.rig.config.markers,
            rest_mm=None if rest_mm is None else tuple(tuple(point) for point in rest_mm.tolist()),
            start_s=float(self.facts["start_s"]),
            session=self.session_name,
        )
        writer = LogWriter(segment_path(self.folder, self.next_segment), layout, self.facts)
        self.next_segment += 1
        return writer

    def _carry_out(self, index: int, step: Step) -> Result:
        if index < len(self.completed):
            return self._replay(index, step)
        session = self._session()
        first = index == len(self.completed)
        self.waited_s = 0.0 if first else max(0.0, session.now_s() - self.history[-1].ended_s)
        if first and index > 0:
            session.event(f"resumed after {len(self.completed)} completed steps")
            self._restore(step)
        self._check_limits(index, step)
        if self.control.paused and isinstance(step, Actuate):
            self.step_started_s = session.now_s()
            self._pause()
        self.step, self.step_started_s = step, session.now_s()
        taken = attempt(session, index, step, self._again, self._pause_for_fault)
        session.step_message(taken.done, "DONE", taken.logged)
        self.history.append(replace(taken.done, result=None, waited_s=self.waited_s))
        self.spent_s += taken.done.took_s
        self.tally.add(taken.done)
        self.observation.tell("step_done", taken.done)
        self._report(step, index + 1)
        return taken.done.result

    def _check_limits(self, index: int, step: Step) -> None:
        if broken := limit_errors(step, self.rig.config):
            raise LabrigError(f"step {index} ({step.kind}): {broken[0]}; it was not sent")

    def _session(self) -> Session:
        if self.session is None:
            raise LabrigError("the run has not begun")
        return self.session

    def _replay(self, index: int, step: Step) -> Result:
        done = self.completed[index]
        if done.step != step:
            raise NotResumableError(
                f"cannot resume {self.folder}: step {index} was {done.step.to_dict()}, and the procedure now asks "
                f"for {step.to_dict()}; start a new run"
            )
        self.tally.add(done)
        self.spent_s += done.took_s
        return done.result

    def _advise(self, ask: Ask) -> Advice:
        return {} if self.adviser is None else self.adviser.advise(ask, self.spent_s)

    def _restore(self, next_step: Step) -> None:
        """Bring a vented rig back to where the run was: the same set-points, held as long as they were."""
        session = self._session()
        for actuate, held_s in holds_to_restore(self.history, next_step, self.waited_s):
            self._check_limits(len(self.history) - 1, actuate)
            session.begin_step(actuate, len(self.history) - 1)
            execute(session, actuate, "restore")
            session.begin_step(Settle(held_s), len(self.history) - 1)
            execute(session, Settle(held_s))

    def _again(self, step: Step) -> None:
        """Vent, and come back to where the rig was before `step`: what was lost on the way is sent again."""
        vent(self._session(), "repeat")
        self._restore(step)

    def _pause_for_fault(self) -> None:
        self.control.pause()
        self._pause()

    def _pause(self) -> None:
        session = self._session()
        session.event("paused: vented, waiting")
        self.paused_at_s = paused_at_s = session.now_s()
        vent(session, "pause")
        while self.control.paused:
            session.held.frames.clear()
            session.held.samples.clear()
            self._tick()
            session.wait_until(session.now_s() + session.tick_s)
            if not isinstance(session.clock, RealClock):
                RealClock().sleep(0.01)  # a simulated clock would write a log of hours meanwhile
        session.event("going on")
        self.step_started_s += session.now_s() - paused_at_s
        self.paused_at_s = None

    def _tick(self) -> None:
        now_s = self.rig.clock.now_s()
        if now_s - self.last_progress_s >= _PROGRESS_S and self.step is not None:
            self.last_progress_s = now_s
            self._report(self.step, self.walk.index)

    def _report(self, step: Step, steps_done: int) -> None:
        plan, now_s = self.plan, self.rig.clock.now_s()
        known = not self.procedure.closed_loop
        planned_s = plan.start_s[steps_done] if steps_done < len(plan.start_s) else plan.duration_s
        if steps_done == self.walk.index and self.step is not None:
            until_s = now_s if self.paused_at_s is None else self.paused_at_s  # a pause is not in the plan
            planned_s = min(planned_s + until_s - self.step_started_s, plan.duration_s)
        progress = Progress(
            steps_done=steps_done,
            steps=len(plan.steps) if known else None,
            captures_done=self.tally.captures,
            captures=self.planned_captures if known else None,
            elapsed_s=now_s - self.started_s,
            remaining_s=plan.duration_s - planned_s if known else None,
            step=step.kind,
            paused=self.control.paused,
        )
        self.observation.tell("progress", progress)

    def _write_end(
        self, error: BaseException | None, vented: VentReport | DeviceError, vent_s: float
    ) -> Exception | None:
        """Write how the run ended and close the log; the rig is vented already, so this may fail."""
        if self.session is None or self.session.log is None:
            return None
        session, log, state = self.session, self.session.log, state_of(error, vented)
        try:
            for text in self.warnings:
                log.event(session.now_s(), text, "WARNING")
            if isinstance(vented, VentReport):
                zeros = np.zeros(len(self.rig.config.chambers))
                session.log_command(vent_s, zeros, event=True, reason="end")
                with contextlib.suppress(DeviceError):
                    session.poll()
                session.event(state, "INFO" if error is None else "ERROR")
            else:
                session.event(state, "FATAL")
            log.close(state)
        except Exception as problem:  # the log may be what failed; nothing more can be done for it
            log.abandon()
            return problem
        return None

    def _raise(self, error: BaseException | None, vented: VentReport | DeviceError) -> None:
        if isinstance(vented, DeviceError):
            raise not_vented(vented, error, reason_of(error)) from error
        if isinstance(error, LogGoneError):
            raise LabrigError(f"{error}; {self._saved()}; the chambers are vented") from error
        if isinstance(error, OSError):
            what = f"the log in {self.folder} cannot be written"
            if error.filename and self.folder.resolve() not in Path(error.filename).resolve().parents:
                what = str(error.filename)  # such as a scan's file that somebody moved
            raise LabrigError(f"{what}: {error.strerror or error}; the chambers are vented") from error
        if isinstance(error, KeyboardInterrupt):
            done = f"after {counted(self.walk.index, 'step')} and {counted(self.tally.captures, 'capture')}"
            who = reason_of(error).removeprefix("stopped by ")
            raise Interrupted(f"stopped by {who} {done}; the chambers are vented") from error
        if error is not None:
            said = and_vented(error)
            raise said from (error.__cause__ if said is error else error)

    def _saved(self) -> str:
        """Where the captures are of a run whose folder is gone."""
        log = self.session.log if self.session is not None else None
        if log is None or log.rescued is None:
            return "what it held could not be saved"
        before = (
            " (what was logged before this file is where the folder went)" if self.next_segment > 1 else ""
        )
        return f"what it held is saved in {log.rescued}, {self.tally.captures} captures{before}"
