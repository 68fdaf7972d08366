"""compare: a model as it stands against measurements. improve: effects added to it, fitted and judged."""

from collections.abc import Sequence
from typing import TYPE_CHECKING

from labrig._errors import LabrigError
from labrig.diagnosis._opened import Opened
from labrig.diagnosis._result import Result
from labrig.model import Model

if TYPE_CHECKING:
    from xarray import Dataset


def compare(runs: "Sequence[Dataset] | Dataset", model: Model, *, only_last: bool = False) -> Result:
    """Errors of a model as it stands, without any fit of effects: how large, and where.

    With `only_last`, those on the last of several runs, which remembers what the rig did in the others. Raises
    `LabrigError` when the runs and the model do not fit together.
    """
    return Opened(runs, model, only_last=only_last).compare()


def improve(
    runs: "Sequence[Dataset] | Dataset", model: Model, names: Sequence[str], *, force: bool = False
) -> Result:
    """Fit the named effects together and add them to the model.

    Raises `LabrigError` when an effect does not exist, can't act on these runs, is in the model already,
    or, unless `force`, does not lower the held-out error by more than its standard error.
    """
    trial = Opened(runs, model).add(names)
    for each in trial.falls:
        if each.helps:
            continue
        if not force:
            raise LabrigError(
                f"{each.effect!r} does not lower the held-out error enough to matter ({each.words}); "
                "the model is left as it is; --force (force=True) adds it all the same"
            )
        trial.result.summary["warnings"].append(
            f"{each.effect!r} does not lower the held-out error enough to matter; it was added because of --force"
        )
    return trial.result
