"""One connection to a DataStream server, from the client's side and without input or output.

Give what arrived to `ClientSession.receive`, send what `ClientSession.outgoing` returns.
"""

import struct
from collections.abc import Iterable, Mapping
from dataclasses import dataclass, field
from typing import Literal

import numpy as np
from numpy.typing import NDArray

from labrig_drivers import _cgstream_objects as objects
from labrig_drivers._cgstream import (
    CLOCK_HZ,
    MAX_PACKET_BYTES,
    STATIC_OBJECTS,
    CgObject,
    CgstreamError,
    PacketReader,
    block,
    blocks,
    is_dynamic,
    packet,
)
from labrig_drivers._cgstream_objects import Subject, Timecode

Mode = Literal["push", "pull", "prefetch"]

WANTED = frozenset(
    {
        CgObject.CONTENTS,
        CgObject.STREAM_INFO,
        CgObject.SUBJECT_INFO,
        CgObject.FRAME_INFO,
        CgObject.LABELED_RECONS,
        CgObject.UNLABELED_RECONS,
        CgObject.TIMECODE,
        CgObject.LATENCY_INFO,
        CgObject.HARDWARE_FRAME,
        CgObject.APPLICATION_INFO,
        CgObject.PING,
    }
)
MAX_BAD_PACKETS = 100
MAX_SUBJECTS = 1000
_NO_LABELED = np.zeros(0, objects.LABELED_DTYPE)
_NO_UNLABELED = np.zeros(0, objects.UNLABELED_DTYPE)


@dataclass(frozen=True)
class Statics:
    """What a server says once: rate (Hz, NaN unknown), subjects by number, and which axis is up."""

    rate_hz: float = float("nan")
    subjects: Mapping[int, Subject] = field(default_factory=dict)
    y_up: bool = False


@dataclass(slots=True)
class CgFrame:
    """One frame as it was sent. `labeled` and `unlabeled` are record arrays, empty when the frame has none.

    `number` is FrameInfo + 1, as Vicon's own clients report it. `types` are the objects that the packet
    carried or declared unchanged.
    """

    number: int | None
    statics: Statics
    types: frozenset[int]
    labeled: NDArray[np.void]
    unlabeled: NDArray[np.void]
    latency_s: float = 0.0
    hardware_number: int | None = None
    timecode: Timecode | None = None


class ClientSession:
    """The client's half of the protocol: subscribes, requests, keeps the statics, decodes frames.

    Frames from before the subscription took effect are dropped (`dropped` counts them): in them every
    marker would look occluded. `accept_all` ends that wait when the requested types never come.
    """

    def __init__(
        self,
        wanted: Iterable[int] = WANTED,
        mode: Mode = "push",
        max_packet_bytes: int = MAX_PACKET_BYTES,
    ) -> None:
        self.offered: frozenset[int] | None = None
        self.subscribed: frozenset[int] = frozenset()
        self.statics = Statics()
        self.dropped = 0
        self.bad_packets = 0
        self.pings_echoed = 0
        self._wanted = frozenset(wanted)
        self._mode: Mode = mode
        self._reader = PacketReader(max_packet_bytes)
        self._outgoing = bytearray()
        self._waiting = True
        self._subjects: dict[int, Subject] = {}
        self._last_labeled = _NO_LABELED
        self._last_unlabeled = _NO_UNLABELED
        self._ping_number = 0
        self._bad_in_a_row = 0

    @property
    def waiting(self) -> bool:
        """Whether frames are still dropped because the requested types have not appeared."""
        return self._waiting

    def accept_all(self) -> None:
        """Pass frames on from now on, whatever they lack."""
        self._waiting = False

    def outgoing(self) -> bytes:
        """What has to be sent now; empties the queue."""
        data = bytes(self._outgoing)
        self._outgoing.clear()
        return data

    def subscribe(self, wanted: Iterable[int]) -> None:
        """Ask for these objects from now on."""
        self._wanted = frozenset(wanted)
        if self.offered is not None:
            self._send_subscription()

    def request(self) -> None:
        """Ask for one frame (pull and prefetch modes), or for the stream again (push mode)."""
        if self._mode == "prefetch":
            self._send(CgObject.REQUEST_NEXT_FRAME, struct.pack("<I", 1))
        else:
            self._send(CgObject.REQUEST_FRAME, b"\x01" if self._mode == "push" else b"\x00")

    def receive(self, data: bytes) -> list[CgFrame]:
        """Take in bytes; returns the frames they complete. `CgstreamError`: the connection is of no use."""
        frames: list[CgFrame] = []
        for body in self._reader.feed(data):
            frame = self._packet_or_none(body)
            if frame is None:
                continue
            if self._mode != "push":
                self.request()
            if CgObject.PING in self.subscribed:
                self._ping_number += 1
                self._send(CgObject.PING, struct.pack("<Q", self._ping_number))
            if self._waiting and self._required() <= frame.types:
                self._waiting = False
            if self._waiting:
                self.dropped += 1
            else:
                frames.append(frame)
        return frames

    def _packet_or_none(self, body: bytes) -> CgFrame | None:
        # A bad block inside a packet of the right length leaves the stream in step: only that packet is lost.
        try:
            frame = self._packet(body)
        except CgstreamError:
            self.bad_packets += 1
            self._bad_in_a_row += 1
            if self._bad_in_a_row >= MAX_BAD_PACKETS:
                raise
            return None
        self._bad_in_a_row = 0
        return frame

    def _required(self) -> frozenset[int]:
        return self.subscribed & {CgObject.FRAME_INFO, CgObject.LABELED_RECONS}

    def _send(self, number: int, payload: bytes) -> None:
        self._outgoing += packet([block(number, payload)])

    def _send_subscription(self) -> None:
        assert self.offered is not None
        self.subscribed = self._wanted & self.offered
        self._waiting = True
        numbers = sorted(self.subscribed)
        self._send(CgObject.OBJECT_ENUMS, struct.pack(f"<{len(numbers) + 1}I", len(numbers), *numbers))

    def _packet(self, body: bytes) -> CgFrame | None:
        received = list(blocks(body))
        types = {number for number, _ in received}
        if CgObject.OBJECT_ENUMS in types:
            self._hello(next(payload for number, payload in received if number == CgObject.OBJECT_ENUMS))
        unchanged: frozenset[int] = frozenset()
        if CgObject.CONTENTS in types:
            contents = next(payload for number, payload in received if number == CgObject.CONTENTS)
            unchanged = objects.decode_contents(contents)[1]
        if types & STATIC_OBJECTS:
            self._replace_statics(received, unchanged)
        if CgObject.PING in types:
            self.pings_echoed += 1
        if not any(is_dynamic(number) for number in types):
            return None
        return self._frame(received, frozenset(types | unchanged), unchanged)

    def _hello(self, payload: bytes) -> None:
        self.offered = objects.decode_set(payload, "ObjectEnums")
        self._send_subscription()
        self.request()

    def _replace_statics(self, received: list[tuple[int, bytes]], unchanged: frozenset[int]) -> None:
        old = self.statics
        keep = unchanged.__contains__
        rate_hz = old.rate_hz if keep(CgObject.STREAM_INFO) else float("nan")
        y_up = old.y_up if keep(CgObject.APPLICATION_INFO) else False
        subjects = dict(old.subjects) if keep(CgObject.SUBJECT_INFO) else {}
        sent: dict[int, Subject] = {}
        for number, payload in received:
            if number == CgObject.STREAM_INFO:
                period = objects.decode_stream_period(payload)
                rate_hz = CLOCK_HZ / period if period > 0 else float("nan")
            elif number == CgObject.SUBJECT_INFO:
                subject = objects.decode_subject(payload)
                sent[subject.id] = subject
                if len(sent) > MAX_SUBJECTS:
                    raise CgstreamError(f"a packet has more than {MAX_SUBJECTS} subjects")
            elif number == CgObject.APPLICATION_INFO:
                y_up = objects.decode_y_up(payload)
        self.statics = Statics(rate_hz, sent or subjects, y_up)

    def _frame(
        self, received: list[tuple[int, bytes]], types: frozenset[int], unchanged: frozenset[int]
    ) -> CgFrame:
        labeled = self._last_labeled if CgObject.LABELED_RECONS in unchanged else _NO_LABELED
        unlabeled = self._last_unlabeled if CgObject.UNLABELED_RECONS in unchanged else _NO_UNLABELED
        frame = CgFrame(None, self.statics, types, labeled, unlabeled)
        for number, payload in received:
            if number == CgObject.FRAME_INFO:
                frame.number = objects.decode_u32(payload, "FrameInfo") + 1
            elif number == CgObject.LABELED_RECONS:
                frame.labeled = objects.decode_labeled(payload)
            elif number == CgObject.UNLABELED_RECONS:
                frame.unlabeled = objects.decode_unlabeled(payload)
            elif number == CgObject.LATENCY_INFO:
                frame.latency_s = objects.decode_latency(payload)
            elif number == CgObject.HARDWARE_FRAME:
                frame.hardware_number = objects.decode_u32(payload, "HardwareFrame")
            elif number == CgObject.TIMECODE:
                frame.timecode = objects.decode_timecode(payload)
        self._last_labeled, self._last_unlabeled = frame.labeled, frame.unlabeled
        return frame


__all__ = ["WANTED", "CgFrame", "CgstreamError", "ClientSession", "Mode", "Statics"]
