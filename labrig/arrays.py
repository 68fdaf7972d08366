"""The array types of every signature; shapes and units stand in the docstrings."""

from typing import Any, TypeAlias

import numpy as np
from numpy.typing import NDArray

Floats: TypeAlias = NDArray[np.float64]
"""64-bit floating-point numbers."""
Ints: TypeAlias = NDArray[np.int64]
"""64-bit integers: indices, counts."""
Bools: TypeAlias = NDArray[np.bool_]
"""Truth values: masks."""


def flat(values: Any) -> list[float]:
    """Numbers of a list of lists in one list; a number by itself is a list of one."""
    if isinstance(values, list | tuple):
        return [number for value in values for number in flat(value)]
    return [] if values is None else [float(values)]


__all__ = ["Bools", "Floats", "Ints", "flat"]
