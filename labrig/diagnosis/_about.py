"""Which runs and which model a result is about, so that it is found again beside them."""

from collections.abc import Sequence
from pathlib import Path
from typing import TYPE_CHECKING, Any

from labrig._text import with_sessions
from labrig.contents import About, RunNamed
from labrig.effects import ruled_out_in
from labrig.model import Model

if TYPE_CHECKING:
    from xarray import Dataset


def about(runs: "Dataset | Sequence[Dataset]", model: Model) -> About:
    """The fields `runs` and `model` of a result: paths as they were given, what each run is recognised by, and how many
    captures it had: a run that was gone on with has more.
    """
    many: Sequence[Any] = runs if isinstance(runs, list | tuple) else [runs]
    return {
        "runs": [_named(run) for run in many if "run_id" in run.attrs],
        "model": None if model.path is None else model.path.as_posix(),
    }


def _named(run: "Dataset") -> RunNamed:
    """One run, with the effects that were ruled out in some of its captures, if any were."""
    of: RunNamed = {
        "run": Path(run.attrs["run"]).as_posix(),
        "id": run.attrs["run_id"],
        "captures": run.sizes["capture"],
    }
    if words := _ruled_out(run):
        of["ruled_out"] = words
    return of


def _ruled_out(run: "Dataset") -> list[str]:
    """The effects that were ruled out in it, as its notes say them: with the sessions where it is not all of it."""
    each = ruled_out_in(run)
    words = []
    for name in sorted(frozenset[str]().union(*each)):
        inside = [name in names for names in each]
        sessions = {str(s) for s, own in zip(run["session"].values, inside, strict=True) if own}
        words.append(with_sessions(name, () if all(inside) else sorted(sessions)))
    return words
