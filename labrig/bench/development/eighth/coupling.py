"""Coupling of the eighth portion: neighbours pull, lean, leak and bulge into each other, and share a sleeve."""

import numpy as np

from labrig.arrays import Floats
from labrig.bench._nature import Law, Path, Setting
from labrig.bench.development._places import full


def _beside(count: int) -> Floats:
    """Which chambers (C, C) are neighbours in a row: 1 or 0."""
    place = np.arange(count)
    return (np.abs(place[:, None] - place) == 1).astype(float)


class LinearCrosstalk(Law):
    """Linear crosstalk: a chamber gives way by a fixed share of what its neighbours in the row give way.

    R. J. Webster and B. A. Jones, Design and kinematic modeling of constant curvature continuum robots, International
    Journal of Robotics Research 29(13), 2010. Walls in common carry the load over. The shares differ from pair to pair.
    """

    effect = "coupling"
    needs = frozenset({"several"})

    def __init__(self, setting: Setting) -> None:
        super().__init__(setting)
        random, count = setting.random, len(self.rig.chambers)
        self._share = _beside(count) * random.uniform(0.04, 0.1) * random.uniform(0.5, 1.5, (count, count))

    def wall(self, path: Path, kpa: Floats, deflection: Floats, strength: float) -> Floats:
        return deflection + strength * deflection @ self._share.T


class BilinearNeighbours(Law):
    """Product of neighbours: two chambers that are both inflated lean on each other and give way less, or more.

    D. C. Montgomery, Design and Analysis of Experiments, Wiley, 2012. What is missing is the product of the two
    deflections; one chamber alone does what the model says.
    """

    effect = "coupling"
    needs = frozenset({"several"})

    def __init__(self, setting: Setting) -> None:
        super().__init__(setting)
        random, count = setting.random, len(self.rig.chambers)
        size = np.triu(random.uniform(0.08, 0.2, (count, count)), 1)
        self._share = _beside(count) * (size + size.T) * random.choice([-1.0, -1.0, 1.0])

    def wall(self, path: Path, kpa: Floats, deflection: Floats, strength: float) -> Floats:
        pull = np.clip(deflection, -1.5, 1.5)
        return deflection + strength * pull * (pull @ self._share)


class PinholedSeptum(Law):
    """Pinhole in a septum: air passes between some neighbours, and their regulators cannot quite make up for it.

    B. Mosadegh et al., Pneumatic networks for soft robotics that actuate rapidly, Advanced Functional Materials 24(15),
    2014. The flow goes with the difference of the two pressures; each regulator droops in proportion to its flow, and
    so the two pressures come nearer to each other.
    """

    effect = "coupling"
    needs = frozenset({"several"})

    def __init__(self, setting: Setting) -> None:
        super().__init__(setting)
        random, count = setting.random, len(self.rig.chambers)
        on = random.random(count - 1) < 0.5
        on[random.integers(count - 1)] = True
        hole = np.where(on, random.uniform(0.08, 0.2, count - 1), 0.0)
        self._hole = np.diag(hole, 1) + np.diag(hole, -1)
        self._droop = random.uniform(0.7, 1.3, count)

    def pressure(self, path: Path, kpa: Floats, strength: float) -> Floats:
        flow = np.diag(self._hole.sum(axis=1)) - self._hole  # of what each chamber loses, (C, C)
        balance = np.eye(len(flow)) + strength * self._droop[:, None] * flow
        return np.asarray(np.linalg.solve(balance, kpa.T).T, dtype=float)


class BulgingPartition(Law):
    """Bulging partition: the wall between two chambers bulges into the one with less pressure, which swells by it.

    W. Fluegge, Stresses in Shells, Springer, 1960; the cube root is H. Hencky's of a circular membrane, Zeitschrift
    fuer Mathematik und Physik 63, 1915. So it is steep about equal pressures and flat where they differ much.
    """

    effect = "coupling"
    needs = frozenset({"several"})

    def __init__(self, setting: Setting) -> None:
        super().__init__(setting)
        random, count = setting.random, len(self.rig.chambers)
        size = np.triu(random.uniform(0.04, 0.09, (count, count)), 1)
        closed = _beside(count)
        if count > 3 and random.random() < 0.5:  # a ring of chambers
            closed[0, -1] = closed[-1, 0] = 1.0
        self._size = closed * (size + size.T)
        self._bends = random.uniform(0.02, 0.06)  # below this share of the pressure it bends as a plate

    def wall(self, path: Path, kpa: Floats, deflection: Floats, strength: float) -> Floats:
        load = kpa / self.rig.high_kpa.mean()
        apart = load[:, None, :] - load[:, :, None]  # the neighbour's (last) over its own
        bulge = np.cbrt(apart) * np.abs(apart) / (np.abs(apart) + self._bends)
        return deflection + strength * np.sum(self._size * bulge, axis=2)


class SharedSleeve(Law):
    """Shared sleeve: one sleeve of cloth holds all chambers, and what the others take of it a chamber cannot have.

    F. Connolly, C. J. Walsh and K. Bertoldi, Automatic design of fiber-reinforced soft actuators for trajectory
    matching, PNAS 114(1), 2017. There is some cloth to spare; only beyond it do the others count.
    """

    effect = "coupling"
    needs = frozenset({"several"})

    def __init__(self, setting: Setting) -> None:
        super().__init__(setting)
        random, count = setting.random, len(self.rig.chambers)
        load = np.abs(full(self.rig, setting.path.kpa))
        self._spare = random.uniform(0.2, 0.5) * np.mean(load.sum(axis=1)) * (count - 1) / count
        self._hold = random.uniform(0.2, 0.4) / np.sqrt(count - 1) * random.uniform(0.8, 1.2, count)

    def wall(self, path: Path, kpa: Floats, deflection: Floats, strength: float) -> Floats:
        taken = np.maximum(deflection, 0.0)
        others = np.maximum(taken.sum(axis=1, keepdims=True) - taken - self._spare, 0.0)
        return deflection / (1 + strength * self._hold * others)
