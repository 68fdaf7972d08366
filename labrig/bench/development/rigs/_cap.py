"""A shallow cap over one chamber, well away from snapping, that one to three lasers look at."""

import numpy as np

from labrig.arrays import Floats
from labrig.bench._nature import Observable, Rig
from labrig.bench.development.rigs._common import chambers


class Cap(Rig):
    """A shell that gives way ever faster towards the load at which it would snap, which it never reaches.

    J. M. T. Thompson, G. W. Hunt, A General Theory of Elastic Stability, Wiley, 1973: next to a limit point the way
    goes with the root of the load that is left.
    """

    kind = "cap"

    def __init__(self, random: np.random.Generator) -> None:
        self.chambers = chambers(1)
        self.high_kpa = np.array([random.uniform(4, 20)])
        count = int(random.integers(1, 4))
        self.observables = tuple(Observable(f"laser{k + 1}", "mm") for k in range(count))
        self.noise = float(random.uniform(0.008, 0.02))
        self._near = random.uniform(0.35, 0.8)  # of the load at which it snaps
        place = np.array([0.0, random.uniform(0.3, 0.5), random.uniform(0.6, 0.75)])[:count]
        self._sinks_mm = random.uniform(2, 6) * (1 - place**2) ** 2
        self._flattens_mm = self._sinks_mm * random.uniform(-0.25, 0.25, count) * (0.2 + place)

    def deflection(self, kpa: Floats) -> Floats:
        load = self._near * kpa / self.high_kpa
        last = 0.9  # beyond it the tangent goes on
        root = np.sqrt(1 - np.minimum(load, last))
        way = 1 - root + np.maximum(load - last, 0.0) / (2 * np.sqrt(1 - last))
        return way / (1 - np.sqrt(1 - self._near))

    def shape(self, deflection: Floats) -> Floats:
        return -(deflection * self._sinks_mm + deflection * np.abs(deflection) * self._flattens_mm)
