"""A network of tanks and restrictions that two to six regulators feed, seen by the gauges on its tanks."""

import numpy as np

from labrig.arrays import Floats
from labrig.bench._nature import Observable, Rig
from labrig.bench.development.rigs._common import chambers

_AIR_KPA = 101.3


class Network(Rig):
    """Slow flow of gas: each restriction passes the difference of the squared absolute pressures at its ends.

    M. Muskat, The Flow of Homogeneous Fluids through Porous Media, McGraw-Hill, 1937; networks after G. Kirchhoff,
    Annalen der Physik und Chemie 148, 1847. The tanks also bleed into the room: every gauge shows every regulator.
    """

    kind = "network"

    def __init__(self, random: np.random.Generator) -> None:
        count, tanks = int(random.integers(2, 7)), int(random.integers(4, 10))
        self.chambers = chambers(count)
        self.high_kpa = random.uniform(80, 300) * random.uniform(0.9, 1.1, count)
        self.observables = tuple(Observable(f"tank{k + 1}", "kPa") for k in range(tanks))
        self.noise = float(random.uniform(0.1, 0.3))
        joins = np.zeros((tanks, tanks))
        for k in range(1, tanks):  # a tree, and a few loops
            joins[k, int(random.integers(k))] = random.uniform(0.4, 2.0)
        joins += np.where(random.random(joins.shape) < 0.15, random.uniform(0.1, 1.0, joins.shape), 0.0)
        joins = np.tril(joins, -1)
        joins = joins + joins.T
        feeds = np.zeros((tanks, count))
        feeds[random.permutation(max(tanks, count))[:count] % tanks, np.arange(count)] = random.uniform(
            0.5, 2.0, count
        )
        bleeds = random.uniform(0.05, 0.5, tanks)
        balance = np.diag(joins.sum(axis=1) + feeds.sum(axis=1) + bleeds) - joins
        self._square = (np.linalg.solve(balance, feeds) * self.high_kpa * (self.high_kpa + 2 * _AIR_KPA)).T

    def deflection(self, kpa: Floats) -> Floats:
        twice = 2 * _AIR_KPA
        return kpa * (np.abs(kpa) + twice) / (self.high_kpa * (self.high_kpa + twice))

    def shape(self, deflection: Floats) -> Floats:
        above = deflection @ self._square
        return np.sign(above) * (np.sqrt(_AIR_KPA**2 + np.abs(above)) - _AIR_KPA)
