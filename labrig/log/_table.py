"""Runs that came from a table: a Dataset becomes a run folder, and the folder the same Dataset again."""

from __future__ import annotations

import json
import os
import shutil
import tempfile
from collections.abc import Iterable
from pathlib import Path
from typing import TYPE_CHECKING, Any

import numpy as np
import yaml

from labrig._errors import LabrigError
from labrig.log._dataset import REST_OF, CampaignArrays
from labrig.log._layout import Layout
from labrig.log._segments import LoadedSegment, is_segment, segment_path
from labrig.log._table_blocks import read_blocks, write_blocks
from labrig.log._topics import Topic
from labrig.log._writer import LogWriter

if TYPE_CHECKING:
    import xarray as xr

_REQUIRED = ("commanded", "hold_s", "time_s", "settled", "event_time_s", "event_commanded")
_REQUIRED_COORDS = ("session", "repeat", "event_session", "event_of", "chamber_min", "chamber_max")
_ROW_VARIABLES = ("measured", "observed", "covariates", "position_mm")
_ROW_BY_ROW = 20_000
"""A longer table is written in blocks: viewers plot it no longer, and row by row it would take minutes."""
_Columns = dict[str, np.ndarray]
_OWN_ATTRIBUTES = {"run", "run_id", "source", "between_sessions", "units", "warnings"}


def write_dataset(
    dataset: xr.Dataset, folder: Path, *, run_yaml: dict[str, Any], replace: bool = False
) -> Path:
    """Write a campaign to a new run folder: `log.000.mcap` and `run.yaml`; returns the folder.

    `open_run(folder)` gives back an equal Dataset, numbers to the last digit; rows after the last one that
    has a time are padding and come back as NaN and not settled. The folder appears whole or not at all; with `replace`,
    in the place of one that is there, of which all but log and run.yaml (what people noted) stays.

    Raises `LabrigError` if the folder exists and is not to be replaced, a variable of docs/reference/dataset.md is
    missing, or a row has values but no time.
    """
    folder = Path(folder)
    if folder.exists() and not replace:
        raise LabrigError(f"{folder} exists already; choose another name or remove it")
    _check(dataset)
    run_yaml = json.loads(json.dumps(run_yaml, default=str))
    folder.parent.mkdir(parents=True, exist_ok=True)
    partial = Path(tempfile.mkdtemp(prefix=f".{folder.name}.", suffix=".partial", dir=folder.parent))
    try:
        writer = LogWriter(segment_path(partial, 0), layout_of(dataset), run_yaml)
        try:
            if int(_row_counts(dataset).sum()) > _ROW_BY_ROW:
                write_blocks(writer, *_columns(dataset))
            else:
                _write_events(writer, dataset)
                _write_captures(writer, dataset)
        finally:
            writer.close()
        (partial / "run.yaml").write_text(yaml.safe_dump(run_yaml, sort_keys=False), encoding="utf-8")
        partial.chmod(0o755)
        if replace and folder.exists():
            _put_in_place(partial, folder)
        else:
            os.rename(partial, folder)  # noqa: PTH104  (replaces nothing: a folder that appeared meanwhile stays)
    except BaseException:
        shutil.rmtree(partial, ignore_errors=True)
        raise
    return folder


def _put_in_place(partial: Path, folder: Path) -> None:
    """Put a whole run in the place of another, with what lies beside the other's log; the other goes last."""
    aside = Path(tempfile.mkdtemp(prefix=f".{folder.name}.", suffix=".old", dir=folder.parent)) / folder.name
    folder.rename(aside)
    try:
        partial.rename(folder)
    except BaseException:
        aside.rename(folder)
        aside.parent.rmdir()
        raise
    for entry in aside.iterdir():
        if not is_segment(entry.name) and entry.name != "run.yaml":
            entry.rename(folder / entry.name)
    shutil.rmtree(aside.parent)


def _check(dataset: xr.Dataset) -> None:
    missing = [name for name in _REQUIRED if name not in dataset.variables]
    missing += [name for name in _REQUIRED_COORDS if name not in dataset.coords]
    if missing:
        raise LabrigError(f"the campaign has no {', '.join(missing)}; see docs/reference/dataset.md")
    rows = _row_counts(dataset)
    past = np.arange(dataset.sizes["time"]) >= rows[:, None]
    for name in _ROW_VARIABLES:
        if name in dataset:
            values = dataset[name].to_numpy()
            finite = np.isfinite(values).reshape(*values.shape[:2], -1).any(axis=2)
            if (bad := np.argwhere(finite & past)).size:
                raise LabrigError(
                    f"{name} of capture {bad[0][0]} has values in row {bad[0][1]}, which has no time"
                )


def _row_counts(dataset: xr.Dataset) -> np.ndarray:
    timed = np.isfinite(dataset["hold_s"].to_numpy()) | np.isfinite(dataset["time_s"].to_numpy())
    indices = np.arange(1, dataset.sizes["time"] + 1)
    return (timed * indices).max(axis=1, initial=0)


def layout_of(dataset: xr.Dataset) -> Layout:
    """What a Dataset says of itself, as a log's layout."""
    coords = dataset.coords
    units = dataset["commanded"].attrs.get("units", dataset.attrs.get("units", "kPa"))
    rest = dataset["rest_mm"].to_numpy().tolist() if "rest_mm" in dataset else None
    observables: list[Any] = []
    places = None
    covariates: list[Any] = []
    if "observed" in dataset:
        columns = [coords[name].to_numpy() for name in ("observable", "unit", "marker_of", "axis_of")]
        observables = [tuple(str(item) for item in row) for row in zip(*columns, strict=True)]
        if all(name in coords for name in REST_OF):
            of_each = np.stack([coords[name].to_numpy() for name in REST_OF], axis=1)
            places = tuple(tuple(point) for point in of_each.tolist())
    if "covariates" in dataset:
        columns = [coords[name].to_numpy() for name in ("covariate", "covariate_unit")]
        covariates = [tuple(str(item) for item in row) for row in zip(*columns, strict=True)]
    return Layout(
        chambers=tuple(str(name) for name in coords["chamber"].to_numpy()),
        chamber_min=tuple(float(value) for value in coords["chamber_min"].to_numpy()),
        chamber_max=tuple(float(value) for value in coords["chamber_max"].to_numpy()),
        unit=str(units),
        markers=tuple(str(name) for name in coords["marker"].to_numpy()) if "marker" in coords else (),
        rest_mm=None if rest is None else tuple(tuple(point) for point in rest),
        observables=tuple(observables),
        covariates=tuple(covariates),
        variables=tuple(name for name in _ROW_VARIABLES if name in dataset),
        table=True,
        source=str(dataset.attrs.get("source", "table")),
        between_sessions=str(dataset.attrs.get("between_sessions", "unknown")),
        attributes={key: value for key, value in dataset.attrs.items() if key not in _OWN_ATTRIBUTES},
        observable_rest_mm=places,
    )


def _write_events(writer: LogWriter, dataset: xr.Dataset) -> None:
    times = dataset["event_time_s"].to_numpy()
    setpoints = dataset["event_commanded"].to_numpy()
    sessions = dataset["event_session"].to_numpy()
    for time_s, setpoint, session in zip(times, setpoints, sessions, strict=True):
        writer.command(float(time_s), setpoint, event=True, reason="import", session=str(session))


def _write_captures(writer: LogWriter, dataset: xr.Dataset) -> None:
    rows = {
        name: dataset[name].to_numpy()
        for name in (*_ROW_VARIABLES, "time_s", "hold_s", "settled")
        if name in dataset
    }
    setpoints = dataset["commanded"].to_numpy()
    counts = _row_counts(dataset)
    labels = {name: dataset[name].to_numpy() for name in ("session", "repeat", "event_of")}
    segment = _segments(dataset)
    lists = [name for name in _ROW_VARIABLES if name in rows]
    earliest = min(0.0, float(np.nanmin(rows["time_s"], initial=0.0)))
    for capture, count in enumerate(counts):
        times, holds = rows["time_s"][capture], rows["hold_s"][capture]
        writer.write(
            Topic.CAPTURE,
            float(times[0]) - earliest if count else 0.0,
            capture=capture,
            setpoint=setpoints[capture].tolist(),
            session=str(labels["session"][capture]),
            repeat=str(labels["repeat"][capture]),
            event=int(labels["event_of"][capture]),
            segment=str(segment[capture]),
        )
        for row in range(count):
            writer.write(
                Topic.OBSERVATION,
                float(times[row]) - earliest,
                capture=capture,
                time_s=float(times[row]),
                hold_s=float(holds[row]),
                settled=bool(rows["settled"][capture, row]),
                **{name: rows[name][capture, row].ravel().tolist() for name in lists},
            )


def _segments(dataset: xr.Dataset) -> np.ndarray:
    if "segment" in dataset.coords:
        return dataset["segment"].to_numpy()
    return np.full(dataset.sizes["capture"], "")


def _columns(dataset: xr.Dataset) -> tuple[_Columns, _Columns, _Columns]:
    """Rows, captures and events of a campaign as the fields of blocks, without the padding."""
    inside = np.arange(dataset.sizes["time"]) < _row_counts(dataset)[:, None]
    names = ("time_s", "hold_s", "settled", *(name for name in _ROW_VARIABLES if name in dataset))
    rows = {name: dataset[name].to_numpy()[inside] for name in names}
    captures = {
        "capture_number": np.arange(dataset.sizes["capture"]),
        "setpoint": dataset["commanded"].to_numpy(),
        "event": dataset["event_of"].to_numpy(),
        "session": dataset["session"].to_numpy(),
        "repeat": dataset["repeat"].to_numpy(),
        "segment": _segments(dataset),
    }
    events = {
        "event_number": np.arange(dataset.sizes["event"]),
        "event_time_s": dataset["event_time_s"].to_numpy(),
        "event_setpoint": dataset["event_commanded"].to_numpy(),
        "event_session": dataset["event_session"].to_numpy(),
    }
    return {"row_capture": np.nonzero(inside)[0], **rows}, captures, events


def table_arrays(loaded: LoadedSegment) -> CampaignArrays:
    """The arrays of a run that `write_dataset` wrote."""
    found = read_blocks(loaded) or _read_messages(loaded)
    layout = loaded.layout
    widths = {"measured": len(layout.chambers), "observed": len(layout.observables)}
    widths |= {"covariates": len(layout.covariates), "position_mm": 3 * len(layout.markers)}
    chambers = len(layout.chambers)
    event, kept = _known_events(found)
    number = found["capture_number"].astype(int)[kept]
    index_of = np.full(int(max(number.max(initial=-1), found["row_capture"].max(initial=-1))) + 1, -1)
    index_of[number] = np.arange(len(number))
    of = index_of[found["row_capture"].astype(int)]
    whole = of >= 0
    of = of[whole]
    place = _place_in_group(of)
    shape = (len(number), int(place.max(initial=-1)) + 1)

    def spread(values: np.ndarray, fill: Any = np.nan) -> np.ndarray:
        result = np.full((*shape, *values.shape[1:]), fill, dtype=values.dtype)
        result[of, place] = values[whole]
        return result

    lists = {}
    for name in layout.variables:
        values = found[name].astype(float).reshape(-1, widths[name])
        lists[name] = spread(values.reshape(-1, len(layout.markers), 3) if name == "position_mm" else values)
    segment = found["segment"][kept]
    return CampaignArrays(
        commanded=found["setpoint"].astype(float).reshape(-1, chambers)[kept],
        hold_s=spread(found["hold_s"].astype(float)),
        time_s=spread(found["time_s"].astype(float)),
        settled=spread(found["settled"].astype(bool), False),
        event_time_s=found["event_time_s"].astype(float),
        event_commanded=found["event_setpoint"].astype(float).reshape(-1, chambers),
        session=found["session"][kept].tolist(),
        repeat=found["repeat"][kept].tolist(),
        event_session=found["event_session"].tolist(),
        event_of=event[kept].astype(np.int64),
        segment=segment.tolist() if any(segment) else None,
        **lists,
    )


def _known_events(found: dict[str, np.ndarray]) -> tuple[np.ndarray, np.ndarray]:
    """The place of each capture's event among those that are left, and which captures (a mask) still have theirs."""
    event, number = found["event"].astype(np.int64), found["event_number"].astype(np.int64)
    if np.array_equal(number, np.arange(len(number))):
        return event, np.ones(len(event), dtype=bool)
    place = {n: i for i, n in enumerate(number.tolist())}
    found_at = np.array([place.get(e, -1) for e in event.tolist()], dtype=np.int64)
    return found_at, found_at >= 0


def _read_messages(loaded: LoadedSegment) -> dict[str, np.ndarray]:
    """A table that was written row by row, as the fields of blocks."""
    from labrig_schema.observation_pb2 import Observation
    from labrig_schema.pressure_pb2 import PressureCommand
    from labrig_schema.step_pb2 import Capture

    captures = [Capture.FromString(payload) for payload in loaded.messages(Topic.CAPTURE).payload]
    events = [PressureCommand.FromString(payload) for payload in loaded.messages(Topic.COMMAND).payload]
    rows = [Observation.FromString(payload) for payload in loaded.messages(Topic.OBSERVATION).payload]

    def texts(values: Iterable[str]) -> np.ndarray:
        return np.array(list(values), dtype=object)

    return {
        "row_capture": np.array([row.capture for row in rows], np.int64),
        "time_s": np.array([row.time_s for row in rows], float),
        "hold_s": np.array([row.hold_s for row in rows], float),
        "settled": np.array([row.settled for row in rows], bool),
        **{name: np.array([getattr(row, name) for row in rows], float) for name in loaded.layout.variables},
        "capture_number": np.array([capture.capture for capture in captures], np.int64),
        "setpoint": np.array([capture.setpoint for capture in captures], float),
        "event": np.array([capture.event for capture in captures], np.int64),
        "session": texts(capture.session for capture in captures),
        "repeat": texts(capture.repeat for capture in captures),
        "segment": texts(capture.segment for capture in captures),
        "event_number": np.arange(len(events)),
        "event_time_s": np.array([event.time_s for event in events], float),
        "event_setpoint": np.array([event.setpoint for event in events], float),
        "event_session": texts(event.session for event in events),
    }


def _place_in_group(of: np.ndarray) -> np.ndarray:
    """For each row, how many rows of the same capture come before it; the captures are contiguous."""
    starts = np.flatnonzero(np.r_[True, of[1:] != of[:-1]]) if of.size else np.array([], int)
    lengths = np.diff(np.r_[starts, of.size])
    return np.arange(of.size) - np.repeat(starts, lengths)
