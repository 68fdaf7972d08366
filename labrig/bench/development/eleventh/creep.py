"""Creep of the eleventh portion: a second network of chains that flows, and a winding that beds into the rubber."""

import numpy as np

from labrig.arrays import Floats
from labrig.bench._nature import Law, Path, Setting
from labrig.bench.development._story import pauses


class SecondNetworkFlows(Law):
    """Bergström-Boyce: beside the network that bears for good a second one flows, by a power of what it still bears.

    J. S. Bergström, M. C. Boyce, Constitutive modeling of the large strain time-dependent behavior of elastomers,
    J. Mechanics and Physics of Solids 46, 1998. Chains that have flowed far already flow the slower, by another power.
    """

    effect = "creep"

    def __init__(self, setting: Setting) -> None:
        super().__init__(setting)
        random, count = setting.random, len(self.rig.chambers)
        self._power = random.uniform(2.0, 4.0)
        self._slows = random.uniform(0.3, 1.0)
        self._begins = random.uniform(0.05, 0.12)
        half_s = np.exp(random.uniform(np.log(6.0), np.log(60.0)))  # until half of full deflection has flowed
        self._rate = (2 ** (self._power - 1) - 1) / (self._power - 1) / half_s
        self._share = random.uniform(0.08, 0.18) * random.uniform(0.8, 1.2, count)
        part = np.geomspace(1.0, 64.0, 6)
        self._parts = part / part.sum()

    def wall(self, path: Path, kpa: Floats, deflection: Floats, strength: float) -> Floats:
        power, flowed = self._power, np.zeros(deflection.shape[1])
        out = np.empty_like(deflection)
        for i, pause_s in enumerate(pauses(path).tolist()):
            for part in self._parts if pause_s > 1.0 else (1.0,):
                bears = deflection[i] - flowed
                size = np.abs(bears)
                rate = self._rate * ((np.abs(flowed) + self._begins) / (0.3 + self._begins)) ** -self._slows
                # how a power of itself relaxes it, exactly, at this rate
                left = (1 + (power - 1) * rate * part * pause_s * size ** (power - 1)) ** (-1 / (power - 1))
                flowed = deflection[i] - bears * left
            out[i] = flowed
        return deflection + strength * self._share * out


class ThreadBedsIn(Law):
    """Bedding-in: the thread around a chamber sinks into the rubber, and the rubber lifts it out again, but far slower.

    F. Connolly, C. J. Walsh, K. Bertoldi, Automatic design of fiber-reinforced soft actuators for trajectory matching,
    PNAS 114, 2017, on such windings; E. H. Lee, J. R. M. Radok, The contact problem for viscoelastic bodies, J. Applied
    Mechanics 27, 1960, on a groove that is left behind. A deeper groove is a wider one, in which it sinks less quickly.
    """

    effect = "creep"

    def __init__(self, setting: Setting) -> None:
        super().__init__(setting)
        random, count = setting.random, len(self.rig.chambers)
        self._sinks_s = np.exp(random.uniform(np.log(6.0), np.log(40.0))) * random.uniform(0.8, 1.25, count)
        self._slower = random.uniform(3.0, 10.0)  # on its way out
        self._widens = random.uniform(0.5, 4.0)
        self._share = random.uniform(0.07, 0.16) * random.uniform(0.8, 1.2, count)

    def wall(self, path: Path, kpa: Floats, deflection: Floats, strength: float) -> Floats:
        sunk = np.zeros(deflection.shape[1])
        out = np.empty_like(deflection)
        for i, pause_s in enumerate(pauses(path).tolist()):
            further = np.abs(deflection[i]) > np.abs(sunk)
            wide = 1 + self._widens * np.abs(sunk)
            tau_s = self._sinks_s * np.where(further, wide, self._slower)
            sunk = deflection[i] + (sunk - deflection[i]) * np.exp(-pause_s / tau_s)
            out[i] = sunk
        return deflection + strength * self._share * out
