"""check: the morning's check of a rig, from Python."""

from collections.abc import Callable
from pathlib import Path
from typing import TYPE_CHECKING, Any

from labrig.api._history import History, history
from labrig.api._inputs import AnyPath, model_of, rig_of
from labrig.api._run import made, new_folder, run

if TYPE_CHECKING:
    from labrig.campaign import Progress

TAG = "check"


def check(
    rig: Any,
    model: Any,
    *,
    runs: AnyPath = "runs",
    seed: int = 0,
    realtime: bool = False,
    progress: "Callable[[Progress], None] | None" = None,
    **parameters: Any,
) -> History:
    """Run the morning's check of a rig (about 3 minutes), add it to the rig's history, and give that.

    It records an ordinary run with the tag check: rest, some set-points again and again, one long hold. What this one
    noticed is what `changes` of the answer has with its date as `noticed`.

    Args:
        rig: a rig.yaml's path, or what `labrig.load_rig` gives.
        model: a model.yaml's path, or what `labrig.Model.load` gives.
        runs: the folder that holds the rig's runs; the new one goes there.
        seed, realtime, progress: as for `labrig.run`.
        parameters: the procedure's, by name: `points=6`.

    Raises:
        LabrigError, DeviceError: as `labrig.run` and `labrig.history` do.

    Example:
        >>> found = labrig.check("rig.yaml", "model.yaml")
        >>> list(found.runs["procedure"])[-1]
        'check'
        >>> list(labrig.runs("runs", where="'check' in tags")["procedure"])
        ['check']
    """
    from labrig.catalogue import tag

    config, known = rig_of(rig), model_of(model).in_files()
    procedure = made(TAG, parameters)
    folder = new_folder(procedure, Path(runs))
    run(procedure, rig, out=folder, seed=seed, realtime=realtime, progress=progress)
    tag(folder, [TAG])
    return history(config, known, runs=runs)
