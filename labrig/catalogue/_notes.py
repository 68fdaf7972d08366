"""Say something of a run: tags, notes, and what was ruled out in it."""

import time
from collections.abc import Iterator, Sequence
from contextlib import contextmanager
from pathlib import Path

import yaml

from labrig._durable import write_whole
from labrig._errors import LabrigError
from labrig._near import meant
from labrig.log import NOTES, Notes, read_notes, segment_paths

_WAIT_S = 5.0
_POLL_S = 0.05
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
    lock = run / f"{NOTES}.partial"
    try:
        _hold(lock)
    except OSError as error:
        raise LabrigError(
            f"{run}: nothing can be written there ({error.strerror or error}), and a run's tags and notes are kept "
            "in its folder"
        ) from None
    try:
        notes = read_notes(run)
        yield notes
        write_whole(run / NOTES, yaml.safe_dump(notes.model_dump(), sort_keys=False, allow_unicode=True))
    finally:
        lock.unlink(missing_ok=True)


def _hold(lock: Path) -> None:
    """Make the file that only one process can make; wait for another that has, unless it was killed.

    What a killed one left does not change; it is removed.
    """
    seen, since_s = None, time.monotonic()
    while True:
        try:
            lock.open("x").close()
            return
        except FileExistsError:
            state = _state(lock)
            if state != seen:
                seen, since_s = state, time.monotonic()
            elif time.monotonic() - since_s > _WAIT_S:
                for left in (lock, *lock.parent.glob(f".{NOTES}.*")):
                    left.unlink(missing_ok=True)
            time.sleep(_POLL_S)


def _state(path: Path) -> int | None:
    try:
        return path.stat().st_mtime_ns
    except FileNotFoundError:
        return None
