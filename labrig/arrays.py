"""The array types of every signature; shapes and units stand in the docstrings."""

from typing import TypeAlias

import numpy as np
from numpy.typing import NDArray

Floats: TypeAlias = NDArray[np.float64]
"""64-bit floating-point numbers."""
Ints: TypeAlias = NDArray[np.int64]
"""64-bit integers: indices, counts."""
Bools: TypeAlias = NDArray[np.bool_]
"""Truth values: masks."""

__all__ = ["Bools", "Floats", "Ints"]
