"""Runs that the rig recorded: steps, commands, frames and pressures become the arrays of a campaign."""

import json
from dataclasses import dataclass
from typing import Any

import numpy as np
from numpy.typing import NDArray

from labrig.arrays import Floats
from labrig.log._dataset import CampaignArrays
from labrig.log._frames import POINT
from labrig.log._scan import Messages
from labrig.log._segments import LoadedSegment
from labrig.log._topics import Topic
from labrig.log._writer import to_ns

_LONGEST_GAP_S = 1.5
_NEAR_S = 0.1
"""Between sensor samples further apart than the longest gap, the pressure is known only near one of them."""
_USUAL_WAY_S, _LAG_S = 0.6, 0.4
"""A set-point is slewed to. What fits a hold leaves out its first second: that is such a way, and what lags behind."""

Times = NDArray[np.int64]


@dataclass
class Series:
    """Values over time: `time_ns` (N,), non-decreasing; `values` (N, ...)."""

    time_ns: Times
    values: NDArray[Any]

    def between(self, start_ns: int, end_ns: int) -> slice:
        """The samples after `start_ns`, up to and with `end_ns`."""
        first, last = np.searchsorted(self.time_ns, [start_ns, end_ns], side="right")
        return slice(int(first), int(last))

    def during(self, start_ns: int, end_ns: int) -> "Series":
        """The samples from `start_ns` to `end_ns`, both included."""
        first = int(np.searchsorted(self.time_ns, start_ns, side="left"))
        last = int(np.searchsorted(self.time_ns, end_ns, side="right"))
        return Series(self.time_ns[first : max(first, last)], self.values[first : max(first, last)])


@dataclass
class RunSeries:
    """What one segment measured: `frames` (N, M, 3) mm float32, `status` (N, M), `pressures` (P, C) kPa."""

    frames: Series
    status: Series
    pressures: Series


def run_series(loaded: LoadedSegment) -> RunSeries:
    """The measurements of a segment of a rig's run as arrays."""
    from labrig_schema.pressure_pb2 import PressureMeasured

    layout = loaded.layout
    frames, status = marker_series(loaded.messages(Topic.MARKERS), len(layout.markers))
    measured = loaded.messages(Topic.MEASURED)
    return RunSeries(
        frames, status, value_series(measured, PressureMeasured, "pressure", len(layout.chambers))
    )


@dataclass
class _Capture:
    session: str
    event: int
    commanded: Floats
    repeat: str
    time_s: Floats
    hold_s: Floats
    settled: NDArray[np.bool_]
    measured: Floats
    position_mm: Floats | None
    covariates: Floats | None
    wall_s: float


def marker_series(messages: Messages, markers: int) -> tuple[Series, Series]:
    """Frames as (N, M, 3) positions mm, float32, NaN where not seen, and (N, M) `MarkerStatus`.

    A frame of another size is left out.
    """
    from foxglove_schemas_protobuf.PointCloud_pb2 import PointCloud

    size = markers * POINT.itemsize
    parse = PointCloud.FromString
    data = [parse(payload).data for payload in messages.payload]
    kept = [index for index, points in enumerate(data) if len(points) == size]
    points = np.frombuffer(b"".join([data[index] for index in kept]), dtype=POINT)
    time_ns = np.array(messages.time_ns, np.int64)[kept]
    position = points["position_mm"].reshape(len(kept), markers, 3)
    return _ordered(time_ns, position), _ordered(time_ns, points["status"].reshape(len(kept), markers))


def value_series(messages: Messages, kind: Any, field_name: str, width: int) -> Series:
    """A repeated field of every message as (N, width)."""
    values = [getattr(kind.FromString(payload), field_name) for payload in messages.payload]
    return _ordered(np.array(messages.time_ns, np.int64), np.array(values, float).reshape(-1, width))


def _ordered(time_ns: Times, values: NDArray[Any]) -> Series:
    if np.any(np.diff(time_ns) < 0):
        order = np.argsort(time_ns, kind="stable")
        return Series(time_ns[order], values[order])
    return Series(time_ns, values)


def interpolate(series: Series, time_ns: Times) -> Floats:
    """The series at other times, linear between samples; NaN in long gaps and far outside."""
    result = np.full((len(time_ns), *series.values.shape[1:]), np.nan)
    if not len(series.time_ns) or not len(time_ns):
        return result
    after = np.clip(np.searchsorted(series.time_ns, time_ns, side="left"), 1, max(1, len(series.time_ns) - 1))
    before = after - 1
    after = np.minimum(after, len(series.time_ns) - 1)
    span = series.time_ns[after] - series.time_ns[before]
    nearest = np.minimum(np.abs(time_ns - series.time_ns[before]), np.abs(time_ns - series.time_ns[after]))
    close = span <= _LONGEST_GAP_S * 1e9
    weight = np.clip((time_ns - series.time_ns[before]) / np.maximum(span, 1), 0.0, 1.0)
    weight = np.where(close, weight, np.round(weight))[:, None]
    values = np.where(weight < 1, series.values[before] * (1 - weight), 0.0)
    values = values + np.where(weight > 0, series.values[after] * weight, 0.0)
    known = close | (nearest <= _NEAR_S * 1e9)
    result[known] = values[known]
    return result


def rig_arrays(segments: list[LoadedSegment]) -> CampaignArrays:
    """The arrays of a run that labrig recorded; one entry for each session."""
    event_times, event_setpoints, event_sessions = [], [], []
    captures: list[_Capture] = []
    for loaded in segments:
        times, setpoints, held = _events(loaded)
        captures += _captures(loaded, times, setpoints, held, len(event_times))
        event_times += [_seconds(time_ns, loaded) for time_ns in times]
        event_setpoints += setpoints
        event_sessions += [loaded.layout.session] * len(times)
    layout = segments[0].layout
    return CampaignArrays(
        commanded=_rows([capture.commanded for capture in captures], len(layout.chambers)),
        hold_s=_padded([capture.hold_s for capture in captures], ()),
        time_s=_padded([capture.time_s for capture in captures], ()),
        settled=_padded([capture.settled for capture in captures], (), False),
        event_time_s=np.array(event_times, float),
        event_commanded=_rows(event_setpoints, len(layout.chambers)),
        session=[capture.session for capture in captures],
        repeat=[capture.repeat for capture in captures],
        event_session=event_sessions,
        event_of=np.array([capture.event for capture in captures], np.int64),
        measured=_padded([capture.measured for capture in captures], (len(layout.chambers),)),
        position_mm=_optional([capture.position_mm for capture in captures], (len(layout.markers), 3)),
        covariates=_optional([capture.covariates for capture in captures], (len(layout.covariates),)),
        wall_s=[capture.wall_s for capture in captures],
    )


def _seconds(time_ns: Any, loaded: LoadedSegment) -> Any:
    return (time_ns - to_ns(loaded.layout.start_s)) * 1e-9


def _events(loaded: LoadedSegment) -> tuple[list[int], list[Floats], list[int]]:
    """When each actuation began, ns, its set-point, and from when on the rows after it are of that set-point, ns."""
    from labrig_schema.pressure_pb2 import PressureCommand

    messages = loaded.messages(Topic.COMMAND)
    times, setpoints, held = [], [], []
    on_the_way = False
    for time_ns, payload in zip(messages.time_ns, messages.payload, strict=True):
        command = PressureCommand.FromString(payload)
        now = np.array(command.setpoint, float)
        if command.event:
            times.append(time_ns)
            setpoints.append(now)
            held.append(time_ns)
            on_the_way = True
        elif on_the_way:
            if time_ns - times[-1] > _USUAL_WAY_S * 1e9:
                held[-1] = time_ns + int(_LAG_S * 1e9)
            on_the_way = not np.array_equal(now, setpoints[-1])
    return times, setpoints, held


def _captures(
    loaded: LoadedSegment, times: list[int], setpoints: list[Floats], held: list[int], first_event: int
) -> list[_Capture]:
    """Every completed recording, with everything since the actuation or the recording before it.

    Less a long way to the set-point, which is no hold.
    """
    from labrig_schema.observation_pb2 import Environment
    from labrig_schema.step_pb2 import Step

    layout = loaded.layout
    series = run_series(loaded)
    pressures, frames = series.pressures, series.frames if layout.markers else None
    environment = None
    if layout.covariates:
        messages = loaded.messages(Topic.ENVIRONMENT)
        environment = value_series(messages, Environment, "value", len(layout.covariates))
    captures, last_end, last_event = [], 0, -1
    for payload in loaded.messages(Topic.STEP).payload:
        step = Step.FromString(payload)
        if step.state != Step.DONE or step.kind != "record" or _missed(step.result_json):
            continue
        start_ns, end_ns = to_ns(step.started_s), to_ns(step.ended_s)
        event = int(np.searchsorted(times, start_ns, side="right")) - 1
        if event < 0:
            continue
        after = max(min(held[event], start_ns), last_end if event == last_event else 0)
        rows = (frames or pressures).between(after, end_ns)
        time_ns = (frames or pressures).time_ns[rows]
        captures.append(
            _Capture(
                session=loaded.layout.session,
                event=first_event + event,
                commanded=setpoints[event],
                repeat=json.loads(step.step_json).get("repeat", ""),
                time_s=_seconds(time_ns, loaded),
                hold_s=np.asarray((time_ns - times[event]) * 1e-9, np.float64),
                settled=time_ns >= start_ns,
                measured=interpolate(pressures, time_ns),
                position_mm=None if frames is None else frames.values[rows],
                covariates=None if environment is None else interpolate(environment, time_ns),
                wall_s=step.wall_s,
            )
        )
        last_end, last_event = end_ns, event
    return captures


def _missed(result_json: str) -> bool:
    """Whether the pressures did not follow: the capture is in the log and does not count."""
    return bool(result_json) and bool(json.loads(result_json).get("missed"))


def _rows(rows: list[Floats], width: int) -> Floats:
    return np.array(rows, float).reshape(-1, width)


def _optional(holds: list[Any], shape: tuple[int, ...]) -> Floats | None:
    return None if not shape[0] else _padded(holds, shape)


def _padded(holds: list[Any], shape: tuple[int, ...], fill: Any = np.nan) -> Any:
    longest = max((len(hold) for hold in holds), default=0)
    result = np.full((len(holds), longest, *shape), fill, dtype=bool if fill is False else float)
    for index, hold in enumerate(holds):
        result[index, : len(hold)] = hold
    return result
