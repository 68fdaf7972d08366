"""OpenPneu boards: two dialects over a serial port or a socket, as a `PressureWire`."""

import contextlib
import time
from collections import deque
from collections.abc import Callable, Sequence
from dataclasses import dataclass
from typing import Literal

import numpy as np
from numpy.typing import NDArray

from labrig_drivers._openpneu_stream import SENSORS, Reply, StreamParser, Telemetry
from labrig_drivers._pressure_wire import WireError
from labrig_drivers._recording import RecordedLink, Recorder
from labrig_drivers._transport import Link, LinkError, open_link

Dialect = Literal["auto", "published", "table"]
Build = Literal["published", "full"]

CONTROLLED_KPA = 100.0
REPLY_S = 0.5
TRIES = 3
FIND_S = 5.0  # a board that boots slowly, on a computer that is busy
MAX_PENDING = 4096
ASK_HZ = 20.0  # sets of readings a second in the dialect without telemetry


@dataclass(frozen=True)
class OpenPneuOptions:
    """How to reach a board; times in s.

    `outputs` are the board's channels in the order of the chambers. `build` says what firmware runs:
    `published` sets the even and the odd channel of a pair together, `full` sets each on its own. The
    board resets when its port is opened and listens again after `boot_s`.
    """

    port: str
    outputs: tuple[int, ...]
    dialect: Dialect = "auto"
    build: Build = "published"
    baudrate: int = 115200
    boot_s: float = 1.5
    timeout_s: float = 3.0


def check_limits(outputs: Sequence[int], names: Sequence[str], low: Sequence[float], high: Sequence[float]):
    """A line that says what the board cannot do of this, or None. Above 100 kPa its controller does nothing."""
    if len(set(outputs)) != len(outputs) or any(not 0 <= n < SENSORS for n in outputs):
        return f"outputs {list(outputs)} are not different channels from 0 to {SENSORS - 1}"
    for output, name, minimum, maximum in zip(outputs, names, low, high, strict=True):
        floor = -CONTROLLED_KPA if output % 2 == 0 else 0.0
        if minimum < floor or maximum > CONTROLLED_KPA:
            return (
                f"{name} on channel {output} may not be set from {minimum:g} to {maximum:g} kPa: "
                f"the board controls {floor:g} to {CONTROLLED_KPA:g} kPa there"
            )
    return None


def check_pairs(outputs: Sequence[int], names: Sequence[str]) -> Callable[[NDArray[np.float64]], str | None]:
    """A check of set-points for the published firmware, where one target serves a pair of channels."""

    def check(pressure_kpa: NDArray[np.float64]) -> str | None:
        first: dict[int, int] = {}
        for index, output in enumerate(outputs):
            other = first.setdefault(output // 2, index)
            if pressure_kpa[index] != pressure_kpa[other]:
                return (
                    f"{names[other]} and {names[index]} are one pair and get one target on the published "
                    "firmware: set them alike, or declare `build: full` if the board's is"
                )
        return None

    return check


class OpenPneuWire:
    """Speaks to a board. The published dialect streams its sensors; the other one is asked for each."""

    def __init__(self, options: OpenPneuOptions, recorder: Recorder | None = None) -> None:
        self._options = options
        self._recorder = recorder
        self._link: Link | None = None
        self._parser = StreamParser()
        self._replies: deque[str] = deque(maxlen=64)
        self._measured: deque[NDArray[np.float64]] = deque(maxlen=MAX_PENDING)
        self._dialect: Dialect = "auto"
        self._written: dict[int, float] = {}
        self._partial: list[float] = []
        self._missed = 0
        self._late = False
        self._refused = ""
        self._next_round = 0.0
        self._noise = b""

    @property
    def dialect(self) -> Dialect:
        """The dialect in use; `auto` before the board has answered."""
        return self._dialect

    def open(self) -> None:
        """Open the port, wait for the board, find its dialect, set 0 everywhere, start the measurements."""
        options = self._options
        link = open_link(options.port, options.baudrate, options.timeout_s)
        self._link = link if self._recorder is None else RecordedLink(link, self._recorder)
        self._parser = StreamParser()
        self._measured.clear()
        self._written.clear()
        self._missed = 0
        self._late = False
        self._noise = b""
        self._wait(options.boot_s)
        self._dialect = self._detect()
        self._start()

    def identify(self) -> tuple[str, dict[str, str]]:
        """The board's name and version in its own words."""
        if self._dialect == "published":
            questions = {"address": ("AT+ADDRESS", _no_news), "version": ("AT+VERSION", _no_news)}
        else:
            questions = {"address": ("AT+ADD", _is_address)}
        details = {}
        for name, (line, accept) in questions.items():
            try:
                details[name] = self._ask(line, accept, tries=1)
            except WireError:  # a board that will not say who it is can still be used
                details[name] = "not stated"
        details |= {"dialect": self._dialect, "build": self._options.build, "port": self._options.port}
        return f"OpenPneu ({self._dialect} dialect) at {self._options.port}", details

    def write(self, pressure_kpa: NDArray[np.float64]) -> None:
        """Send the targets that changed, and see that the board refused none; `WireError` where it does."""
        published = self._dialect == "published"
        pairs = published and self._options.build == "published"
        targets: dict[int, float] = {}
        for output, value in zip(self._options.outputs, pressure_kpa.tolist(), strict=True):
            targets.setdefault(output - output % 2 if pairs else output, round(value, 2))
        (self._set_published if published else self._set_table)(targets)

    def poll(self, timeout_s: float) -> list[NDArray[np.float64]]:
        """The measurements that have come in; in the table's dialect, asks for the next channel's."""
        if self._dialect == "table":
            if self._partial or time.monotonic() >= self._next_round:
                self._read_next()
            else:
                self._receive(timeout_s)
        elif not self._measured:
            self._receive(timeout_s)
        measured = list(self._measured)
        self._measured.clear()
        return measured

    def stop(self) -> None:
        """Pumps off and valves to the deflate side (`V`), targets 0, then run again: to see, and hold, 0."""
        if self._dialect == "published":
            self._send("V")
            self._wait(0.05)
        self._start()

    def close(self) -> None:
        """Pumps off, valves to the deflate side; release the port."""
        link, self._link = self._link, None
        if link is not None:
            with contextlib.suppress(LinkError):
                if self._dialect != "auto":
                    link.write(b"V\r\n" if self._dialect == "published" else b"COFF\r\n")
            link.close()
        self._dialect = "auto"

    def _start(self) -> None:
        self._written.clear()
        self._partial = []  # a set of readings that was begun before shows what was then
        self.write(np.zeros(len(self._options.outputs)))
        with contextlib.suppress(WireError):  # what it answers is for a person; the readings tell
            if self._dialect == "published":
                self._ask("C", lambda text: text.startswith("Timer"), tries=1)
            else:
                self._ask("CON", _anything, tries=1)

    def _detect(self) -> Dialect:
        found_by = time.monotonic() + FIND_S
        while time.monotonic() < found_by:
            self._replies.clear()
            self._send("AT")
            deadline = time.monotonic() + REPLY_S
            while time.monotonic() < deadline:
                self._receive(0.02)
                while self._replies:
                    text = self._replies.popleft()
                    if text in ("OK;Successful", "OK"):
                        found: Dialect = "published" if text != "OK" else "table"
                        if self._options.dialect not in ("auto", found):
                            raise WireError(
                                f"the board at {self._options.port} speaks the {found} dialect, not "
                                f"{self._options.dialect}: correct `dialect`, or leave it out"
                            )
                        return found
        heard = f"; it sends {self._noise[:40]!r}" if self._noise else ""
        raise WireError(
            f"no OpenPneu board answers AT at {self._options.port}{heard} (right port, "
            f"{self._options.baudrate} baud, power on?)"
        )

    def _changed(self, targets: dict[int, float]) -> dict[int, float]:
        changed = {output: value for output, value in targets.items() if self._written.get(output) != value}
        for output in changed:  # until it is known to have arrived, the board may hold either
            self._written.pop(output, None)
        return changed

    def _set_published(self, targets: dict[int, float]) -> None:
        # T= is answered only where it is refused, and before the answer to what is asked next.
        for _ in range(TRIES):
            changed = self._changed(targets)
            if not changed:
                return
            self._refused = ""
            for output, value in changed.items():
                self._ask(f"SC={output}", _anything)
                self._send(f"T={value:.2f}")
            self._ask("AT", lambda text: text == "OK;Successful")
            if not self._refused:
                self._written |= changed
                return
            self._written.clear()  # it may be SC= that was refused: another channel got the target then
        raise WireError(f"the board at {self._options.port}: {self._refused!r} to set-points")

    def _set_table(self, targets: dict[int, float]) -> None:
        for output, value in self._changed(targets).items():
            self._ask(f"PSET={output},{value:.2f}", lambda text, n=output: text.startswith(f"{n}="))
            self._written[output] = value

    def _read_next(self) -> None:
        if not self._partial:
            self._next_round = max(self._next_round + 1.0 / ASK_HZ, time.monotonic())
        output = self._options.outputs[len(self._partial)]
        try:
            self._catch_up()
            text = self._ask(f"PREAD={output}", lambda text: text.startswith("Val="), tries=1)
            value = float(text.removeprefix("Val="))
        except (WireError, ValueError) as error:
            self._missed += 1
            self._partial = []
            if self._missed >= TRIES:
                raise WireError(f"cannot read channel {output}: {error}") from None
            return
        self._missed = 0
        self._partial.append(value)
        if len(self._partial) == len(self._options.outputs):
            self._measured.append(np.array(self._partial))
            self._partial = []

    def _catch_up(self) -> None:
        # Val= does not say of which channel: one that comes late would be taken for the next channel's.
        if self._late:
            self._ask("AT+ADD", _is_address, tries=1)
            self._late = False

    def _ask(self, line: str, accept: Callable[[str], bool], tries: int = TRIES) -> str:
        problem = ""
        for _ in range(tries):
            self._receive(0.0)
            self._replies.clear()
            self._send(line)
            deadline = time.monotonic() + REPLY_S
            problem, refused = f"no answer to {line}", False
            while time.monotonic() < deadline:
                self._receive(0.02)
                while self._replies:
                    text = self._replies.popleft()
                    if text.startswith("Error"):
                        problem, refused = f"{text!r} to {line}", True
                    elif accept(text):
                        return text
                if refused:
                    break
            else:
                self._late = True
        raise WireError(f"the board at {self._options.port}: {problem}")

    def _send(self, line: str) -> None:
        if self._link is None:
            raise LinkError("the port is not open")
        self._link.write(line.encode("ascii") + b"\r\n")

    def _wait(self, duration_s: float) -> None:
        deadline = time.monotonic() + duration_s
        while (left_s := deadline - time.monotonic()) > 0:
            self._receive(min(left_s, 0.05))
        self._replies.clear()

    def _receive(self, timeout_s: float) -> None:
        if self._link is None:
            raise LinkError("the port is not open")
        data = self._link.read(timeout_s)
        self._noise = (self._noise + data)[-64:]
        for event in self._parser.feed(data):
            if isinstance(event, Telemetry):
                values = np.array(event.pressure_kpa)
                self._measured.append(values[list(self._options.outputs)])
            elif isinstance(event, Reply):
                self._replies.append(event.text)
                if event.text.startswith("Error"):
                    self._refused = event.text


def _anything(text: str) -> bool:
    return bool(text)


def _is_address(text: str) -> bool:
    return text.startswith("ADD=")


def _no_news(text: str) -> bool:
    """Not one of the lines with which the board tells that it runs or stops; they may come late."""
    return bool(text) and not text.startswith(("Timer", "Stop"))
