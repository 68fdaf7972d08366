"""While somebody looks at the list of runs, what the newest of them will show is made."""

import threading
from collections.abc import Callable, Sequence
from concurrent.futures import CancelledError
from contextlib import suppress

from labrig._errors import LabrigError
from labrig.workbench._desk import Desk
from labrig.workbench._models import models_of
from labrig.workbench._run import pair_of, run_folder
from labrig.workbench._views import kept


def ahead(desk: Desk, runs: Sequence[str], work: Callable[..., str]) -> None:
    """Have `work` made of the first of these runs, beside the model that its page begins with.

    Only where the two were compared already: what takes minutes is begun by a person.
    """
    for run in runs[:1]:
        threading.Thread(target=_made, args=(desk, run, work), name="labrig ahead", daemon=True).start()


def _made(desk: Desk, run: str, work: Callable[..., str]) -> None:
    with suppress(LabrigError, CancelledError, OSError):  # whoever opens the run is told
        models = models_of(desk, run_folder(desk, run))
        pair = pair_of(desk, {"run": run, "model": desk.name(models[0]) if models else ""})
        if pair.has("compare.json"):
            kept(desk, work, pair.key)
