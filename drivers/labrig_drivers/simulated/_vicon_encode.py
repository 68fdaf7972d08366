"""The blocks of a DataStream server: a scene of one subject, encoded."""

import struct
import time
from collections.abc import Iterable, Sequence
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from labrig_drivers._cgstream import CLOCK_HZ, CgObject, block
from labrig_drivers._cgstream_objects import LABELED_DTYPE, UNLABELED_DTYPE

SUBJECT = 1
ROOT = 1
MARKER_RADIUS_MM = 7.0
LATENCIES_S = {"Data Collected": 0.004, "3D Labelling": 0.0015}
_IDENTITY = (1.0, 0.0, 0.0, 0.0, 1.0, 0.0, 0.0, 0.0, 1.0)


def u32(value: int) -> bytes:
    """A u32, the low 32 bits of `value`."""
    return struct.pack("<I", value & 0xFFFFFFFF)


def text(value: str) -> bytes:
    """A counted UTF-8 string."""
    data = value.encode()
    return u32(len(data)) + data


def vector(items: Iterable[bytes]) -> bytes:
    """A counted sequence of encoded items."""
    items = list(items)
    return u32(len(items)) + b"".join(items)


def doubles(*values: float) -> bytes:
    """f64 values."""
    return struct.pack(f"<{len(values)}d", *values)


@dataclass(frozen=True)
class Scene:
    """What a server says once: subject and marker names, rate, and whether y is up.

    The subject has one root segment of its own name, which Vicon's clients ask for.
    """

    subject: str
    marker_names: tuple[str, ...]
    rate_hz: float = 100.0
    y_up: bool = False

    def static_blocks(self) -> dict[int, bytes]:
        """Encoded blocks of the static objects, by number."""
        bounds = struct.pack("<6f", *[0.0] * 6)
        ids = range(1, len(self.marker_names) + 1)
        info = (
            u32(SUBJECT)
            + text(self.subject)
            + vector([u32(0) + u32(ROOT) + bounds + text(self.subject)])
            + vector(u32(i) + text(n) for i, n in zip(ids, self.marker_names, strict=True))
            + vector(u32(i) + u32(ROOT) for i in ids)
        )
        topology = u32(SUBJECT) + vector([u32(ROOT) + doubles(0, 0, 0, *_IDENTITY)])
        payloads = {
            CgObject.STREAM_INFO: struct.pack("<q", round(CLOCK_HZ / self.rate_hz)),
            CgObject.SUBJECT_INFO: info,
            CgObject.APPLICATION_INFO: struct.pack("<b", int(self.y_up)),
            CgObject.SUBJECT_TOPOLOGY: topology,
        }
        return {int(number): block(number, payload) for number, payload in payloads.items()}

    def frame_blocks(
        self,
        number: int,
        position_mm: NDArray[np.float64],
        time_s: float,
        ghosts_mm: NDArray[np.float64] | None = None,
        rest_mm: NDArray[np.float64] | None = None,
    ) -> dict[int, bytes]:
        """Encoded blocks of the dynamic objects of frame `number` (as FrameInfo counts), by number.

        `position_mm` (M, 3), z up; rows that are not finite are occluded, that is: left out. `ghosts_mm`
        (U, 3) are unlabelled reconstructions. The root segment moves as the seen markers do on average.
        """
        position_mm = self._turned(position_mm)
        seen = np.flatnonzero(np.isfinite(position_mm).all(axis=1))
        root = self._root(position_mm, seen, rest_mm)
        segment = u32(SUBJECT) + vector([u32(ROOT) + doubles(*root, *_IDENTITY)])
        light = u32(SUBJECT) + vector([u32(ROOT) + struct.pack("<6f", *root, 0.0, 0.0, 0.0)])
        ghosts_mm = np.zeros((0, 3)) if ghosts_mm is None else self._turned(ghosts_mm)
        payloads = {
            CgObject.FRAME_INFO: u32(number),
            CgObject.HARDWARE_FRAME: u32(number),
            CgObject.TIMECODE: timecode(time_s),
            CgObject.LATENCY_INFO: vector(text(n) + doubles(s) for n, s in LATENCIES_S.items()),
            CgObject.FRAME_RATE_INFO: vector([text("System") + doubles(self.rate_hz)]),
            CgObject.LABELED_RECONS: labeled(position_mm, seen),
            CgObject.UNLABELED_RECONS: unlabeled(ghosts_mm),
            CgObject.LOCAL_SEGMENTS: segment,
            CgObject.GLOBAL_SEGMENTS: segment,
            CgObject.LIGHTWEIGHT_SEGMENTS: light,
            CgObject.SUBJECT_HEALTH: u32(SUBJECT) + doubles(len(seen) / max(1, len(position_mm)), 0.0),
            CgObject.OBJECT_QUALITY: u32(SUBJECT) + doubles(len(seen) / max(1, len(position_mm))),
        }
        return {int(number): block(number, payload) for number, payload in payloads.items()}

    def _turned(self, position_mm: NDArray[np.float64]) -> NDArray[np.float64]:
        return position_mm[:, (0, 2, 1)] * (1.0, 1.0, -1.0) if self.y_up else position_mm

    def _root(
        self,
        position_mm: NDArray[np.float64],
        seen: NDArray[np.intp],
        rest_mm: NDArray[np.float64] | None,
    ) -> Sequence[float]:
        if len(seen) == 0:
            return (0.0, 0.0, 0.0)
        if rest_mm is None:
            return position_mm[seen].mean(axis=0).tolist()
        rest_mm = self._turned(rest_mm)
        moved = (position_mm[seen] - rest_mm[seen]).mean(axis=0)
        return (rest_mm.mean(axis=0) + moved).tolist()


def labeled(position_mm: NDArray[np.float64], seen: NDArray[np.intp]) -> bytes:
    """LabeledRecons of the markers in rows `seen`; the marker in row i has number i + 1."""
    records = np.zeros(len(seen), LABELED_DTYPE)
    records["subject"] = SUBJECT
    records["marker"] = seen + 1
    records["radius"] = MARKER_RADIUS_MM
    records["position"] = position_mm[seen]
    records["trajectory"] = 1000 + seen
    return u32(len(seen)) + records.tobytes()


def unlabeled(position_mm: NDArray[np.float64]) -> bytes:
    """UnlabeledRecons at these positions (U, 3)."""
    records = np.zeros(len(position_mm), UNLABELED_DTYPE)
    records["radius"] = MARKER_RADIUS_MM
    records["position"] = position_mm
    records["trajectory"] = 5000 + np.arange(len(position_mm))
    return u32(len(position_mm)) + records.tobytes()


def timecode(time_s: float) -> bytes:
    """The time of day (UTC) at 25 frames a second."""
    at = time.gmtime(time_s)
    frames = int((time_s % 1.0) * 25)
    return struct.pack("<BBBBHHIIB", at.tm_hour, at.tm_min, at.tm_sec, frames, 0, 0, 0, 0, 0)


def contents(counts: dict[int, int], unchanged: Iterable[int]) -> bytes:
    """Contents: the number of blocks of each object, and the objects that are as before."""
    return vector(u32(n) + u32(c) for n, c in sorted(counts.items())) + vector(
        u32(n) for n in sorted(unchanged)
    )
