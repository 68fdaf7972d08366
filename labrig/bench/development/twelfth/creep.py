"""Creep of the twelfth portion: Havriliak and Negami's walls, a load cell's, and a tendon that gets longer."""

import numpy as np

from labrig.arrays import Floats
from labrig.bench._nature import Law, Path, Setting
from labrig.bench.development._story import in_a_minute, lagged, pauses
from labrig.bench.development.twelfth._sensors import added, loaded, sensors, usual


class HavriliakNegami(Law):
    """Havriliak-Negami: a spectrum of retardation times that is broad, and skew, about one of them.

    S. Havriliak, S. Negami, A complex plane representation of dielectric and mechanical relaxation processes in some
    polymers, Polymer 8, 1967: (1 + (i w tau)^a)^-b, of which Cole-Cole's and Davidson-Cole's are the ends.
    """

    effect = "creep"

    def __init__(self, setting: Setting) -> None:
        super().__init__(setting)
        random, count = setting.random, len(self.rig.chambers)
        a, b = random.uniform(0.45, 0.85), random.uniform(0.4, 0.9)
        about_s = np.exp(random.uniform(np.log(8.0), np.log(120.0)))
        tau_s = np.geomspace(0.3, 1e4, 18)
        x = (tau_s / about_s) ** a
        angle = np.arctan2(np.sin(np.pi * a), x + np.cos(np.pi * a))
        yields = x**b * np.sin(b * angle) / (x**2 + 2 * x * np.cos(np.pi * a) + 1) ** (b / 2)
        self._tau_s, self._yields = in_a_minute(tau_s, np.maximum(yields, 0.0))
        self._share = random.uniform(0.05, 0.12) * random.uniform(0.8, 1.2, count)

    def wall(self, path: Path, kpa: Floats, deflection: Floats, strength: float) -> Floats:
        late = np.einsum("n,tnc->tc", self._yields, lagged(path, deflection, self._tau_s))
        return deflection + strength * self._share * late


class LoadCellCreeps(Law):
    """A load cell's creep: under a load its spring and the glue of its gauges give on, and its reading with them.

    OIML R 60, Metrological regulation for load cells, 2000, which limits it over half an hour. Only forces are read
    wrongly, in proportion, more (the spring) or less (the glue); what is there otherwise stays.
    """

    effect = "creep"
    needs = frozenset({"force"})

    def __init__(self, setting: Setting) -> None:
        super().__init__(setting)
        random = setting.random
        self._forces = sensors(self.rig, "N")
        count = len(self._forces)
        self._tau_s = np.exp(random.uniform(np.log([4.0, 60.0]), np.log([25.0, 600.0])))
        glue = random.uniform(0.4, 0.9)
        self._parts = np.array([glue, 1 - glue])
        way = random.choice([1.0, -1.0], p=[0.6, 0.4])
        self._share = way * random.uniform(0.08, 0.2) * random.uniform(0.6, 1.4, count)

    def seen(self, path: Path, deflection: Floats, values: Floats, strength: float) -> Floats:
        load = (values - self.rig.at_rest)[:, self._forces]
        late = np.einsum("n,tnf->tf", self._parts, lagged(path, load, self._tau_s))
        return added(values, self._forces, strength * self._share * late)


class TendonStretches(Law):
    """Wilding-Ward: polymer cords stretch by two processes, one that comes back and one that flows, ever slower.

    M. P. Wilding, I. M. Ward, Tensile creep and recovery in ultra-high modulus linear polyethylenes, Polymer 19, 1978:
    flow goes with the hyperbolic sine of the load. What angles and ways are told of is behind such cords, force is not.
    """

    effect = "creep"

    def __init__(self, setting: Setting) -> None:
        super().__init__(setting)
        random, rig = setting.random, self.rig
        self._behind = sensors(rig, "deg", "mm", "1/m")
        far = usual(rig, setting.path)[self._behind]
        ways = rig.settled(rig.high_kpa[None])[0] - rig.at_rest
        sides = np.where(ways[self._behind] < 0, 1.0, -1.0)
        self._size = random.uniform(0.12, 0.25) * sides * random.uniform(0.6, 1.4, len(far)) * far
        self._back_s = np.exp(random.uniform(np.log(6.0), np.log(50.0)))
        self._flows_s = np.exp(random.uniform(np.log(20.0), np.log(200.0)))
        self._flows = random.uniform(0.1, 0.4)  # how much it flows by until it is e times as slow
        self._sinh = random.uniform(1.0, 3.0)

    def seen(self, path: Path, deflection: Floats, values: Floats, strength: float) -> Floats:
        load = np.minimum(loaded(self.rig, deflection), 10.0)
        back = lagged(path, load[:, None], np.array([self._back_s]))[:, 0, 0]
        rate = np.sinh(self._sinh * load) / np.sinh(self._sinh) * pauses(path) / self._flows_s
        flowed = self._flows * np.log1p(np.cumsum(rate))
        return added(values, self._behind, strength * (back + flowed)[:, None] * self._size)
