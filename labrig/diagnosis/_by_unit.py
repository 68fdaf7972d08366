"""Errors in every unit that was measured in: a force and an angle have no error together."""

import numpy as np

from labrig.arrays import Floats, Ints
from labrig.contents import Errors
from labrig.diagnosis._candidates import mean_square
from labrig.diagnosis._floor import Floor
from labrig.diagnosis._regression import Regression


def by_unit(regression: Regression, floor: Floor, **left: Floats) -> dict[str, Errors]:
    """Root mean squares of what is `left` (S, K) and of the noise over the observables of each unit, the one that is
    quoted first; empty where there is one unit only.
    """
    squares = {name: mean_square(regression, values) for name, values in left.items()}
    squares["floor"] = floor.row**2
    return {
        unit: {name: float(np.sqrt(np.nanmean(each[of]))) for name, each in squares.items()}  # type: ignore[misc]
        for unit, of in seen_by_unit(regression).items()
    }


def seen_by_unit(regression: Regression) -> dict[str, Ints]:
    """The observables of each unit that were seen, the unit that errors are quoted in first; empty if there is one."""
    of = np.array(regression.context.rows.unit)
    seen = np.flatnonzero((regression.weight > 0).any(axis=0))
    units = dict.fromkeys([regression.units, *of[seen].tolist()])
    return {unit: seen[of[seen] == unit] for unit in units} if len(units) > 1 else {}
