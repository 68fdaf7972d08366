"""predict: what a model says that set-points would show, before anybody measures them."""

from typing import TYPE_CHECKING, Any

import numpy as np

from labrig._errors import LabrigError
from labrig._linalg import sums_of
from labrig.api._inputs import model_of, number, runs_of
from labrig.arrays import Floats

if TYPE_CHECKING:
    from xarray import Dataset

    from labrig.effects import Rows


def predict(runs: Any, model: Any, set_points: Any, *, hold_s: float = 4.0) -> "Dataset":
    """What a model says that a rig would show at some set-points, one after the other from a vented rig on.

    Effects act with their history: what creeps or leaks does so along each hold, and a loop depends on the order.

    Args:
        runs: one run or a list of the rig, as paths or as `labrig.open_run` gives them: they say which chambers and
            observables there are, and what a base that is fitted to a run is fitted to.
        model: a model.yaml's path, what `labrig.Model.load` gives, or a function as `labrig.Model.of` takes it.
        set_points: (n, C), in the run's unit: an array with a column for each chamber, in the run's order, or a
            DataFrame whose columns have the chambers' names.
        hold_s: how long each is held, s, from 1.5 on.

    Returns:
        `predicted` (capture, observable), means over the time of each hold, the first second left out; `commanded`
        (capture, chamber); `unit` of each observable; `attrs["warnings"]`, a line on each effect, and on a base, that
        says little there.

    Raises:
        LabrigError: the set-points do not fit the run's chambers, or a run or the model cannot be read.

    Example:
        >>> shown = labrig.predict("runs/first", "model.yaml", [[10, 0, 0, 0], [20, 0, 0, 0]])
        >>> shown["predicted"].sizes["capture"]
        2
    """
    import xarray as xr

    from labrig.diagnosis import rows_from
    from labrig.experiment import as_rows

    rows, questioned = rows_from(runs_of(runs)), model_of(model)
    u = _set_points(set_points, rows)
    if not _SHORTEST_S <= number(hold_s, "hold_s", "in seconds") < np.inf:
        raise LabrigError(f"hold_s {hold_s:g}: must be {_SHORTEST_S:g} s or more, and have an end")
    planned, share = as_rows(rows, u, float(hold_s))
    context = questioned.predictor(rows).context(planned)
    unknown = [
        f"{entry.name} is read off the measured pressures, which nobody knows before: it changes nothing here"
        for entry in questioned.file.effects
        if entry.form == _AS_MEASURED
    ]
    mean = sums_of(planned.capture, share[:, None] * context.base, len(u))
    return xr.Dataset(
        {
            "commanded": (("capture", "chamber"), u, {"units": rows.actuation_unit}),
            "predicted": (("capture", "observable"), mean),
        },
        coords={
            "capture": np.arange(len(u)),
            "chamber": list(rows.chambers),
            "observable": list(rows.observables),
            "unit": ("observable", list(rows.unit)),
        },
        attrs={"hold_s": float(hold_s), "warnings": [*context.rows.warnings, *unknown]},
    )


_AS_MEASURED = "as measured"
"""The form of an effect that follows the measured pressures."""
_SHORTEST_S = 1.5
"""The first second after an actuation is left out, as in a diagnosis."""


def _set_points(given: Any, rows: "Rows") -> Floats:
    """Set-points (n, C) in the order of a run's chambers; raises `LabrigError` where they are none."""
    named = f"{len(rows.chambers)} columns are needed, {', '.join(rows.chambers)}"
    if hasattr(given, "columns"):
        if missing := [name for name in rows.chambers if name not in given.columns]:
            raise LabrigError(f"set_points: there is no column {missing[0]!r}; {named}")
        given = given[list(rows.chambers)]
    try:
        u = np.asarray(given, dtype=float)
    except (TypeError, ValueError):
        raise LabrigError(f"set_points: a table of numbers is needed; {named}") from None
    if u.ndim != 2 or u.shape[1] != len(rows.chambers) or not len(u):
        raise LabrigError(f"set_points: {' x '.join(map(str, u.shape)) or 'one number'} given; {named}")
    if not np.isfinite(u).all():
        raise LabrigError(
            f"set_points: row {int(np.flatnonzero(~np.isfinite(u).all(axis=1))[0])} is not finite"
        )
    return u
