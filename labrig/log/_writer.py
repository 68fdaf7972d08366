"""The log of one session: MCAP, protobuf, zstd chunks, durable at every step."""

import contextlib
import json
import os
from pathlib import Path
from typing import Any

import numpy as np
from numpy.typing import ArrayLike, NDArray

from labrig._durable import sync_folder
from labrig._errors import LabrigError
from labrig.log._frames import FrameEncoder
from labrig.log._layout import Layout, layout_to_text, pack_metadata
from labrig.log._rescue import rescue
from labrig.log._topics import Topic, descriptor_set, topic_table
from labrig_drivers import MarkerFrame, PressureSample

_CHUNK_BYTES = 1024 * 1024 - 64 * 1024
"""A chunk is closed by the message that passes this: it stays below 1 MiB for messages below 64 KiB."""

_MAX_NS = 2**63 - 1
_MAX_S = 9.2e9


def to_ns(time_s: float) -> int:
    """Seconds as the nanoseconds of a log; what cannot be expressed is moved to the nearest end."""
    if 0.0 < time_s < _MAX_S:
        whole = int(time_s)
        return whole * 1_000_000_000 + int((time_s - whole) * 1e9 + 0.5)
    return _MAX_NS if time_s >= _MAX_S else 0


class LogWriter:
    """Writes one segment (`log.000.mcap`, ...) of a run.

    Raises `LabrigError` when the file exists; every write raises `OSError` when the disk does (a full disk).
    What was written before `step_done` returned survives a kill and a power cut.
    """

    def __init__(self, path: Path, layout: Layout, run: dict[str, Any] | None = None) -> None:
        from mcap.writer import Writer

        self.path = Path(path)
        self.layout = layout
        self._run = run or {}
        self.rescued: Path | None = None
        try:
            self._file = self.path.open("x+b")
        except FileExistsError:
            raise LabrigError(f"{self.path} exists already, and a log is never overwritten") from None
        self.closed = False
        self._topics = topic_table()
        self._sequence = [0] * (max(Topic) + 1)
        self._writer = Writer(self._file, chunk_size=_CHUNK_BYTES)
        self._add_message = self._writer.add_message
        self._frames = FrameEncoder(len(layout.markers))
        try:
            self._begin(layout, run)
            self.step_done()
            sync_folder(self.path.parent)
        except BaseException:
            self.abandon()
            raise

    def _begin(self, layout: Layout, run: dict[str, Any] | None) -> None:
        self._writer.start(profile="", library="labrig")
        self._writer.add_metadata("labrig.layout", pack_metadata(layout_to_text(layout)))
        if run is not None:
            self._writer.add_metadata("labrig.run", pack_metadata(json.dumps(run)))
        self._register()
        self._write_plan(run or {})

    def _register(self) -> None:
        names = ",".join(self.layout.chambers)
        metadata = {
            Topic.COMMAND: {"chambers": names, "unit": self.layout.unit},
            Topic.MEASURED: {"chambers": names, "unit": self.layout.unit},
            Topic.MARKERS: {"markers": ",".join(self.layout.markers), "unit": "mm"},
            Topic.ENVIRONMENT: {
                "columns": ",".join(f"{name} [{unit}]" for name, unit in self.layout.covariates)
            },
        }
        for topic, info in self._topics.items():
            descriptor = info.message.DESCRIPTOR
            schema = self._writer.register_schema(
                descriptor.full_name, "protobuf", descriptor_set(info.message)
            )
            self._writer.register_channel(info.name, "protobuf", schema, metadata.get(topic, {}))

    def _write_plan(self, run: dict[str, Any]) -> None:
        """The spare copy of what the metadata say, in a small chunk of its own, with the schemas."""
        self.write(
            Topic.PLAN,
            self.layout.start_s,
            procedure=str(run.get("procedure", "")),
            parameters_json=json.dumps(run.get("parameters", {})),
            plan_sha256=str(run.get("plan_sha256", "")),
            steps=int(run.get("steps", 0) or 0),
            estimate_s=float(run.get("estimate_s", 0.0) or 0.0),
            run_json=json.dumps(run),
            layout_json=layout_to_text(self.layout),
        )
        self._writer.flush()

    def _add(self, topic: Topic, time_s: float, message: Any) -> None:
        time_ns = to_ns(time_s)
        stamp = message.timestamp
        stamp.seconds, stamp.nanos = divmod(time_ns, 1_000_000_000)
        self.raw(topic, time_ns, message.SerializeToString())

    def command(
        self, time_s: float, setpoint: ArrayLike, *, event: bool, reason: str = "actuate", session: str = ""
    ) -> None:
        """A command to the chambers, in `layout.unit`, shape (C,); `event` where an actuation begins."""
        message = self._topics[Topic.COMMAND].message(
            setpoint=np.asarray(setpoint, float).tolist(),
            event=event,
            reason=reason,
            time_s=time_s,
            session=session,
        )
        self._add(Topic.COMMAND, time_s, message)

    def measured(self, sample: PressureSample) -> None:
        """One pressure measurement."""
        message = self._topics[Topic.MEASURED].message(pressure=sample.pressure_kpa.tolist())
        self._add(Topic.MEASURED, sample.time_s, message)

    def frame(self, frame: MarkerFrame) -> None:
        """One motion capture frame; positions are kept as 32 bit floats (below 0.0001 mm at 1 m)."""
        time_ns = to_ns(frame.time_s)
        self.raw(Topic.MARKERS, time_ns, self._frames.encode(frame, time_ns))

    def environment(self, time_s: float, values: ArrayLike) -> None:
        """One row of the layout's covariates."""
        message = self._topics[Topic.ENVIRONMENT].message(value=np.asarray(values, float).tolist())
        self._add(Topic.ENVIRONMENT, time_s, message)

    def write(self, topic: Topic, at_s: float, /, **fields: Any) -> None:
        """Any other message, by the field names of its .proto file."""
        self._add(topic, at_s, self._topics[topic].message(**fields))

    def raw(self, topic: Topic, time_ns: int, payload: bytes) -> None:
        """A message that is encoded already."""
        self._sequence[topic] = sequence = (self._sequence[topic] + 1) & 0xFFFFFFFF
        self._add_message(int(topic), time_ns, payload, time_ns, sequence)

    def event(self, time_s: float, text: str, level: str = "INFO") -> None:
        """A line for people, as Foxglove's Log message; `level` is INFO, WARNING, ERROR or FATAL."""
        kind = self._topics[Topic.EVENTS].message
        self._add(Topic.EVENTS, time_s, kind(level=kind.Level.Value(level), message=text, name="labrig"))

    def vectors(self, topic: Topic, time_s: float, model: str, vector_mm: NDArray[np.float64]) -> None:
        """A prediction or a residual of the markers, mm, shape (M, 3)."""
        self.write(topic, time_s, model=model, vector_mm=np.asarray(vector_mm, float).ravel().tolist())

    @property
    def gone(self) -> bool:
        """Whether the file was deleted or moved, or its folder was; writing to it goes on without an error."""
        return not self.path.exists()

    def size_bytes(self) -> int:
        """How much of the file is written; what is still in the open chunk does not count."""
        return self._file.tell()

    def step_done(self) -> None:
        """Make everything written so far durable: flush the chunk, then fsync the file."""
        self._writer.flush()
        os.fsync(self._file.fileno())

    def abandon(self) -> None:
        """Close the file as it is, without its indexes: what is whole in it can be read."""
        self.closed = True
        with contextlib.suppress(OSError):
            self._file.close()

    def close(self, reason: str = "") -> None:
        """Write the indexes and close the file; calling it again does nothing.

        `reason` says why the run ended, in the metadata record "labrig.end"; left out when it goes on. A file that
        was deleted or moved is saved in a new folder, `rescued`.
        """
        if self.closed:
            return
        self.closed = True
        try:
            if reason:
                self._writer.flush()
                self._writer.add_metadata("labrig.end", pack_metadata(json.dumps({"reason": reason})))
            self._writer.finish()
            self._file.flush()
            os.fsync(self._file.fileno())
            if self.gone:
                self.rescued = rescue(self._file, self.path, self._run)
        finally:
            self._file.close()
