"""How far each chamber alone moves the observables over its range."""

from dataclasses import dataclass

import numpy as np

from labrig._ranges import ends
from labrig.arrays import Floats

GRID = 33
_FLATTEST = 0.15


@dataclass(frozen=True)
class Deflection:
    """How far each chamber alone moves the observables, as a share of its motion at full range.

    `reach` (K, C): the mean size of each observable's slope on the way, per unit of actuation.
    """

    origin: Floats
    span: Floats
    curves: Floats
    reach: Floats

    def at(self, actuation: Floats) -> Floats:
        """The share at each actuation, (n, C)."""
        return self._interpolate(actuation, self.curves)

    def slope(self, actuation: Floats) -> Floats:
        """Its derivative by the fraction of the range, (n, C), kept away from zero."""
        slopes = np.gradient(self.curves, 1 / (GRID - 1), axis=0, edge_order=2)
        return np.maximum(self._interpolate(actuation, slopes), _FLATTEST)

    def over(self, low: Floats, high: Floats) -> "Deflection":
        """The same over wider ranges (C,): beyond its own a chamber does not move."""
        origin, span = ends(low, high)
        grid = origin + np.linspace(0, 1, GRID)[:, None] * span
        return Deflection(origin, span, self.at(grid), self.reach * np.abs(self.span / span))

    def _interpolate(self, actuation: Floats, curves: Floats) -> Floats:
        x = (actuation - self.origin) / self.span
        grid = np.linspace(0, 1, GRID)
        return np.stack([np.interp(x[:, c], grid, curves[:, c]) for c in range(x.shape[1])], axis=1)
