"""Pressures in another unit than the model takes them in: it follows what was measured with other ones."""

from collections.abc import Iterator

import numpy as np

from labrig.arrays import Floats, Ints
from labrig.effects import Context, motion_scale

_UNITS_KPA = {"kPa": 1.0, "Pa": 1e-3, "mbar": 0.1, "bar": 100.0, "MPa": 1e3, "psi": 6.894757}
"""Units in which people write pressures, in kPa."""
_WRONG = 0.5
"""Error, as a share of the whole motion, from which on other pressures are tried."""
TIMES = 5.0
"""By how many times a motion, a size or an error has to be off for a person to be asked, and nothing named before."""
_UNKNOWN = {"python", "table"}
"""Bases of which nobody knows the unit of pressures: a simulator's is kPa, and it may not bear a thousand times it."""
_CAPTURES = 200
"""Captures on which they are tried, at most; numerical."""


def pressures_off(context: Context) -> Iterator[str]:
    """A line where the model errs by as much as it moves, and many times less if each pressure is taken for one in
    another unit.
    """
    first = context.rows.first
    first = first[np.unique(np.linspace(0, len(first) - 1, min(len(first), _CAPTURES)).astype(int))]
    if context.elsewhere is None or context.base_kind not in _UNKNOWN:
        return
    values = context.rows.values
    if not (np.fmax.reduce(values, axis=0) > np.fmin.reduce(values, axis=0)).any():
        return  # what never changes follows no pressure
    now, found = _error(context, context.base[first], first), {}
    if now < _WRONG:
        return
    for times in sorted({round(a / b, 9) for a in _UNITS_KPA.values() for b in _UNITS_KPA.values()} - {1.0}):
        try:
            with np.errstate(all="ignore"):
                said = np.asarray(context.elsewhere(context.rows.actuation[first] * times))
        except Exception:  # a model may refuse what it was never made for
            continue
        error = _error(context, said, first)
        if np.isfinite(error):
            found[times] = error
    if found and found[best := min(found, key=found.__getitem__)] < now / TIMES:
        yield (
            f"the error is 1/{now / found[best]:.0f} as large if each pressure is taken {_factor(best)}: check in "
            f"which unit the model takes pressures (the run has them in {context.rows.actuation_unit})"
        )


def _error(context: Context, said: Floats, rows: Ints) -> float:
    """The error of a prediction (n, K), root mean square, in the measured motion of each observable."""
    seen = np.isfinite(context.rows.values[rows]).any(axis=0)
    values = context.rows.values[rows][:, seen]
    moves = np.maximum(np.nanstd(values, axis=0), 1e-12 * np.maximum(motion_scale(context)[seen], 1e-300))
    with np.errstate(all="ignore"):
        off = (values - said[:, seen]) / moves
        return float(np.sqrt(np.nanmean(np.square(off)))) if off.size else 0.0


def _factor(times: float) -> str:
    """A factor in words, as a whole number or as one over it."""
    large = max(times, 1 / times)
    said = f"{large:.4g}"
    return f"{said} times" if times > 1 else f"1/{said}"
