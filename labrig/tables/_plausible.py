"""Whether numbers can be what their unit says: pressures of a rig, set-points within their limits, lengths."""

import numpy as np

from labrig._errors import LabrigError
from labrig.arrays import Floats
from labrig.tables._mapping import Actuation
from labrig.tables._names import take_apart
from labrig.tables._units import factor, like

_PRESSURE_KPA = (8.0, 1600.0)
"""The highest pressure of a soft or pneumatic rig lies between these: below are numbers in bar, above those in mbar."""
_OTHER_KPA = {"kPa": 1.0, "bar": 100.0, "mbar": 0.1, "Pa": 1e-3, "psi": 6.894757, "MPa": 1000.0}
_USUAL_KPA = (5.0, 1000.0)
_LENGTH_MM = (0.05, 20_000.0)
_LIMIT = 0.02
"""By how much of its range a measured set-point may pass a limit."""


def check_limits(actuation: Floats, entries: list[Actuation], where: str) -> list[str]:
    """Compare set-points (n, C) with the limits that the mapping gives.

    Returns warnings for set-points that pass a limit by little; raises `LabrigError` for those that pass it by more
    than half the range: then the unit or the limit is wrong.
    """
    said = []
    for c, entry in enumerate(entries):
        u = actuation[:, c]
        low, high = float(u.min()), float(u.max())
        bottom = entry.min if entry.min is not None else min(0.0, low)
        top = entry.max if entry.max is not None else max(high, bottom)
        width = top - bottom
        if entry.max is not None and entry.min is not None and width <= 0:
            raise LabrigError(
                f"{where}: actuation {entry.name!r}: its max {top:g} is not above its min {bottom:g}"
            )
        over, under = high - top, bottom - low
        worst, limit, value = max((over, "max", high), (under, "min", low))
        if worst <= _LIMIT * max(width, 1e-300):
            if entry.max is not None and 0 < high < _LIMIT * entry.max:
                hint = _other_unit(np.abs(u), entry.unit, entry.max)
                said.append(
                    f"{where}: actuation {entry.name!r} goes to {high:g} {entry.unit}, less than 2 % of its max of "
                    f"{entry.max:g}; {hint or 'is the unit right?'}"
                )
            continue
        bound = top if limit == "max" else bottom
        rows = int(((u > top) | (u < bottom)).sum())
        text = (
            f"{where}: actuation {entry.name!r} has set-points up to {value:g} {entry.unit}, "
            f"beyond its {limit} of {bound:g} {entry.unit} ({rows} of {len(u)} rows)"
        )
        if worst > 0.5 * max(width, 1e-300):
            hint = _other_unit(np.abs(u), entry.unit, max(abs(top), abs(bottom)))
            raise LabrigError(f"{text}; {hint or 'correct the limit or the unit'}")
        said.append(f"{text}; the limit is taken as it is written")
    return said


def _other_unit(size: Floats, unit: str, limit: float) -> str | None:
    """A unit of pressure in which the set-points just stay within the limit."""
    if not like(unit, "kPa"):
        return None
    own = factor(unit, "kPa", "unit")
    top = float(size.max())
    fits = {
        name: top * kpa / own / limit
        for name, kpa in _OTHER_KPA.items()
        if 0.3 <= top * kpa / own / limit <= 1.05 and abs(kpa - own) > 1e-9
    }
    best = max(fits, key=lambda name: fits[name], default=None)
    return f"are they in {best}? The unit must be that of the numbers" if best else None


def check_values(values: Floats, unit: str, what: str, where: str) -> list[str]:
    """A warning where numbers (n,) can hardly be in their unit, or none: the list is empty."""
    size = np.abs(values[np.isfinite(values)])
    if not len(size) or unit == "1":
        return []
    top = float(np.percentile(size, 99.5, method="higher"))
    if top == 0:
        return []
    if like(unit, "kPa"):
        kpa = top * factor(unit, "kPa", where)
        if take_apart(what).has({"stress"}):  # which may have any size
            return []
        if not _PRESSURE_KPA[0] <= kpa <= _PRESSURE_KPA[1]:
            better = [
                name for name, each in _OTHER_KPA.items() if _USUAL_KPA[0] <= top * each <= _USUAL_KPA[1]
            ]
            hint = f"; in {' or '.join(better[:2])} they would be usual" if better else ""
            return [f"{where}: {what} goes to {top:.3g} {unit}, which is unusual for a pressure{hint}"]
    elif like(unit, "degC") and (top > 400 if unit in {"degC", "celsius"} else not 200 <= top <= 700):
        return [f"{where}: {what} goes to {top:.3g} {unit}, which is unusual for a temperature"]
    elif like(unit, "mm"):
        mm = float(np.ptp(values[np.isfinite(values)])) * factor(unit, "mm", where)
        if mm > _LENGTH_MM[1] or 0 < mm < _LENGTH_MM[0] * 1e-3:
            return [
                f"{where}: {what} moves over {mm:.3g} mm as it is in {unit}, which is unusual; is the unit right?"
            ]
    return []
