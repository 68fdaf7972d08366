"""Couplings of the tenth portion: an elastic half-space under all chambers, and a tank that they empty in turn."""

import numpy as np

from labrig.arrays import Floats
from labrig.bench._nature import Law, Path, Setting
from labrig.bench.development._places import alone, columns, full
from labrig.bench.development._story import pauses, steps

_SEVERAL = frozenset({"several"})


class OnOneHalfSpace(Law):
    """Boussinesq: each chamber presses on soft ground under all of them, which sinks by one over the distance.

    J. Boussinesq, Application des potentiels à l'étude de l'équilibre et du mouvement des solides élastiques, 1885;
    K. L. Johnson, Contact Mechanics, Cambridge University Press, 1985. Where the ground sinks, a chamber loses way.
    """

    effect = "coupling"
    needs = frozenset({"markers", "several"})

    def __init__(self, setting: Setting) -> None:
        super().__init__(setting)
        random, rig = setting.random, self.rig
        assert rig.rest_mm is not None
        where = columns(rig)
        each = np.where(where >= 0, alone(rig)[:, where], 0.0)  # (C, M, 3)
        moves = np.linalg.norm(each, axis=2) ** 2
        centre = moves @ rig.rest_mm / moves.sum(axis=1, keepdims=True)
        apart = np.linalg.norm(centre[:, None] - centre, axis=2)
        np.fill_diagonal(apart, np.inf)
        nearest = max(float(np.median(apart.min(axis=1))), 1e-6)
        sinks = 1 / (0.5 + apart / nearest)  # a chamber's foot is no point
        self._sinks = sinks * random.uniform(0.1, 0.22) / sinks.sum(axis=1).max()
        self._thrust = random.uniform(0.85, 1.15, len(rig.chambers))

    def wall(self, path: Path, kpa: Floats, deflection: Floats, strength: float) -> Floats:
        thrust = full(self.rig, kpa) * self._thrust
        return deflection - strength * thrust @ self._sinks


class TankThatEmpties(Law):
    """Receiver: what a chamber takes out of a small tank the others lack, until the pump has filled it again.

    Compressed Air and Gas Institute, Compressed Air and Gas Handbook, 1989, on receivers; makers of regulators give the
    supply-pressure effect as a share of it. The pump makes up for it within minutes, by an exponential. Its own draw a
    valve corrects, as it is open then; what others draw later comes through.
    """

    effect = "coupling"
    needs = _SEVERAL

    def __init__(self, setting: Setting) -> None:
        super().__init__(setting)
        random, count = setting.random, len(self.rig.chambers)
        self._fills_s = np.exp(random.uniform(np.log(6.0), np.log(40.0)))
        self._takes = random.uniform(0.7, 1.3, count)  # the sizes of the chambers
        self._comes_through = random.uniform(0.05, 0.13) * random.uniform(0.8, 1.2, count)

    def pressure(self, path: Path, kpa: Floats, strength: float) -> Floats:
        drawn = np.maximum(steps(full(self.rig, np.maximum(kpa, 0.0))), 0.0) * self._takes
        kept = np.exp(-pauses(path) / self._fills_s)
        lacks = np.zeros(drawn.shape[1])
        out = np.empty_like(drawn)
        for i in range(len(drawn)):
            lacks = lacks * kept[i] + drawn[i]
            out[i] = lacks.sum() - lacks  # by all the others
        share = 1 / (1 + strength * self._comes_through * out)
        return np.where(kpa > 0, kpa * share, kpa)
