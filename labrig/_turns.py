"""Which observables are angles, and which are quaternions: both are the same after a whole turn."""

from collections.abc import Sequence

import numpy as np

from labrig.arrays import Floats

_TURNS = {"deg": 360.0, "degree": 360.0, "degrees": 360.0, "°": 360.0, "rad": 2 * np.pi, "radian": 2 * np.pi}
_NO_UNIT = {"1", "", "-"}
_UNIT = 0.02
"""By how much the length of a quaternion may be off from one."""
_FEWEST = 3


def turn_of(unit: str) -> float:
    """A whole turn in a unit; 0 of what is no angle."""
    return _TURNS.get(unit.lower(), 0.0)


def quaternions(units: Sequence[str], values: Floats) -> list[slice]:
    """Which four neighbours of the observables (n, K) are one: without a unit, the sum of their squares always 1."""
    out: list[slice] = []
    first = 0
    while first + 4 <= len(units):
        four = values[:, first : first + 4]
        length = np.linalg.norm(four[np.isfinite(four).all(axis=1)], axis=1)
        plain = set(units[first : first + 4]) <= _NO_UNIT
        if plain and len(length) >= _FEWEST and np.abs(length - 1).max() <= _UNIT:
            out.append(slice(first, first + 4))
            first += 3
        first += 1
    return out
