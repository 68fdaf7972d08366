"""Whether a rig is still what a model was fitted to, from what is kept beside its runs; no log is opened for it."""

import math
from collections.abc import Sequence
from pathlib import Path
from typing import TYPE_CHECKING

from labrig._errors import LabrigError
from labrig.age._age import reference, rows_of_rig, summary_of
from labrig.age._known import is_fitted
from labrig.age._read import RunReadings, from_content, is_current, kept, model_key
from labrig.contents import HistoryChange, HistoryContent

if TYPE_CHECKING:
    from labrig.model import Model

_SAID = 3
_BACK = 0.25
"""Of the way that a quantity went: nearer to where it was than that, it has come back."""


def warning(rig: str, model: "Model", folder: Path) -> str:
    """One line where what earlier commands read of a rig's runs says that it changed since the model was fitted.

    Empty where nothing is known, or nothing changed.
    """
    try:
        summary = summary_of(rig, model, _kept_readings(rig, model, folder))
    except (LabrigError, OSError):
        return ""
    now = lasting(summary)
    if not now:
        return ""
    said = "; ".join(each["words"] for each in now[:_SAID])
    more = f"; and {len(now) - _SAID} more" if len(now) > _SAID else ""
    name = Path(summary["model"]).name if summary["model"] else "its model"
    return f"rig {rig} is not what {name} was fitted to: {said}{more}"


def lasting(summary: HistoryContent) -> list[HistoryChange]:
    """The last change of each quantity since the model was fitted, unless the quantity came back to where it was."""
    by_quantity: dict[tuple[str, str], list[HistoryChange]] = {}
    for change in summary["changes"]:
        if change["since_fit"]:
            by_quantity.setdefault((change["group"], change["name"]), []).append(change)
    out: list[HistoryChange] = []
    for each in by_quantity.values():
        went = max(math.dist(each[0]["before"], change["after"]) for change in each)
        if math.dist(each[0]["before"], each[-1]["after"]) > _BACK * went:
            out.append({**each[-1], "before": each[0]["before"]})
    return sorted(out, key=lambda change: change["noticed"])


def _kept_readings(rig: str, model: "Model", folder: Path) -> Sequence[RunReadings]:
    rows = rows_of_rig(folder, rig)
    key = model_key(model, reference(rows).id) if is_fitted(model) else model_key(model)
    found = [(row.run, kept(folder / row.run).get(key)) for row in rows]
    known = [(run, each) for run, each in found if each is not None and is_current(folder / run, each)]
    return sorted((from_content(*each) for each in known), key=lambda run: (run.time_s, run.run))
