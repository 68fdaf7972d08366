"""Further leaks: into the wall, into a neighbour, by a jet, past a lip that only pressure closes, through a tear."""

import numpy as np
from scipy.special import erfcx

from labrig.arrays import Floats
from labrig.bench._nature import Law, Path, Setting
from labrig.bench.development._places import overlap, some
from labrig.bench.development.leak import bled


class Permeation(Law):
    """Permeation: gas dissolves in a thick wall, with the root of time at first, and ever more slowly.

    J. Crank, The Mathematics of Diffusion, 2nd ed., Clarendon Press, 1975.
    """

    effect = "leak"

    def __init__(self, setting: Setting) -> None:
        super().__init__(setting)
        self._per_s = some(setting.random, len(self.rig.chambers), 1 / 6000, 1 / 1500, 0.8)

    def pressure(self, path: Path, kpa: Floats, strength: float) -> Floats:
        return kpa * erfcx(strength * np.sqrt(self._per_s * path.hold_s[:, None]))


class IntoNeighbour(Law):
    """Leaking septum: two chambers that share a wall equalise their pressures exponentially; no air gets out.

    J. F. O'Hanlon, A User's Guide to Vacuum Technology, 3rd ed., Wiley, 2003.
    """

    effect = "leak"
    needs = frozenset({"several"})

    def __init__(self, setting: Setting) -> None:
        super().__init__(setting)
        near = overlap(self.rig)
        self._one = int(setting.random.integers(len(near)))
        self._other = int(np.argmax(near[self._one] + 1e-9 * (np.arange(len(near)) != self._one)))
        self._per_s = setting.random.uniform(1 / 120, 1 / 25)
        self._volume = setting.random.uniform(0.35, 0.65)  # the one's share of both

    def pressure(self, path: Path, kpa: Floats, strength: float) -> Floats:
        gone = -np.expm1(-strength * self._per_s * path.hold_s) * (kpa[:, self._one] - kpa[:, self._other])
        out = kpa.copy()
        out[:, self._one] -= (1 - self._volume) * gone
        out[:, self._other] += self._volume * gone
        return out


class JetThroughHole(Law):
    """Jet: through one chamber's hole air escapes with the root of the pressure, and is all out at a certain time.

    D. Bernoulli, Hydrodynamica, Strasbourg, 1738.
    """

    effect = "leak"

    def __init__(self, setting: Setting) -> None:
        super().__init__(setting)
        self._per_s = np.zeros(len(self.rig.chambers))
        self._per_s[setting.random.integers(len(self._per_s))] = setting.random.uniform(1 / 200, 1 / 40)

    def pressure(self, path: Path, kpa: Floats, strength: float) -> Floats:
        root = np.sqrt(np.maximum(kpa, 0.0))
        lost = 0.5 * strength * self._per_s * np.sqrt(self.rig.high_kpa) * path.hold_s[:, None]
        return np.where(kpa > 0, np.maximum(root - lost, 0.0) ** 2, kpa)


class SelfActingLip(Law):
    """Lip that pressure closes: at low pressure it leaks, and the higher the pressure, the tighter it seals.

    R. Flitney, Seals and Sealing Handbook, 6th ed., Butterworth-Heinemann, 2014.
    """

    effect = "leak"

    def __init__(self, setting: Setting) -> None:
        super().__init__(setting)
        count = len(self.rig.chambers)
        self._closes = setting.random.uniform(0.25, 0.6) * self.rig.high_kpa
        self._per_s = some(setting.random, count, 1 / 150, 1 / 40, 0.6)

    def pressure(self, path: Path, kpa: Floats, strength: float) -> Floats:
        out = kpa.copy()
        for c in np.flatnonzero(strength * self._per_s):
            rate, closes = strength * self._per_s[c], self._closes[c]
            out[:, c] = bled(
                kpa[:, c], path.hold_s, lambda p, r=rate, k=closes: r * p * np.exp(-np.minimum(p / k, 30.0))
            )
        return out


class GrowingTear(Law):
    """Growing tear: each time a chamber is loaded its tear gets longer, and what it loses in a hold becomes more.

    R. S. Rivlin, A. G. Thomas, Rupture of rubber I: characteristic energy for tearing, J. Polymer Science 10, 1953.
    """

    effect = "leak"

    def __init__(self, setting: Setting) -> None:
        super().__init__(setting)
        self._per_s = some(setting.random, len(self.rig.chambers), 1 / 250, 1 / 60, 0.4)
        self._begins = setting.random.uniform(0.2, 0.6)
        self._events = int(setting.path.event.max()) + 1

    def pressure(self, path: Path, kpa: Floats, strength: float) -> Floats:
        long = self._begins + (1 - self._begins) * np.minimum(path.event / self._events, 2.0)
        return kpa * np.exp(-strength * self._per_s * (long * path.hold_s)[:, None])
