"""What a run's log says was completed, as the results that the procedure was given then."""

import json
import math
from bisect import bisect_left
from pathlib import Path
from typing import Any

import numpy as np

from labrig._errors import LabrigError
from labrig.campaign._steps import (
    Actuate,
    Actuated,
    Answered,
    Ask,
    Completed,
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
    step_from_dict,
)
from labrig.log import LoadedSegment, RunSeries, Series, Topic, load_segments, run_series, sessions
from labrig.run_contents import StepResult

_FILLS = ("actuate", "restore")
"""Commands for any other reason are vents."""

_SAME_S = 1e-6
"""Two times that differ by less are one: the log keeps some in ns."""


def read_completed(folder: Path) -> list[Completed]:
    """Every completed step from the first one on, without gaps, with its result.

    A session goes on from what could be read when it began. Should an earlier one have steps beyond that, as where
    its log is damaged, they are of no use: the procedure went on with other results.

    Raises `LabrigError` when the log cannot be read.
    """
    segments, _ = load_segments(folder)
    found: dict[int, Completed] = {}
    for loaded in sessions(segments):
        series = run_series(loaded)
        done = _done(loaded, series, folder)
        began = done[0].index if done else math.inf
        found = {index: completed for index, completed in found.items() if index < began}
        found |= {completed.index: completed for completed in done}
    steps = []
    while len(steps) in found:
        steps.append(found[len(steps)])
    return steps


def _done(loaded: LoadedSegment, series: RunSeries, folder: Path) -> list[Completed]:
    from labrig_schema.pressure_pb2 import PressureCommand
    from labrig_schema.step_pb2 import Step as StepMessage

    completed: list[Completed] = []
    commands = loaded.messages(Topic.COMMAND)
    vents_s = [
        time_ns * 1e-9
        for time_ns, payload in zip(commands.time_ns, commands.payload, strict=True)
        if PressureCommand.FromString(payload).reason not in _FILLS
    ]
    begun_s: dict[int, float] = {}
    for payload in loaded.messages(Topic.STEP).payload:
        message = StepMessage.FromString(payload)
        begun_s.setdefault(message.index, message.started_s)
        if message.state != StepMessage.DONE:
            continue
        step = step_from_dict(json.loads(message.step_json))
        values = json.loads(message.result_json) if message.result_json else {}
        result = _result(step, values, series, message.index, folder)
        waited_s = 0.0
        if completed and completed[-1].index == message.index - 1:
            waited_s = _waited_s(completed[-1].ended_s, begun_s[message.index], vents_s)
        completed.append(
            Completed(message.index, step, result, message.started_s, message.ended_s, True, waited_s)
        )
    return completed


def _waited_s(ended_s: float, begun_s: float, vents_s: list[float]) -> float:
    """How long the pressures were held on from a step's end until the next began, or the chambers were vented."""
    after = bisect_left(vents_s, ended_s - _SAME_S)
    until_s = min([begun_s, *vents_s[after : after + 1]])
    return max(0.0, until_s - ended_s)


def _result(step: Step, values: Any, series: RunSeries, index: int, folder: Path) -> Result:
    if isinstance(step, Actuate):
        return Actuated(values["time_s"], tuple(step.pressure_kpa))
    if isinstance(step, Settle):
        return Settled(**values)
    if isinstance(step, Record):
        return _recording(values, series, index)
    if isinstance(step, Scan):
        fields = {
            name: value for name, value in values.items() if name not in ("commanded_kpa", "reached_kpa")
        }
        missed = tuple(values.get("missed", ()))
        return Scanned(**{**fields, "files": tuple(values["files"]), "missed": missed, "folder": folder})
    if isinstance(step, Ask):
        return Answered(values["content"])
    if isinstance(step, Vent):
        return Vented(tuple(values["pressure_kpa"]), values["took_s"])
    return None


def _recording(values: StepResult, series: RunSeries, index: int) -> Recording:
    frames = _during(series.frames, values["frame_ns"], values["frames"])
    samples = _during(series.pressures, values["sample_ns"], values["samples"])
    if len(frames.time_ns) != values["frames"] or len(samples.time_ns) != values["samples"]:
        raise LabrigError(
            f"the recording of step {index} is damaged: {len(frames.time_ns)} of {values['frames']} frames and "
            f"{len(samples.time_ns)} of {values['samples']} pressure samples are left; it cannot be replayed"
        )
    return Recording(
        time_s=np.asarray(frames.time_ns * 1e-9, np.float64),
        position_mm=frames.values.astype(np.float64),
        pressure_time_s=np.asarray(samples.time_ns * 1e-9, np.float64),
        pressure_kpa=samples.values,
        missed=tuple(values.get("missed", ())),
    )


def _during(series: Series, span: list[int] | None, count: int) -> Series:
    """What a recording holds. In a log from before 0.11 more may be dated as its last, and came after it, or as its
    first, and came before.
    """
    found = series.during(*(span or (1, 0)))
    if (more := len(found.time_ns) - count) <= 0 or not span:
        return found
    after = min(more, int(np.count_nonzero(found.time_ns == span[1])) - 1)
    before = min(more - after, int(np.count_nonzero(found.time_ns == span[0])) - 1)
    kept = slice(before, len(found.time_ns) - after)
    return Series(found.time_ns[kept], found.values[kept])


def holds_to_restore(
    completed: list[Completed], next_step: Step, waited_s: float = 0.0
) -> list[tuple[Actuate, float]]:
    """The set-points that bring a resumed rig back, and how long each is held, s.

    The present hold, if the run stopped in the middle of one, and the one before it: what a chamber did last is
    part of its history. A vent ends the search: the rig is vented already. Each is held for as long as its steps
    really took, and the procedure between them; `waited_s` is that after the last one.
    """
    wanted = 1 if isinstance(next_step, Actuate | Vent) else 2
    holds: list[tuple[Actuate, float]] = []
    held_s = waited_s
    for done in reversed(completed):
        if isinstance(done.step, Vent) or len(holds) == wanted:
            break
        if isinstance(done.step, Actuate):
            holds.insert(0, (done.step, held_s))
            held_s = done.waited_s
        else:
            held_s += done.took_s + done.waited_s
    return [] if isinstance(next_step, Vent) else holds
