"""Coupling: what one chamber does depends on its neighbours."""

from itertools import pairwise
from typing import ClassVar

import numpy as np

from labrig.arrays import Floats
from labrig.bench._nature import Law, Path, Setting
from labrig.bench.exam.tools import seats


class ManifoldCrosstalk(Law):
    """A manifold whose bores join the outlets: pressures settle where the flows of a network of resistances balance.

    I. E. Idelchik, Handbook of Hydraulic Resistance, Hemisphere, 1986.
    """

    effect: ClassVar[str] = "coupling"
    needs: ClassVar[frozenset[str]] = frozenset({"several"})

    def __init__(self, setting: Setting) -> None:
        super().__init__(setting)
        random, count = setting.random, len(setting.rig.chambers)
        order = random.permutation(count)
        network = np.zeros((count, count))
        for first, second in pairwise(order):
            conductance = random.uniform(0.02, 0.09)
            network[[first, second], [first, second]] += conductance
            network[[first, second], [second, first]] -= conductance
        self._value, self._mode = np.linalg.eigh(network)

    def pressure(self, path: Path, kpa: Floats, strength: float) -> Floats:
        """The pressures behind the network."""
        value = strength * np.maximum(self._value, 0.0)
        return kpa - ((kpa @ self._mode) * (value / (1 + value))) @ self._mode.T


class SaturatingCrosstalk(Law):
    """Neighbours that press against each other's walls as they swell, ever less as the gap between them is filled.

    B. Mosadegh and others, Advanced Functional Materials, 2014 (walls of pneumatic networks that touch).
    """

    effect: ClassVar[str] = "coupling"
    needs: ClassVar[frozenset[str]] = frozenset({"several"})

    def __init__(self, setting: Setting) -> None:
        super().__init__(setting)
        random, seat = setting.random, seats(setting.rig)
        count = len(seat)
        away = np.linalg.norm(seat[:, None] - seat[None], axis=2)
        near = away[~np.eye(count, dtype=bool)].min()
        gain = np.exp(-away / (near + 0.05) + 1) * random.uniform(0.6, 1.4, (count, count))
        np.fill_diagonal(gain, 0.0)
        self._gain = random.choice([-1.0, 1.0]) * random.uniform(0.06, 0.15) * gain / gain.sum(axis=0).max()
        self._full = random.uniform(0.2, 0.5)

    def wall(self, path: Path, kpa: Floats, deflection: Floats, strength: float) -> Floats:
        """Each wall is moved by what its neighbours' swelling comes to."""
        return deflection + strength * np.tanh(deflection / self._full) @ self._gain
