"""A vent from outside a run, whoever holds the link to the chambers just now, confirmed by reading."""

import contextlib
import os
import signal
import threading
import time
from collections.abc import Callable, Iterator
from dataclasses import dataclass
from typing import Any

import numpy as np

from labrig._errors import LabrigError
from labrig._running import GoneError, Note, SilentError, notes
from labrig.rig._asked import link_of
from labrig.rig._config import RigConfig
from labrig.rig._factory import device_maker
from labrig.rig._last_words import by_hand, impatient
from labrig_drivers import DeviceError, RealClock, VentNotConfirmedError

NOBODY = "nobody: the rig is simulated inside a run, and none goes on"
"""Who vents a rig that is there in its runs only, between two of them."""

_RETRY_S = 0.3
_ASK_S = 5.0
_LOOKS_S = 2.0
_LETS_S = 1.0


@dataclass(frozen=True)
class VentNow:
    """A confirmed vent: what each chamber reads, kPa (None: it has no sensor), how long it took, and who did it."""

    pressure_kpa: dict[str, float | None]
    took_s: float
    by: str


def vent_now(
    config: RigConfig,
    why: str = "somebody who asked for a vent",
    tell: Callable[[str], None] = lambda _text: None,
) -> VentNow:
    """Vent a rig, also while a run goes on, which ends then; tries again for the rig's `vent_patience_s`.

    The guard of a run vents, if there is one: it holds the link. A guard that is stopped is ended. Where nobody holds
    the link it is opened here. A rig that is simulated inside its run has no link: its run ends, vented. An
    investigation on the rig ends, also between two runs. `tell` hears why an attempt failed, and of one that takes
    long. Raises `VentNotConfirmedError` when no reading confirmed it.
    """
    began = time.monotonic()
    with _no_next_run(config, why), impatient(tell) as unsaid:

        def say(text: str) -> None:
            unsaid.cancel()
            tell(text)

        return _until(config, why, began, say)


def _until(config: RigConfig, why: str, began: float, tell: Callable[[str], None]) -> VentNow:
    end = began + config.safety.vent_patience_s
    while True:
        try:
            pressure_kpa, by = _attempt(config, why)
        except (LabrigError, DeviceError) as error:
            problem = str(error).removeprefix("pressure: ")
        else:
            named = dict(zip((chamber.name for chamber in config.chambers), pressure_kpa, strict=True))
            return VentNow(named, time.monotonic() - began, by)
        if time.monotonic() >= end:
            raise VentNotConfirmedError(by_hand(f"rig {config.name}: {problem}"))
        tell(problem)
        time.sleep(_RETRY_S)


def runs_on(config: RigConfig) -> list[Note]:
    """The runs that go on with this rig now, the latest first; also those of other rig files that reach the same."""
    link = link_of(config)
    return [note for note in notes("run") if _concerns(note, config, link)]


def investigations_on(config: RigConfig) -> list[Note]:
    """The investigations that go on with this rig now, also those between two runs; each was asked and lives."""
    link = link_of(config)
    return [note for note in notes("investigation") if _concerns(note, config, link) and is_there(note)]


def is_there(note: Note) -> bool:
    """Whether a process that left a note is still there; one that is stopped, or hangs, is."""
    try:
        note.ask("status", _LOOKS_S)
    except LabrigError as error:
        return isinstance(error, SilentError) or not isinstance(error, GoneError)
    return True


def users_of(config: RigConfig) -> frozenset[str]:
    """Names of the processes that may fill the rig now: its runs, and the guards that hold its link.

    Each process has a name of its own, so one that is not among those of before has begun since.
    """
    link = link_of(config)
    guards = [note for note in notes("guard") if link and note.facts.get("link") == link]
    return frozenset(note.path.name for note in [*runs_on(config), *guards])


@contextlib.contextmanager
def _no_next_run(config: RigConfig, why: str) -> Iterator[None]:
    """Meanwhile ask the investigations on the rig to end: none fills again what is vented. It delays no vent."""

    def ask() -> None:
        link = link_of(config)
        for note in [each for each in notes("investigation") if _concerns(each, config, link)]:
            with contextlib.suppress(LabrigError):
                note.ask("end", _LOOKS_S, why=why)

    asking = threading.Thread(target=ask, name="labrig investigations end", daemon=True)
    asking.start()
    try:
        yield
    finally:
        asking.join(_LETS_S)  # one that is stopped hears of it when it goes on


def _concerns(note: Note, config: RigConfig, link: str) -> bool:
    if link:
        return note.facts.get("link") == link
    return (
        note.facts.get("rig_folder") == str(config.folder.resolve()) and note.facts.get("rig") == config.name
    )


def _attempt(config: RigConfig, why: str) -> tuple[list[float | None], str]:
    """One attempt: each chamber's pressure, kPa, and who vented; raises what kept it from being confirmed."""
    link, timeout_s = link_of(config), config.safety.vent_timeout_s + _ASK_S
    if not link:
        return _by_run(config, why, timeout_s)
    for note in notes("guard"):
        if note.facts.get("link") != link:
            continue
        try:
            answer = note.ask("vent", timeout_s, why=why)
        except SilentError:
            _end(note)
            continue
        except GoneError:
            continue
        for run in runs_on(config):  # it is over for it already; this only says why
            with contextlib.suppress(LabrigError):
                run.ask("end", 1.0, why=why)
        return _plain(answer["pressure_kpa"]), f"the guard of {note.facts.get('run') or 'a run'}"
    return _from_here(config), "this process"


def _by_run(config: RigConfig, why: str, timeout_s: float) -> tuple[list[float | None], str]:
    """End the run that simulates this rig; it answers once it is vented."""
    for run in runs_on(config):
        with contextlib.suppress(GoneError):
            answer = run.ask("vent", timeout_s, why=why)
            return _plain(answer["pressure_kpa"]), f"the run {run.facts.get('folder')}"
    nothing: list[float | None] = [0.0] * len(config.chambers)
    return nothing, NOBODY


def _from_here(config: RigConfig) -> list[float | None]:
    device = device_maker(config, "pressure", config.pressure, RealClock())()
    try:
        device.connect()
        return _plain(device.vent(config.safety.vent_timeout_s).pressure_kpa)
    finally:
        device.close()


def _end(note: Note) -> None:
    """End a guard that is stopped: it holds the link, and nobody else can vent meanwhile.

    One that is gone, as after a power cut, has left its number to somebody else, who is not touched.
    """
    if note.is_stale:
        note.remove()
        return
    with contextlib.suppress(OSError):
        os.kill(note.pid, getattr(signal, "SIGKILL", signal.SIGTERM))  # Windows has one way to end a process
    note.remove()


def _plain(pressure_kpa: Any) -> list[float | None]:
    return [float(value) if np.isfinite(value) else None for value in np.asarray(pressure_kpa, float)]
