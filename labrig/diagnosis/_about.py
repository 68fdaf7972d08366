"""Which runs and which model a result is about, so that it is found again beside them."""

from collections.abc import Sequence
from pathlib import Path
from typing import TYPE_CHECKING

from labrig.contents import About
from labrig.model import Model

if TYPE_CHECKING:
    from xarray import Dataset


def about(runs: "Sequence[Dataset] | Dataset", model: Model) -> About:
    """The fields `runs` and `model` of a result: paths as they were given, and what each run is recognised by."""
    many = list(runs) if isinstance(runs, list | tuple) else [runs]
    named = [run.attrs for run in many if "run_id" in run.attrs]  # type: ignore[union-attr]
    return {
        "runs": [{"run": Path(each["run"]).as_posix(), "id": each["run_id"]} for each in named],
        "model": None if model.path is None else model.path.as_posix(),
    }
