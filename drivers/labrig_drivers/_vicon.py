"""Motion capture from a Vicon DataStream server, over labrig's own client."""

import contextlib
import itertools
import threading
import time
from collections import deque
from collections.abc import Mapping, Sequence
from dataclasses import dataclass, field

import numpy as np
from numpy.typing import NDArray

from labrig_drivers._cgstream import CgstreamError
from labrig_drivers._cgstream_objects import Subject, Timecode
from labrig_drivers._cgstream_session import CgFrame, ClientSession, Mode
from labrig_drivers._clock import Clock
from labrig_drivers._protocols import DeviceError, Identity, MarkerFrame, MarkerStatus
from labrig_drivers._recording import RecordedLink, Recorder
from labrig_drivers._transport import Link, LinkError, TcpLink
from labrig_drivers._vicon_markers import MarkerTable, Up

READ_S = 0.05
MAX_BURST_S = 1.0
RETRY_S = (0.1, 0.2, 0.5, 1.0, 2.0)


@dataclass(frozen=True)
class ViconFrame(MarkerFrame):
    """A marker frame with what else the server says of it.

    `time_s` is the host's time of arrival less `latency_s`. `unlabeled_mm` has shape (U, 3);
    `hardware_number` and `timecode` are None when the server does not send them.
    """

    latency_s: float = 0.0
    rate_hz: float = float("nan")
    hardware_number: int | None = None
    timecode: Timecode | None = None
    unlabeled_mm: NDArray[np.float64] = field(default_factory=lambda: np.zeros((0, 3)))


@dataclass(frozen=True)
class ViconOptions:
    """How to reach a server and how long to wait for it; times in s.

    `timeout_s` bounds the connection and the greeting, `subscribe_s` the wait for the requested types,
    `stale_after_s` is the age at which markers without news count as stale, `silence_s` opens a silent
    connection anew, and after `lost_after_s` without a connection `frames()` raises.
    """

    host: str = "127.0.0.1"
    port: int = 801
    subject: str | None = None
    up: Up = "z"
    mm_per_unit: float = 1.0
    rename: Mapping[str, str] = field(default_factory=dict)
    mode: Mode = "push"
    timeout_s: float = 5.0
    subscribe_s: float = 2.0
    stale_after_s: float = 0.25
    silence_s: float = 30.0
    lost_after_s: float = 30.0
    max_frames: int = 16384


class Vicon:
    """A `MotionCapture` that streams from a Vicon DataStream server.

    A thread reads; `frames()` hands over what it has collected, at most `max_frames` (the oldest go first;
    `dropped` counts them). When the server goes away the thread connects again and subscribes anew; until
    then every marker is STALE.
    """

    def __init__(
        self,
        name: str,
        marker_names: Sequence[str],
        clock: Clock,
        options: ViconOptions,
        recorder: Recorder | None = None,
    ) -> None:
        self.name = name
        self.marker_names = tuple(marker_names)
        self.dropped = 0
        self.reconnects = 0
        self.bad_packets = 0
        self._clock = clock
        self._options = options
        self._recorder = recorder
        self._table = self._new_table(options.subject)
        self._frames: deque[ViconFrame] = deque(maxlen=options.max_frames)
        self._session = ClientSession()
        self._link: Link | None = None
        self._thread: threading.Thread | None = None
        self._stop = threading.Event()
        self._problem = ""
        self._lost_at: float | None = None
        self._last_frame_at = 0.0
        self._last_stale_at = 0.0
        self._last_number = -1
        self._last_time_s = float("-inf")

    def connect(self) -> None:
        """Open the link, wait for the server's greeting, subscribe, and begin to stream."""
        if self._thread is not None:
            if self._thread.is_alive():
                return
            self._end()
        self._stop.clear()
        try:
            self._link, self._session = self._open()
        except (LinkError, CgstreamError) as error:
            raise DeviceError(f"{self.name}: {error}") from None
        self._lost_at = None
        self._last_frame_at = time.monotonic()
        self._thread = threading.Thread(target=self._run, name=f"{self.name}-reader", daemon=True)
        self._thread.start()
        if not self.marker_names:
            self._take_all_markers()

    def identify(self) -> Identity:
        """What the server offers: rate, subjects and their numbers of markers; waits for the first frame."""
        if self._thread is None:
            raise DeviceError(f"{self.name}: not connected")
        self._wait_for_subjects()
        statics = self._session.statics
        subjects = {s.name: f"{len(s.markers)} markers" for s in statics.subjects.values()}
        axis = "y" if statics.y_up else "z"
        return Identity(
            self.name,
            "vicon",
            f"Vicon DataStream at {self._options.host}:{self._options.port}, {statics.rate_hz:g} Hz",
            {"up": axis, **{f"subject {name}": text for name, text in subjects.items()}},
        )

    def frames(self) -> list[MarkerFrame]:
        """Every frame since the last call, oldest first.

        When nothing has arrived for `stale_after_s`, one frame without positions, all markers STALE, is
        returned in each such span. `DeviceError` when there has been no connection for `lost_after_s`.
        """
        if self._thread is None:
            raise DeviceError(f"{self.name}: not connected")
        frames: list[MarkerFrame] = []
        while self._frames:
            frame = self._frames.popleft()
            if len(frame.status) == len(self.marker_names):  # not from before the markers were known
                frames.append(frame)
        if not frames:
            self._raise_if_lost()
            now = time.monotonic()
            silent_since = max(self._last_frame_at, self._last_stale_at)
            if now - silent_since > self._options.stale_after_s:
                self._last_stale_at = now
                frames.append(self._stale_frame())
        return frames

    def close(self) -> None:
        """Stop streaming and release the link; never raises."""
        self._end()
        if self._recorder is not None:
            self._recorder.close()

    def _end(self) -> None:
        self._stop.set()
        thread, self._thread = self._thread, None
        if thread is not None:
            thread.join()

    def _take_all_markers(self) -> None:
        """The subject's markers, for a rig that names none."""
        subject, subjects = self._options.subject, self._wait_for_subjects()
        found = [known for known in subjects if subject in (None, known.name)]
        if len(found) != 1 or not found[0].markers:
            self.close()
            there = ", ".join(repr(known.name) for known in subjects) or "no subject at all"
            wanted = "no markers are named" if subject is None else f"subject is {subject!r}"
            raise DeviceError(
                f"{self.name}: {wanted}, and the server at {self._options.host}:"
                f"{self._options.port} has {there}: set `subject` to one of them"
            )
        self.marker_names = tuple(found[0].markers.values())
        self._table = self._new_table(found[0].name)
        self._frames.clear()

    def _new_table(self, subject: str | None) -> MarkerTable:
        options = self._options
        return MarkerTable(self.marker_names, subject, options.rename, options.up, options.mm_per_unit)

    def _wait_for_subjects(self) -> list[Subject]:
        deadline = time.monotonic() + self._options.timeout_s
        while not self._session.statics.subjects and time.monotonic() < deadline:
            self._raise_if_lost()
            time.sleep(0.01)
        return list(self._session.statics.subjects.values())

    def _open(self) -> tuple[Link, ClientSession]:
        options = self._options
        link: Link = TcpLink(options.host, options.port, options.timeout_s)
        if self._recorder is not None:
            link = RecordedLink(link, self._recorder)
        session = ClientSession(mode=options.mode)
        deadline = time.monotonic() + options.timeout_s
        where = f"{options.host}:{options.port}"
        early: list[CgFrame] = []
        try:
            while session.offered is None:
                if time.monotonic() > deadline or self._stop.is_set():
                    raise LinkError(
                        f"{where} accepts connections but sends no DataStream greeting within "
                        f"{options.timeout_s:g} s (is that the port of the DataStream server? Vicon's is 801)"
                    )
                try:
                    early = session.receive(link.read(READ_S))
                except CgstreamError as error:
                    raise LinkError(f"{where} is no Vicon DataStream server: {error}") from None
            link.write(session.outgoing())
        except LinkError:
            link.close()
            raise
        for frame in early:  # a server may stream at once
            self._keep(frame, self._clock.now_s() - _behind_s(frame, early[-1]))
        return link, session

    def _run(self) -> None:
        while not self._stop.is_set():
            if self._link is not None:
                try:
                    self._stream(self._link, self._session)
                except (LinkError, CgstreamError) as error:
                    self._problem = str(error)
                self._link.close()
                self._link = None
                self._lost_at = time.monotonic()
            else:
                self._reconnect()
        if self._link is not None:
            self._link.close()
            self._link = None

    def _reconnect(self) -> None:
        for attempt in itertools.count():
            pause_s = RETRY_S[min(attempt, len(RETRY_S) - 1)]
            if self._stop.wait(pause_s):
                return
            try:
                self._link, self._session = self._open()
            except (LinkError, CgstreamError) as error:
                self._problem = str(error)
                continue
            self._lost_at = None
            self.reconnects += 1
            return

    def _stream(self, link: Link, session: ClientSession) -> None:
        options = self._options
        began = heard = asked = time.monotonic()
        while not self._stop.is_set():
            data = link.read(READ_S)
            arrived_s, now = self._clock.now_s(), time.monotonic()
            if data:
                heard = now
                frames = session.receive(data)
                for frame in frames:
                    self._keep(frame, arrived_s - _behind_s(frame, frames[-1]))
                    asked = now
                self.bad_packets = session.bad_packets
            elif now - heard > options.silence_s:
                raise LinkError(f"{options.host}:{options.port} has been silent for {options.silence_s:g} s")
            if session.waiting and now - began > options.subscribe_s:
                session.accept_all()
            if options.mode != "push" and now - asked > 1.0:
                session.request()
                asked = now
            out = session.outgoing()
            if out:
                link.write(out)

    def _keep(self, frame: CgFrame, arrived_s: float) -> None:
        position, status = self._table.place(frame)
        number = self._last_number + 1 if frame.number is None else frame.number
        if number == self._last_number:  # sent again: no news of the markers that it shows
            position[status == MarkerStatus.SEEN] = np.nan
            status[status == MarkerStatus.SEEN] = MarkerStatus.STALE
        self._last_number = number
        time_s = arrived_s - frame.latency_s
        if 0.0 < self._last_time_s - time_s < 1.0:  # the latency varies; time does not run backward for that
            time_s = self._last_time_s
        self._last_time_s = time_s
        if len(self._frames) == self._frames.maxlen:
            self.dropped += 1
        unlabeled = self._table.to_mm(frame.unlabeled["position"], frame.statics.y_up)
        self._frames.append(
            ViconFrame(
                time_s,
                number,
                position,
                status,
                frame.latency_s,
                frame.statics.rate_hz,
                frame.hardware_number,
                frame.timecode,
                unlabeled,
            )
        )
        self._last_frame_at = time.monotonic()

    def _stale_frame(self) -> MarkerFrame:
        count = len(self.marker_names)
        status = np.full(count, MarkerStatus.STALE, np.int8)
        return ViconFrame(self._clock.now_s(), self._last_number, np.full((count, 3), np.nan), status)

    def _raise_if_lost(self) -> None:
        lost_at = self._lost_at
        if lost_at is not None and time.monotonic() - lost_at > self._options.lost_after_s:
            raise DeviceError(
                f"{self.name}: no connection for {time.monotonic() - lost_at:.0f} s: {self._problem}"
            )
        thread = self._thread
        if thread is not None and not thread.is_alive():
            with contextlib.suppress(Exception):
                self.close()
            raise DeviceError(f"{self.name}: the reader stopped unexpectedly; connect again")


def _behind_s(frame: CgFrame, last: CgFrame) -> float:
    """How much earlier than the last frame of a burst this one was taken, s, by their numbers and the rate."""
    if frame.number is None or last.number is None:
        return 0.0
    behind_s = (last.number - frame.number) / last.statics.rate_hz
    return behind_s if 0.0 <= behind_s <= MAX_BURST_S else 0.0  # NaN: the rate is not known
