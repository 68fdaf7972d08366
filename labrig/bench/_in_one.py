"""A law that holds in one of several chambers: one hose leaks, one regulator is off, one wall meets a stop."""

import numpy as np

from labrig.arrays import Floats
from labrig.bench._nature import Law, Path

FEWEST = 3
"""Chambers that a rig must have for one of them to be one of several."""


def acts_in_chambers(law: type[Law]) -> bool:
    """Whether all that a law changes are pressures and walls, chamber by chamber, and not what is seen of the whole."""
    own = law.pressure is not Law.pressure or law.wall is not Law.wall
    return own and law.seen is Law.seen


class InOneChamber(Law):
    """Another law, of which only what it does in one chamber comes to pass."""

    def __init__(self, law: Law, chamber: int) -> None:
        self.rig, self._law, self._chamber = law.rig, law, chamber

    def pressure(self, path: Path, kpa: Floats, strength: float) -> Floats:
        """The pressures (T, C), another in this chamber only."""
        return self._only_here(kpa, self._law.pressure(path, kpa, strength))

    def wall(self, path: Path, kpa: Floats, deflection: Floats, strength: float) -> Floats:
        """How far the walls give way (T, C), another in this chamber only."""
        return self._only_here(deflection, self._law.wall(path, kpa, deflection, strength))

    def _only_here(self, before: Floats, after: Floats) -> Floats:
        return np.where(np.arange(before.shape[1]) == self._chamber, after, before)
