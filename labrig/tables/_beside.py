"""Columns that are beside the measurement: what was around it, what fed it, and how good it was."""

from collections.abc import Mapping, Sequence

import numpy as np

from labrig.arrays import Floats
from labrig.tables import _names as names
from labrig.tables._held import is_held
from labrig.tables._inputs import is_drive, is_driven, is_pressure, is_volume
from labrig.tables._names import Name
from labrig.tables._units import like

_SOME, _MOVED = 20, 0.5
"""Rows from which a tilt is compared with the inputs, and the share of its variance that these may leave."""


def is_ambient(n: Name, values: Floats) -> bool:
    """Whether a column is what was around the measurement, or what hung on the body: a load that stands still."""
    if n.has(names.AMBIENT) or n.unit in {"degC", "degF", "K"}:
        return True
    if _is_humidity(n) or (n.words[:1] == ("t",) and n.unit is None and n.has(names.AROUND)):
        return True
    kind = {name for name in ("kg", "rad") if n.unit is not None and like(n.unit, name)}
    stands = n.has(names.LOAD) or "kg" in kind or (n.has(names.TURNED) and "rad" in kind)
    return stands and not n.has(names.MEASURED) and is_held(values)


def _is_humidity(n: Name) -> bool:
    """Whether a column is a share that is called a humidity, or has the letters for it: rH, and HR in percent."""
    short = "".join(n.words)
    short = short in names.HUMIDITY_SHORT and (n.unit == "percent" or short not in {"rf", "hr"})
    return (short or n.has(names.HUMIDITY)) and n.unit in {None, "1", "percent"}


def is_moved(n: Name, inputs: Sequence[Name], values: Mapping[str, Floats]) -> bool:
    """Whether a tilt follows the inputs, so that it is what they move, and not how the rig was put up."""
    if not n.has(names.TURNED) or not inputs:
        return False
    own = values[n.column]
    x = np.column_stack([np.ones(len(own)), *(values[i.column] for i in inputs)])
    known = np.isfinite(x).all(axis=1) & np.isfinite(own)
    if known.sum() < _SOME or np.ptp(own[known]) == 0:
        return False
    x, own = x[known], own[known] - own[known].mean()
    left = own - x @ np.linalg.lstsq(x, own, rcond=None)[0]
    return bool((left**2).sum() < _MOVED * (own**2).sum())


def is_side(n: Name, values: Floats) -> bool:
    """Whether a column is beside the measurement: a supply, a barometer, a pump, a valve that is open or closed."""
    if n.has(names.COMMANDED) or is_volume(n):  # what a pump gave
        return False
    if n.has(names.SIDE) or (n.has(names.SUPPLY) and is_pressure(n)):
        return True
    if n.has(names.SUPPLY) and is_drive(n) and not is_driven(values):
        return True
    of_air = is_pressure(n) or (n.unit is None and not n.has({"air"}))
    if n.has(names.ATMOSPHERE) and of_air and not n.has(names.MEASURED) and not is_driven(values):
        return True
    seen = values[np.isfinite(values)]
    return n.has(names.STATE) and n.unit is None and bool(np.isin(seen, (0, 1)).all())


def is_quality(n: Name) -> bool:
    """Whether a column says how good a measurement was: an error of its markers, or how many of them were seen."""
    if n.axis is not None or n.has(names.COMMANDED):
        return False
    counted = n.has(names.TRACKED) or ("markers" in n.words and n.has(names.COUNTER | {"n"}))
    of_markers = n.has(names.ERROR) or (counted and n.unit is None)
    return n.has(names.QUALITY) or (n.has(names.MARKERS) and of_markers)
