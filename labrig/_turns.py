"""Which observables are angles, and which are quaternions: both are the same after a whole turn.

A place that is tracked with its quaternion is what people look at: errors are quoted in its unit.
"""

from collections.abc import Sequence

import numpy as np

from labrig.arrays import Floats, Ints

_TURNS = {"deg": 360.0, "degree": 360.0, "degrees": 360.0, "°": 360.0, "rad": 2 * np.pi, "radian": 2 * np.pi}
NO_UNIT = {"1", "", "-"}
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
        plain = set(units[first : first + 4]) <= NO_UNIT
        if plain and len(length) >= _FEWEST and np.abs(length - 1).max() <= _UNIT:
            out.append(slice(first, first + 4))
            first += 3
        first += 1
    return out


def quoted_from(units: Sequence[str], *values: Floats) -> Ints:
    """The observables (n, K) in whose units errors are quoted: all but the parts of quaternions, which any of `values`
    tells; all, where there is nothing else.
    """
    turned = {k for each in values for own in quaternions(units, each) for k in range(own.start, own.stop)}
    return np.array([k for k in range(len(units)) if k not in turned or len(turned) == len(units)], dtype=int)


def commonest_unit(units: Sequence[str], *values: Floats) -> Ints:
    """The observables (n, K) of the unit that most of them have; parts of quaternions count as in `quoted_from`."""
    able = quoted_from(units, *values)
    own = [units[k] for k in able]
    return able[[unit == max(dict.fromkeys(own), key=own.count) for unit in own]]
