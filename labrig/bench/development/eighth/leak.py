"""Leaks of the eighth portion: chambers that are shut off in a hold, and what becomes of their air."""

import numpy as np

from labrig.arrays import Floats
from labrig.bench._nature import Law, Path, Setting
from labrig.bench.development._places import full, some

_HELD_S = 0.6
"""After an actuation the valve has done its work, and shuts."""


def _shut_s(path: Path) -> Floats:
    """How long (T, 1) the valves have been shut, in s."""
    return np.maximum(path.hold_s - _HELD_S, 0.0)[:, None]


class ExponentialBleed(Law):
    """Exponential bleed: through a small constant leak the pressure of a shut chamber falls off exponentially.

    J. F. O'Hanlon, A User's Guide to Vacuum Technology, Wiley, 2003. Every chamber has a time constant of its own.
    """

    effect = "leak"
    needs = frozenset({"holds"})

    def __init__(self, setting: Setting) -> None:
        super().__init__(setting)
        random, count = setting.random, len(self.rig.chambers)
        self._tau_s = random.uniform(120, 300) * np.exp(random.normal(0, 0.4, count))

    def pressure(self, path: Path, kpa: Floats, strength: float) -> Floats:
        return kpa * np.exp(-strength * _shut_s(path) / self._tau_s)


class ConstantLossRate(Law):
    """Constant loss: some chambers lose so many kpa a minute, whatever they hold, until they are empty.

    EN 1779, Non-destructive testing, Leak testing, Criteria for method and technique selection, 1999: the
    pressure-change test. Choked holes of the same kind draw air in where there is vacuum.
    """

    effect = "leak"
    needs = frozenset({"holds"})

    def __init__(self, setting: Setting) -> None:
        super().__init__(setting)
        random, count = setting.random, len(self.rig.chambers)
        self._rate = some(random, count, 0.002, 0.005, share=0.6)  # of the full pressure, a second

    def pressure(self, path: Path, kpa: Floats, strength: float) -> Floats:
        lost = strength * self._rate * self.rig.high_kpa * _shut_s(path)
        return np.sign(kpa) * np.maximum(np.abs(kpa) - lost, 0.0)


class PinholeStretchesOpen(Law):
    """Pinhole stretches open: the hole in a rubber wall grows with the strain, so that full chambers leak the most.

    A. N. Gent and C. Wang, Fracture mechanics and cavitation in rubber-like solids, Journal of Materials Science 26,
    1991. The flow goes with the pressure times an opening that goes with it too. One chamber or a few are pierced.
    """

    effect = "leak"
    needs = frozenset({"holds"})

    def __init__(self, setting: Setting) -> None:
        super().__init__(setting)
        random, count = setting.random, len(self.rig.chambers)
        self._rate = some(random, count, 0.012, 0.03, share=0.5)  # a second, at full pressure

    def pressure(self, path: Path, kpa: Floats, strength: float) -> Floats:
        return kpa / (1 + strength * self._rate * np.abs(full(self.rig, kpa)) * _shut_s(path))


class SeamWeepsAboveLoad(Law):
    """Weeping seam: a welded seam is tight up to some pressure, and above it lets air out until it closes again.

    R. Niiyama et al., Pouch motors: printable soft actuators integrated with computational design, Soft Robotics 2(2),
    2015. All seams come from one welding iron and open at much the same share of the limit.
    """

    effect = "leak"
    needs = frozenset({"holds"})

    def __init__(self, setting: Setting) -> None:
        super().__init__(setting)
        random, count = setting.random, len(self.rig.chambers)
        self._opens = random.uniform(0.15, 0.4) * random.uniform(0.9, 1.1, count)
        self._tau_s = random.uniform(25, 80) * np.exp(random.normal(0, 0.25, count))

    def pressure(self, path: Path, kpa: Floats, strength: float) -> Floats:
        load = np.abs(full(self.rig, kpa))
        over = np.maximum(load - self._opens, 0.0)
        left = load + over * np.expm1(-strength * _shut_s(path) / self._tau_s)
        return np.sign(kpa) * left * self.rig.high_kpa


class DissolvesInRubber(Law):
    """Air dissolves in rubber: thick walls take up air from a shut chamber, with the root of time at first.

    J. Crank, The Mathematics of Diffusion, Oxford University Press, 1975; solubility by W. Henry, Philosophical
    Transactions 93, 1803. Each chamber has its ratio of wall to air, and its wall is fresh at every hold.
    """

    effect = "leak"
    needs = frozenset({"holds"})

    def __init__(self, setting: Setting) -> None:
        super().__init__(setting)
        random, count = setting.random, len(self.rig.chambers)
        self._taken = random.uniform(0.12, 0.25) * random.uniform(0.7, 1.3, count)  # in a minute

    def pressure(self, path: Path, kpa: Floats, strength: float) -> Floats:
        return kpa / (1 + strength * self._taken * np.sqrt(_shut_s(path) / 60.0))
