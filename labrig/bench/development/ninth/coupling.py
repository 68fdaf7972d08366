"""Coupling of the ninth portion: one supply, a leaky partition, touching walls, a septum, a stiff body."""

import numpy as np

from labrig.arrays import Floats
from labrig.bench._nature import Law, Path, Rig, Setting
from labrig.bench.development._places import full, overlap
from labrig.bench.development.rigs._common import cubic_membrane

_SEVERAL = frozenset({"several"})


def _neighbours(rig: Rig, random: np.random.Generator) -> Floats:
    """How closely any two chambers are joined, (C, C): about 1 for those that move the same places most."""
    near = overlap(rig)
    near = 0.1 + 0.9 * near / max(float(near.max()), 1e-9)
    uneven = np.triu(np.exp(random.normal(0, 0.3, near.shape)), 1)
    return near * (uneven + uneven.T)


def _per_chamber(joined: Floats) -> Floats:
    """The same, so that what the others do to a chamber adds up to 1 on an average over the chambers."""
    return joined / joined.sum(axis=1).mean()


class SharedSupply(Law):
    """Shared supply: all valves draw on one line, whose pressure sinks as the other chambers ask for more.

    B. W. Andersen, The Analysis and Design of Pneumatic Systems, Wiley, 1967. Valves that bleed draw a steady
    flow in proportion to their pressure; the line and each valve divide the pressure as two resistances in a
    row do.
    """

    effect = "coupling"
    needs = _SEVERAL

    def __init__(self, setting: Setting) -> None:
        super().__init__(setting)
        random, count = setting.random, len(self.rig.chambers)
        draws = random.uniform(0.7, 1.3, count)
        others = np.tile(draws, (count, 1)) * (1 - np.eye(count))
        self._line = random.uniform(0.1, 0.25) * _per_chamber(others)

    def pressure(self, path: Path, kpa: Floats, strength: float) -> Floats:
        return kpa / (1 + strength * np.abs(full(self.rig, kpa)) @ self._line.T)


class LeakyPartition(Law):
    """Leaky partition: air seeps between chambers, and each settles between its valve and theirs.

    F. M. White, Fluid Mechanics, McGraw-Hill, 1979: the flow through a narrow gap goes with the difference of
    pressure (Poiseuille), and in the steady state what comes in through valve and gaps is nothing
    (Kirchhoff).
    """

    effect = "coupling"
    needs = _SEVERAL

    def __init__(self, setting: Setting) -> None:
        super().__init__(setting)
        random, count = setting.random, len(self.rig.chambers)
        gap = _per_chamber(_neighbours(self.rig, random))
        valve = random.uniform(0.7, 1.3, (count, 1))  # how easily air comes through each chamber's own
        self._net = random.uniform(0.08, 0.2) * (np.diag(gap.sum(axis=1)) - gap) / valve

    def pressure(self, path: Path, kpa: Floats, strength: float) -> Floats:
        net = np.eye(len(self._net)) + strength * self._net
        return np.asarray(np.linalg.solve(net, kpa.T).T, dtype=float)


class WallsTouch(Law):
    """Walls touch: two neighbours that bulge far enough meet, and press on each other from there on.

    K. L. Johnson, Contact Mechanics, Cambridge University Press, 1985: Hertz's force goes with the overlap to
    the power 3/2. In some bodies it pushes the walls back, in others (B. Mosadegh et al., Advanced Functional
    Materials 24, 2014) it is what drives them on.
    """

    effect = "coupling"
    needs = _SEVERAL

    def __init__(self, setting: Setting) -> None:
        super().__init__(setting)
        random = setting.random
        joined = _per_chamber(_neighbours(self.rig, random))
        self._push = random.uniform(0.15, 0.35) * joined * random.choice([-1.0, 1.0], p=[0.6, 0.4])
        gap = random.uniform(0.7, 1.0) * np.exp(random.normal(0, 0.08, joined.shape))
        self._gap = (gap + gap.T) / 2

    def wall(self, path: Path, kpa: Floats, deflection: Floats, strength: float) -> Floats:
        overlaps = np.maximum(deflection[:, :, None] + deflection[:, None, :] - self._gap, 0.0)
        return deflection + strength * np.sum(self._push * overlaps**1.5, axis=2)


class SeptumBulges(Law):
    """Septum bulges: the wall that two chambers share bends into the one with less pressure.

    S. Timoshenko, S. Woinowsky-Krieger, Theory of Plates and Shells, McGraw-Hill, 1959, on large deflections:
    the difference of pressure is a w + b w^3. Their sides are taken along. Filled alike, the two leave their
    wall where it is.
    """

    effect = "coupling"
    needs = _SEVERAL

    def __init__(self, setting: Setting) -> None:
        super().__init__(setting)
        random = setting.random
        self._moves = random.uniform(0.08, 0.2) * _per_chamber(_neighbours(self.rig, random))
        self._bends = np.array(random.uniform(0.2, 0.6))  # a, the rest is b
        self._unit_kpa = float(self.rig.high_kpa.mean())

    def wall(self, path: Path, kpa: Floats, deflection: Floats, strength: float) -> Floats:
        load = (kpa[:, :, None] - kpa[:, None, :]) / self._unit_kpa
        return deflection - strength * np.sum(self._moves * cubic_membrane(load, 1 - self._bends), axis=2)


class HeldStiff(Law):
    """Held stiff: chambers that are filled at once stiffen the whole body, and it goes less far.

    N. Hogan, Adaptive control of mechanical impedance by coactivation of antagonist muscles, IEEE
    Transactions on Automatic Control 29, 1984. The stiffness is that of the empty body and a part for each
    pair that works together.
    """

    effect = "coupling"
    needs = _SEVERAL

    def __init__(self, setting: Setting) -> None:
        super().__init__(setting)
        random = setting.random
        pairs = np.triu(_neighbours(self.rig, random), 1)
        self._stiffer = random.uniform(0.25, 0.6) * pairs / pairs.sum()

    def seen(self, path: Path, deflection: Floats, values: Floats, strength: float) -> Floats:
        size = np.abs(deflection)
        together = np.einsum("ti,ij,tj->t", size, self._stiffer, size)[:, None]
        rest = self.rig.at_rest
        return rest + (values - rest) / (1 + strength * together)
