"""Carries out one step on a session."""

import json
import math
from collections.abc import Callable, Sequence
from concurrent.futures import Future
from threading import Thread
from typing import Any

import numpy as np

from labrig._errors import LabrigError
from labrig.arrays import Floats
from labrig.campaign._scans import keep_scan
from labrig.campaign._session import Session, is_alive
from labrig.campaign._steps import (
    Actuate,
    Actuated,
    Answered,
    Ask,
    Note,
    Record,
    Recording,
    Result,
    Scan,
    Scanned,
    Settle,
    Settled,
    Step,
    Vent,
    Vented,
)
from labrig.log import Topic, to_ns
from labrig.rig import RigConfig
from labrig.run_contents import Advice, StepResult
from labrig_drivers import DeviceError, MarkerFrame, PressureSample, RealClock

_STILLNESS_S = 0.5
_SCAN_GRACE_S = 5.0
_KEEP_S = 600.0
_STRAYS = 3
"""So many recordings in a row without a frame: the camera is too slow for them, or has a clock of its own."""


def limit_errors(step: Step, config: RigConfig) -> list[str]:
    """Every limit that a step would break, each as one phrase; empty when it may be carried out."""
    if not isinstance(step, Actuate):
        return ["the rig has no scanner"] if isinstance(step, Scan) and config.scanner is None else []
    if len(step.pressure_kpa) != len(config.chambers):
        return [f"{len(step.pressure_kpa)} pressures for {len(config.chambers)} chambers"]
    errors = []
    for chamber, pressure_kpa in zip(config.chambers, step.pressure_kpa, strict=True):
        if not math.isfinite(pressure_kpa):
            errors.append(f"{chamber.name} {pressure_kpa} kPa is not a number")
        elif pressure_kpa > chamber.max_kpa:
            errors.append(
                f"{chamber.name} {pressure_kpa:g} kPa is above its limit of {chamber.max_kpa:g} kPa"
            )
        elif pressure_kpa < chamber.min_kpa:
            errors.append(
                f"{chamber.name} {pressure_kpa:g} kPa is below its limit of {chamber.min_kpa:g} kPa"
            )
    return errors


def execute(session: Session, step: Step, reason: str = "actuate") -> tuple[Result, StepResult]:
    """Carry out a step; returns its result, and what of it goes into the log."""
    for kind, action in _ACTIONS.items():
        if isinstance(step, kind):
            return action(session, step, reason)
    raise LabrigError(f"a procedure yielded {step!r}, which is no step; see labrig.campaign")


def _actuate(session: Session, step: Actuate, reason: str) -> tuple[Result, StepResult]:
    target = np.array(step.pressure_kpa, float)
    started_s = session.now_s()
    session.log_command(started_s, target, event=True, reason=reason)
    slew = np.array([chamber.slew_kpa_s for chamber in session.rig.config.chambers])
    tick_s = session.ramp_tick_s(target)
    reach = slew * tick_s
    while True:
        change = np.clip(target - session.commanded_kpa, -reach, reach)
        arrived = bool(np.all(np.abs(target - session.commanded_kpa) <= reach))
        session.command(target if arrived else session.commanded_kpa + change, reason)
        if arrived:
            session.poll()
            return Actuated(started_s, tuple(step.pressure_kpa)), {"time_s": started_s}
        session.wait_until(session.now_s() + tick_s)


def _settle(session: Session, step: Settle, _reason: str) -> tuple[Result, StepResult]:
    started_s = session.now_s()
    session.wait_until(started_s + step.duration_s)
    speeds = _marker_speeds(session.held.frames, session.now_s() - _STILLNESS_S)
    known = bool(np.isfinite(speeds).any())
    measured = session.held.samples[-1].pressure_kpa if session.held.samples else np.array([math.nan])
    error = np.abs(measured - session.commanded_kpa)
    result = Settled(
        took_s=session.now_s() - started_s,
        speed_mm_s=float(np.nanmedian(speeds)) if known else math.nan,
        fastest_mm_s=float(np.nanmax(speeds)) if known else math.nan,
        pressure_error_kpa=float(np.nanmax(error)) if np.isfinite(error).any() else math.nan,
    )
    return result, {
        "took_s": result.took_s,
        "speed_mm_s": result.speed_mm_s,
        "fastest_mm_s": result.fastest_mm_s,
        "pressure_error_kpa": result.pressure_error_kpa,
    }


def _marker_speeds(frames: list[MarkerFrame], since_s: float) -> Floats:
    """Each marker's speed over the last frames, mm/s, (M,), from the slope of its positions; NaN if unseen.

    A slope over many frames, not a difference of two: noise of 0.1 mm would look like 10 mm/s.
    """
    last = [frame for frame in frames if frame.time_s >= since_s]
    if len(last) < 3:
        return np.full(1, np.nan)
    time_s = np.array([frame.time_s for frame in last]) - last[0].time_s
    position = np.array([frame.position_mm for frame in last])
    seen = np.isfinite(position[..., 0])
    count = np.count_nonzero(seen, axis=0)
    enough = np.maximum(count, 1)
    time = np.where(seen, time_s[:, None], 0.0)
    centred_time = np.where(seen, time - time.sum(axis=0) / enough, 0.0)
    moved = np.where(seen[..., None], position, 0.0)
    spread = (centred_time**2).sum(axis=0)
    slope = (centred_time[..., None] * moved).sum(axis=0) / np.where(spread > 0, spread, np.nan)[:, None]
    return np.where(count >= 3, np.linalg.norm(slope, axis=1), np.nan)


def _record(session: Session, step: Record, _reason: str) -> tuple[Result, StepResult]:
    strays = 0
    while True:
        started_s, before = session.now_s(), len(session.held.frames)
        session.wait_until(started_s + step.duration_s)
        _wait_for_pressure(session, started_s)
        ended_s = session.now_s()
        frames = [frame for frame in session.held.frames if started_s <= frame.time_s <= ended_s]
        if session.rig.mocap is None or any(map(is_alive, frames)):
            break
        strays += 1
        if strays >= _STRAYS:
            raise DeviceError(_no_frames(session, step, before, ended_s))
        session.event("no frame arrived while recording: recording again", "WARNING")
        session.wait_for_frames()
    samples = [sample for sample in session.held.samples if started_s <= sample.time_s <= ended_s]
    markers, chambers = len(session.rig.config.markers), len(session.rig.config.chambers)
    result = Recording(
        time_s=_logged_times(frames),
        position_mm=np.array([frame.position_mm for frame in frames], float).reshape(len(frames), markers, 3),
        pressure_time_s=_logged_times(samples),
        pressure_kpa=np.array([sample.pressure_kpa for sample in samples], float).reshape(
            len(samples), chambers
        ),
    )
    seen = float(result.seen.mean()) if result.seen.size else None
    return result, {
        "frames": len(frames),
        "frame_ns": _span(frames),
        "frames_lost": session.count_lost(frames),
        "samples": len(samples),
        "sample_ns": _span(samples),
        "seen": seen,
    }


def _wait_for_pressure(session: Session, started_s: float) -> None:
    """Go on until a pressure is read that was measured since: where they are read seldom, nothing else says whether the
    chambers followed.
    """
    end_s = session.now_s() + session.rig.config.safety.stale_pressure_s
    while session.now_s() < end_s and not any(s.time_s >= started_s for s in session.held.samples):
        session.wait_until(session.now_s() + session.tick_s)


def _no_frames(session: Session, step: Record, before: int, now_s: float) -> str:
    """Why recordings hold no frame; those from number `before` on arrived during the last of them."""
    name = session.rig.mocap.name if session.rig.mocap is not None else ""
    time_s = [frame.time_s for frame in session.held.frames if is_alive(frame)]
    if not any(map(is_alive, session.held.frames[before:])):
        pace = f": they are {np.median(np.diff(time_s)):.2g} s apart" if len(time_s) > 1 else ""
        return (
            f"{name}: no frame came in {_STRAYS} recordings of {step.duration_s:g} s in a row{pace}; record for "
            "longer, or look at its stream"
        )
    behind_s = now_s - time_s[-1]
    where = f"{abs(behind_s):.2g} s {'before' if behind_s >= 0 else 'ahead of'} labrig's clock"
    return (
        f"{name}: frames arrive, and none is dated within the recording: the last is {where}; "
        "take times from the clock that the driver is given"
    )


def _logged_times(measurements: Sequence[MarkerFrame | PressureSample]) -> Floats:
    """The times with the precision of the log, so that a replay gives back exactly these."""
    return np.array([to_ns(measurement.time_s) * 1e-9 for measurement in measurements], np.float64)


def _span(measurements: Sequence[MarkerFrame | PressureSample]) -> list[int] | None:
    """The first and the last time in the log: exactly which messages the procedure was given."""
    return [to_ns(measurements[0].time_s), to_ns(measurements[-1].time_s)] if measurements else None


def _scan(session: Session, step: Scan, _reason: str) -> tuple[Result, StepResult]:
    scanner = session.rig.scanner
    if scanner is None:
        raise LabrigError(f"rig {session.rig.config.name} has no scanner")
    if (skip := getattr(scanner, "skip_existing", None)) is not None:
        skip()  # an export from before this step shows an earlier shape
    began_s = session.now_s()
    scan = _while_polling(session, lambda: scanner.scan(step.timeout_s), step.timeout_s + _SCAN_GRACE_S)
    came_s, folder = session.now_s(), session.folder
    files: tuple[str, ...] = ()
    if folder is not None:  # hundreds of megabytes, perhaps to a share: the rig is looked after meanwhile
        files = _while_polling(session, lambda: keep_scan(scan, folder), _KEEP_S, "its scan was not kept")
    vertices = np.asarray(scan.vertices_mm, float)
    result = Scanned(
        files=files,
        sha256=scan.sha256,
        vertices=len(vertices),
        triangles=len(scan.triangles),
        registration_error_mm=math.nan if scan.registration_error_mm is None else scan.registration_error_mm,
        unit=scan.unit,
        folder=folder,
    )
    facts: StepResult = {
        "files": list(result.files),
        "sha256": result.sha256,
        "vertices": result.vertices,
        "triangles": result.triangles,
        "registration_error_mm": result.registration_error_mm,
        "unit": result.unit,
    }
    if session.log is not None:
        dated_s = (
            scan.time_s if began_s <= scan.time_s <= came_s else came_s
        )  # files may be dated by another clock
        with session.signals.shield():
            session.log.write(
                Topic.SCAN,
                dated_s,
                **{name: value for name, value in facts.items() if name != "unit"},
                min_mm=vertices.min(axis=0).tolist() if len(vertices) else [],
                max_mm=vertices.max(axis=0).tolist() if len(vertices) else [],
            )
    return result, facts


def _while_polling(session: Session, call: Callable[[], Any], limit_s: float, what: str = "no scan") -> Any:
    """Run a call that waits on a thread while the devices are polled; on a simulated clock, just run it."""
    if not isinstance(session.clock, RealClock):
        value = call()
        session.forget_silence()
        session.poll()
        return value
    future: Future[Any] = Future()

    def work() -> None:
        try:
            future.set_result(call())
        except BaseException as error:
            future.set_exception(error)

    Thread(target=work, name="labrig scan", daemon=True).start()
    end_s = session.now_s() + limit_s
    while not future.done():
        if session.now_s() > end_s:
            raise DeviceError(f"{session.rig.scanner.name}: {what} within {limit_s:g} s")  # type: ignore[union-attr]
        session.poll()
        session.clock.sleep(session.tick_s)
    return future.result()


def _note(session: Session, step: Note, _reason: str) -> tuple[Result, StepResult]:
    session.event(step.text)
    return None, {}


def _vent(session: Session, _step: Vent, reason: str) -> tuple[Result, StepResult]:
    result = vent(session, "vent" if reason == "actuate" else reason)
    return result, {"pressure_kpa": list(result.pressure_kpa), "took_s": result.took_s}


def vent(session: Session, reason: str = "vent") -> Vented:
    """Vent and confirm; the log hears of it afterwards."""
    time_s = session.now_s()
    with session.signals.shield():
        report = session.rig.vent()
    session.commanded_kpa = np.zeros(len(session.rig.config.chambers))
    session.log_command(time_s, session.commanded_kpa, event=True, reason=reason)
    session.forget_silence()
    session.poll()
    return Vented(tuple(float(value) for value in report.pressure_kpa), report.took_s)


def _ask(session: Session, step: Ask, _reason: str) -> tuple[Result, StepResult]:
    """Advice that fails is none: the run goes on as it was planned."""
    try:
        content: Advice = json.loads(json.dumps(session.advise(step)))  # the same as a resumed run reads
    except Exception as error:
        content = {"trouble": f"no advice: {type(error).__name__}: {error}"}
    for what, level in (("say", "INFO"), ("trouble", "WARNING")):
        if text := content.get(what):
            session.event(str(text), level)
    return Answered(content), {"content": content}


_ACTIONS: dict[type[Step], Callable[[Session, Any, str], tuple[Result, StepResult]]] = {
    Actuate: _actuate,
    Settle: _settle,
    Record: _record,
    Scan: _scan,
    Note: _note,
    Vent: _vent,
    Ask: _ask,
}
