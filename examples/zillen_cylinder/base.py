"""The simplest model of a pneumatic cylinder: force is pressure times area."""

import numpy as np

BORE_MM = 25.7
N_PER_BAR = 0.1 * np.pi / 4 * BORE_MM**2


def predict(actuation):
    """Force in N, (F, 1), from the pressure in bar, (F, 1)."""
    return N_PER_BAR * actuation
