"""How strong something has to be to have a wanted size."""

from collections.abc import Callable

import numpy as np

NEAR = 0.02
"""A size this close to the wanted one (a share of it) will do."""
_STEPS = 24


def strength_for(size: Callable[[float], float], wanted: float, most: float) -> float | None:
    """The strength at which `size(strength)` is as wanted, within `NEAR`; None if there is none up to `most`.

    Steps in proportion first, which is all that most laws need, then halves the interval, in logarithms.
    """
    low, high = 0.0, most
    strength = min(1.0, most)
    for step in range(_STEPS):
        found = size(strength)
        if not np.isfinite(found):
            found = np.inf
        elif abs(found / wanted - 1.0) < NEAR:
            return strength
        if found < wanted:
            low = strength
            if strength >= most:
                return None
        else:
            high = strength
        if step < 4 and 0.0 < found < np.inf:
            guess = strength * wanted / found
        else:
            guess = np.sqrt(low * high) if low > 0.0 else 0.1 * high
        inside = low < guess < high or (guess >= most and high == most)
        strength = float(min(guess, most)) if inside else float(0.5 * (low + high))
        if high - low < 1e-6 * high:
            break
    return None
