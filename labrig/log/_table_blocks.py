"""Long tables in a log: many rows in one message, which is a hundred times faster than one message for each."""

from __future__ import annotations

from collections.abc import Callable, Iterator, Sequence
from typing import TYPE_CHECKING, Any

import numpy as np

from labrig.log._topics import Topic

if TYPE_CHECKING:
    from labrig.log._segments import LoadedSegment
    from labrig.log._writer import LogWriter

_NUMBERS = 3000
"""Numbers in a message: it stays below the 64 KiB that a chunk of the log leaves room for."""
_LOST_AT_MOST = 16
"""So many messages are in a chunk at most: a damaged file loses whole chunks."""


def write_blocks(
    writer: LogWriter,
    rows: dict[str, np.ndarray],
    captures: dict[str, np.ndarray],
    events: dict[str, np.ndarray],
) -> None:
    """Write rows (`row_capture`, `time_s`, ...), captures (`setpoint`, ...) and events (`event_time_s`, ...).

    Names are the fields of `TableBlock`; `session`, `repeat`, `segment` and `event_session` are texts. A capture stands
    with its rows and with the events up to its own, so that a log that was cut keeps what came before.
    """
    time_s = rows["time_s"]
    earliest = min(0.0, float(np.nanmin(time_s, initial=0.0)))
    n, n_events = len(captures["event"]), len(events["event_time_s"])
    row_end = np.searchsorted(rows["row_capture"], np.arange(n), side="right")
    event_end = np.zeros(0, dtype=np.int64)
    if n:
        event_end = np.maximum.accumulate(np.clip(captures["event"] + 1, 0, n_events))
    cost = np.cumsum(
        _width(captures)
        + np.diff(np.r_[0, row_end]) * _width(rows)
        + np.diff(np.r_[0, event_end]) * _width(events)
    )
    ends = np.flatnonzero(np.diff(cost // _NUMBERS, append=-1)) + 1
    capture = row = event = 0
    for number, end in enumerate([*ends.tolist(), n]):
        to_row = int(row_end[end - 1]) if end else 0
        to_event = n_events if end == n else int(event_end[end - 1])
        at = float(time_s[row]) - earliest if row < len(time_s) else 0.0
        groups = [(events, event, to_event), (captures, capture, end), (rows, row, to_row)]
        for block in _split(groups):
            writer.write(Topic.TABLE, at if np.isfinite(at) else 0.0, **_fields(block))
        if number % _LOST_AT_MOST == _LOST_AT_MOST - 1:
            writer.step_done()
        capture, row, event = end, to_row, to_event


def _width(group: dict[str, np.ndarray]) -> int:
    """Numbers in one entry of a group."""
    return sum(int(np.prod(values.shape[1:])) for values in group.values())


def _split(groups: list[tuple[dict[str, np.ndarray], int, int]]) -> Iterator[dict[str, np.ndarray]]:
    """Parts of groups as blocks: one, or several where a group is too long for one."""
    step = max(2 * _NUMBERS // sum(_width(group) for group, _, _ in groups), 1)
    for begin in range(0, max(end - start for _, start, end in groups), step):
        yield {
            name: values[min(start + begin, end) : min(start + begin + step, end)]
            for group, start, end in groups
            for name, values in group.items()
        }


def _fields(chunk: dict[str, np.ndarray]) -> dict[str, list[Any]]:
    """The fields of one message; texts become numbers of its own list of labels."""
    out: dict[str, list[Any]] = {}
    labels: list[str] = []
    for name, values in chunk.items():
        if values.dtype.kind in "OU":
            unique, code = np.unique(values.astype(str), return_inverse=True)
            out[name] = (code.reshape(-1) + len(labels)).tolist()
            labels += [str(text) for text in unique]
        else:
            out[name] = values.ravel().tolist()
    return {**out, "label": labels}


def read_blocks(loaded: LoadedSegment) -> dict[str, np.ndarray]:
    """All fields of the blocks of a log, joined; lists of columns are still flat. Empty if there are no blocks."""
    from labrig_schema.table_pb2 import TableBlock

    blocks = [TableBlock.FromString(payload) for payload in loaded.messages(Topic.TABLE).payload]
    if not blocks:
        return {}
    out: dict[str, np.ndarray] = {}
    for name in (f.name for f in TableBlock.DESCRIPTOR.fields if f.name not in {"timestamp", "label"}):
        text = name in {"session", "repeat", "segment", "event_session"}
        out[name] = _joined(blocks, lambda b, n=name: getattr(b, n), text=text)
    return out


def _joined(blocks: Sequence[Any], get: Callable[[Any], Any], *, text: bool) -> np.ndarray:
    parts = []
    for block in blocks:
        values = np.array(get(block))
        if text:
            values = np.array([*block.label, ""], dtype=object)[values.astype(np.int64)]
        elif values.dtype.kind in "iu":
            values = values.astype(np.int64)
        if len(values):
            parts.append(values)
    return np.concatenate(parts) if parts else np.zeros(0, dtype=object if text else np.int64)
