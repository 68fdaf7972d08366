"""The seed of a run that is planned by clicks: which was used already, so that the next run has other set-points."""

from itertools import count
from pathlib import Path
from typing import Any

from labrig._errors import LabrigError
from labrig._yaml import read_yaml
from labrig.api._procedures import shipped
from labrig.catalogue import list_runs
from labrig.log import read_run_yaml
from labrig.rig import RigConfig
from labrig.workbench._desk import Desk

_MOST = 2**53
"""Beyond it a page's numbers are not exact."""
_DIGITS = 16
"""Of it."""


def seed_of(asked: dict[str, Any]) -> int:
    """The seed that a page names, 0 where it names none; raises `LabrigError` for what is no seed."""
    given = asked.get("seed")
    text = "0" if given is None else str(given).strip()
    if not text.isdecimal() or len(text) > _DIGITS or int(text) >= _MOST:
        raise LabrigError(f"seed {text[:_DIGITS] or 'left empty'}: give a whole number, 0 or more, such as 0")
    return int(text)


def free_seed(desk: Desk, config: RigConfig, procedure: str) -> int:
    """The smallest seed that no run of this procedure on this rig, in the desk's folder, was measured with."""
    name = _name_of(desk, procedure)
    alike = [row for row in list_runs(desk.folder) if row.rig == config.name and row.procedure == name]
    used = {_used(desk.folder / row.run) for row in alike}
    return next(seed for seed in count() if seed not in used)


def _name_of(desk: Desk, procedure: str) -> str:
    """What run.yaml will call a procedure; of a Python file, which is not run for this, what its file is called."""
    if procedure in shipped():
        return procedure
    path = desk.existing(procedure)
    if path.suffix == ".py":
        return path.stem
    try:
        return str(read_yaml(path, "procedure").get("procedure", ""))
    except LabrigError:
        return ""  # said when its plan is shown


def _used(run: Path) -> int | None:
    seed = read_run_yaml(run).get("seed")
    return seed if isinstance(seed, int) else None
