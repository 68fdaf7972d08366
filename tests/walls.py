"""A wall over the markers, by a formula that labrig does not have."""

from typing import TYPE_CHECKING

import numpy as np

if TYPE_CHECKING:
    from tests.conftest import Lab

LIMIT_MM = 9.0


def pressed(lab: "Lab", limit_mm: float = LIMIT_MM) -> np.ndarray:
    """What markers do at a soft wall above them, (n, T, K): the wall gives way by a root of the force that it takes.

    H. Hertz, Journal fuer die reine und angewandte Mathematik 92 (1882) 156: the force goes with the way to 3/2.
    """
    values = lab.predict(lab.u)
    over = np.maximum(values[..., 2::3] - limit_mm, 0.0)
    way = over.copy()
    for _ in range(60):  # the body is a spring, so what it lacks is what the wall's force bends it by
        way -= (way + 2.5 * way**1.5 - over) / (1 + 3.75 * np.sqrt(np.maximum(way, 0.0)))
    values[..., 2::3] -= over - way
    return values
