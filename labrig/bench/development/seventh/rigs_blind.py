"""Rigs of the seventh portion without markers: a choke that pinches hoses, and a gullet that swallows."""

import numpy as np

from labrig.arrays import Floats
from labrig.bench._nature import Observable, Rig
from labrig.bench.development.rigs._common import chambers


class Choke(Rig):
    """A choke: cuffs pinch soft hoses, and meters tell what still flows through each of them.

    J. B. Grotberg, O. E. Jensen, Biofluid mechanics in flexible tubes, Annual Review of Fluid Mechanics 36, 2004. A
    hose resists by an exponential of how far it is pinched; some cuffs lie around two hoses. Cuffs first close a gap.
    """

    kind = "choke"

    def __init__(self, random: np.random.Generator) -> None:
        seen = int(random.integers(1, 4))
        count = seen + int(random.integers(0, 3))
        self.chambers = chambers(count)
        self.high_kpa = random.uniform(30, 120) * random.uniform(0.9, 1.1, count)
        self.observables = tuple(Observable(f"flow{k + 1}", "l/min") for k in range(seen))
        self.noise = float(random.uniform(0.004, 0.012))
        self._flow = random.uniform(2.0, 6.0, seen)
        around = np.vstack([np.eye(seen), np.eye(seen)[random.integers(seen, size=count - seen)]])
        self._resists = random.uniform(0.1, 0.4, (count, seen)) * np.maximum(
            around, 0.3 * (random.random(around.shape) < 0.3)
        )
        self._pinches = random.uniform(1.5, 3.0, count)
        self._gap, self._power = random.uniform(0.2, 1.5, count), random.uniform(1.2, 2.0)

    def deflection(self, kpa: Floats) -> Floats:
        load = kpa / self.high_kpa
        size = np.abs(load) ** self._power
        return np.sign(load) * size * (1 + self._gap) / (size + self._gap)

    def shape(self, deflection: Floats) -> Floats:
        more = np.exp(self._pinches * np.clip(deflection, -2.0, 6.0)) @ self._resists
        return self._flow * (1 + self._resists.sum(axis=0)) / (1 + more)


class Gullet(Rig):
    """A gullet: rings of chambers swallow, and a catheter with a row of gauges tells how hard they press on it.

    F. J. Chen, S. Dirven, W. L. Xu, X. N. Li, Soft actuator mimicking human esophageal peristalsis for a swallowing
    robot, IEEE/ASME Trans. Mechatronics 19, 2014. All is linear; each ring is felt a good way up and down.
    """

    kind = "gullet"

    def __init__(self, random: np.random.Generator) -> None:
        count, seen = int(random.integers(6, 13)), int(random.integers(8, 21))
        self.chambers = chambers(count)
        self.high_kpa = random.uniform(30, 90) * random.uniform(0.95, 1.05, count)
        self.observables = tuple(Observable(f"gauge{k + 1}", "kPa") for k in range(seen))
        self.noise = float(random.uniform(0.03, 0.1))
        middle = (np.arange(count) + 0.5 + random.normal(0, 0.1, count)) / count
        at = np.sort(random.uniform(0.0, 1.0, seen))
        apart = np.abs(middle[:, None] - at) * count
        felt = 1 / np.cosh(apart / random.uniform(0.5, 0.9))
        self._felt_kpa = random.uniform(15, 40) * random.uniform(0.8, 1.2, (count, 1)) * felt
        self._zero_kpa = random.uniform(0.2, 2.0, seen)

    def deflection(self, kpa: Floats) -> Floats:
        return np.asarray(kpa / self.high_kpa, dtype=float)

    def shape(self, deflection: Floats) -> Floats:
        return self._zero_kpa + deflection @ self._felt_kpa
