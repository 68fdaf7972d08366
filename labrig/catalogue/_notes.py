"""Say something of a run: tags, notes, and what was ruled out in it."""

import os
import threading
import time
from collections.abc import Iterator, Sequence
from contextlib import contextmanager, suppress
from pathlib import Path
from typing import IO

import yaml

from labrig._durable import write_whole
from labrig._errors import LabrigError
from labrig._locks import SOMEBODYS, taken
from labrig._near import meant
from labrig.log import NOTES, Notes, read_notes, segment_paths

_WAIT_S = 10.0
_POLL_S = 0.02
_HERE = threading.Lock()
"""The system's locks are between processes: this one is between the threads of this one."""

_LONGEST_TAG = 60


def tag(run: Path | str, tags: Sequence[str], *, remove: bool = False) -> Notes:
    """Add tags to a run, or remove them; raises `LabrigError` for what is no tag, or not there to be removed."""
    for word in tags:
        _check_tag(word)
    with _changed(Path(run)) as notes:
        for word in tags:
            if not remove:
                notes.tags += [] if word in notes.tags else [word]
            elif word in notes.tags:
                notes.tags.remove(word)
            else:
                has = ", ".join(notes.tags) or "none"
                raise LabrigError(f"{run} has no tag {word!r}{meant(word, notes.tags)} (it has {has})")
    return notes


def note(run: Path | str, text: str) -> Notes:
    """Add a note to a run; raises `LabrigError` for a note without words."""
    if not text.strip():
        raise LabrigError('the note is empty; write it in quotes: labrig note RUN "chamber 3 leaks"')
    with _changed(Path(run)) as notes:
        notes.notes.append(text.strip())
    return notes


def rule_out(run: Path | str, effect: str, sessions: Sequence[str] = (), *, remove: bool = False) -> Notes:
    """Say that an effect cannot act in a run, or in some of its sessions, beside those of before; or take that back.

    Raises `LabrigError` for a word that is no name, for what is not there to be taken back, and for some sessions of a
    run in all of which it is ruled out.
    """
    if not effect.isidentifier():
        raise LabrigError(f"{effect!r} is no name of an effect; labrig effects list has them")
    with _changed(Path(run)) as notes:
        own = notes.ruled_out.get(effect)
        if sessions and own == []:
            raise LabrigError(
                f"{run}: {effect} is ruled out in all of it; take that back first (--remove), then say in which "
                "sessions it is"
            )
        if not remove:
            notes.ruled_out[effect] = list(dict.fromkeys([*(own or ()), *sessions])) if sessions else []
        elif own is None or (other := [session for session in sessions if session not in own]):
            there = "there" if own is None else f"in {', '.join(other)}"
            raise LabrigError(f"{run}: {effect} is not ruled out {there}")
        elif left := [session for session in own if sessions and session not in sessions]:
            notes.ruled_out[effect] = left
        else:
            del notes.ruled_out[effect]
    return notes


def _check_tag(word: str) -> None:
    plain = word.isprintable() and not set(word) & set(" ,'\"")
    if not word or not plain or len(word) > _LONGEST_TAG:
        raise LabrigError(
            f"{word!r} is no tag: a tag is one word of at most {_LONGEST_TAG} signs, without spaces, commas and "
            "quotes; labrig note takes sentences"
        )


@contextmanager
def _changed(run: Path) -> Iterator[Notes]:
    """The notes of a run, to be changed: read and written by one process at a time, and whole or not at all."""
    if run.is_file():
        raise LabrigError(
            f"{run} is one file, and what is said of a run is kept in its folder: name that, or put the log into one "
            "of its own, as log.000.mcap"
        )
    if not run.is_dir() or not segment_paths(run):
        raise LabrigError(f"{run} is no run folder; `labrig runs` lists those in ./runs")
    with _alone(run):
        notes = read_notes(run)
        yield notes
        write_whole(run / NOTES, yaml.safe_dump(notes.model_dump(), sort_keys=False, allow_unicode=True))


@contextmanager
def _alone(run: Path) -> Iterator[None]:
    """Wait until nobody else changes a run's notes, and keep others from it meanwhile."""
    lock = run / f"{NOTES}.lock"
    with _HERE:
        try:
            lock.touch()
        except OSError as error:
            raise LabrigError(
                f"{run}: nothing can be written there ({error.strerror or error}), and a run's tags and notes are kept "
                "in its folder"
            ) from None
        held = _hold(lock)
        try:
            for left in run.glob(f".{NOTES}.*"):  # by a writer that was killed
                left.unlink(missing_ok=True)
            yield
        finally:
            if os.name == "nt":  # which keeps a file that is open
                held.close()
            with suppress(OSError):
                lock.unlink()
            held.close()


def _hold(lock: Path) -> IO[bytes]:
    """The file, locked where the disk knows locks; raises `LabrigError` where another process keeps it."""
    end_s = time.monotonic() + _WAIT_S
    while True:
        try:
            return taken(lock)
        except OSError as error:
            if error.errno not in SOMEBODYS:
                return lock.open("ab")
        if time.monotonic() > end_s:
            raise LabrigError(f"{lock.parent}: another process is changing its notes; try again")
        time.sleep(_POLL_S)
