"""Leak: pressure is lost during a hold, and made up at the next actuation."""

from typing import ClassVar

import numpy as np

from labrig.arrays import Floats
from labrig.bench._nature import Law, Path, Setting


class NeighbourLeak(Law):
    """Torn walls between neighbours: a laminar flow evens out their pressures while the valves are shut.

    F. M. White, Viscous Fluid Flow, McGraw-Hill, 1991 (slit flow).
    """

    effect: ClassVar[str] = "leak"
    needs: ClassVar[frozenset[str]] = frozenset({"several", "holds"})

    def __init__(self, setting: Setting) -> None:
        super().__init__(setting)
        random, count = setting.random, len(setting.rig.chambers)
        network = np.zeros((count, count))
        pairs = random.permutation(count - 1)[: max(1, count // 3)]
        for first in pairs:
            rate = random.uniform(0.01, 0.04)
            network[[first, first + 1], [first, first + 1]] += rate
            network[[first, first + 1], [first + 1, first]] -= rate
        self._rate_per_s, self._mode = np.linalg.eigh(network)

    def pressure(self, path: Path, kpa: Floats, strength: float) -> Floats:
        """The pressures, evened out since the last actuation."""
        lost = np.expm1(-strength * np.maximum(self._rate_per_s, 0.0) * path.hold_s[:, None])
        return kpa + ((kpa @ self._mode) * lost) @ self._mode.T


class LipSeal(Law):
    """Lip seals that open above a threshold, and leak in proportion to what is above it.

    R. Flitney, Seals and Sealing Handbook, Elsevier, 2007.
    """

    effect: ClassVar[str] = "leak"
    needs: ClassVar[frozenset[str]] = frozenset({"holds"})

    def __init__(self, setting: Setting) -> None:
        super().__init__(setting)
        random, count = setting.random, len(setting.rig.chambers)
        self._opens_kpa = setting.rig.high_kpa * random.uniform(0.3, 0.6, count)
        self._rate_per_s = random.uniform(0.015, 0.04) * random.uniform(0.4, 1.6, count)

    def pressure(self, path: Path, kpa: Floats, strength: float) -> Floats:
        """The pressures, with what is above the threshold on its way out since the last actuation."""
        above_kpa = np.maximum(kpa - self._opens_kpa, 0.0)
        return kpa + above_kpa * np.expm1(-strength * self._rate_per_s * path.hold_s[:, None])
