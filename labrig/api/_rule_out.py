"""rule_out: say of a run that somebody saw to it that an effect could not act in it."""

from collections.abc import Sequence
from pathlib import Path
from typing import TYPE_CHECKING, Any

import numpy as np

from labrig._errors import LabrigError
from labrig._near import meant
from labrig._paths import wrong
from labrig._text import listed
from labrig.api._inputs import runs_of

if TYPE_CHECKING:
    from xarray import Dataset


def rule_out(
    run: Any, effect: str, *, sessions: str | int | Sequence[str | int] = (), remove: bool = False
) -> "Dataset":
    """Say that an effect cannot act in a run: whatever it could touch was taken away, the frame was registered again.

    A diagnosis of this run together with one in which it could act then knows that what looks like the effect must be
    gone here. Of a run folder it is kept in its notes.yaml. Returns the run as `labrig.open_run` gives it from then on.

    Args:
        run: a run folder's path, or a Dataset, which stays as it is.
        effect: its name.
        sessions: the sessions of the run, by name, in which it cannot act, beside those that were named before; by
            default all of it.
        remove: take that back, of these sessions or of all.

    Raises:
        LabrigError: there is no such effect or session, nothing to take back, or some sessions are named of a folder
            in all of which it is ruled out.

    Example:
        >>> run = labrig.rule_out("runs/later", "contact")  # and then: labrig.diagnose(["runs/first", run], ...)
        >>> str(run["ruled_out"].values[0])
        'contact'
    """
    from labrig.catalogue import rule_out as noted
    from labrig.effects import library
    from labrig.log import open_run

    if not isinstance(effect, str):
        raise wrong("an effect", effect, "its name, such as 'contact'")
    sessions = [str(one) for one in ([sessions] if isinstance(sessions, str | int) else sessions)]
    folder = Path(run) if isinstance(run, str | Path) else None
    if not remove:
        known = library(Path.cwd(), *(() if folder is None else (folder.parent,)))
        if effect not in known:
            own = "; those of your own are looked for in effects/, here and beside the run"
            raise LabrigError(f"there is no effect {effect!r}{meant(effect, known) or own}")
    if folder is None or not remove:  # what is to be taken back may be why the folder cannot be opened
        (given,) = runs_of([run])
        there = list(dict.fromkeys(str(v) for v in given["session"].values))
        for session in sessions:
            if session not in there:
                raise LabrigError(f"{_name(run)} has no session {session!r} (it has {listed(there, 'and')})")
        if folder is None:
            return _said(given, effect, sessions, remove)
    noted(folder, effect, sessions, remove=remove)
    return open_run(folder)


def _said(run: "Dataset", effect: str, sessions: Sequence[str], remove: bool) -> "Dataset":
    """The same Dataset with it in its coordinate `ruled_out`."""
    from labrig.effects import ruled_out_in

    before = ruled_out_in(run) or (frozenset[str](),) * run.sizes["capture"]
    if remove and not any(effect in names for names in before):
        raise LabrigError(f"{_name(run)}: {effect} is not ruled out there")
    inside = [not sessions or str(v) in sessions for v in run["session"].values]
    after = [
        (names - {effect} if remove else names | {effect}) if own else names
        for names, own in zip(before, inside, strict=True)
    ]
    return run.assign_coords(ruled_out=("capture", np.array([" ".join(sorted(names)) for names in after])))


def _name(run: Any) -> str:
    return str(run) if isinstance(run, str | Path) else str(run.attrs.get("run") or "the run")
