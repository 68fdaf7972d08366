"""Tension of the tenth portion: strips that are clamped and pulled, and a tight cover that smooths the whole body."""

import numpy as np

from labrig.arrays import Floats
from labrig.bench._nature import Law, Path, Setting
from labrig.bench.development._places import body_mm, columns, moved, positions, reached


class StripUnderTension(Law):
    """Strip under tension: a clamped strip that is pulled along bends the less, by a hyperbolic tangent of its pull.

    S. Timoshenko, S. Woinowsky-Krieger, Theory of Plates and Shells, McGraw-Hill, 1959, on bending to a cylinder: the
    middle moves by 3 (u - tanh u) / u^3 of what it would without any pull, and u squared goes with the pull. The strip
    was mounted too tight; the further it bulges, the more of the pull is what its lengthening makes anyway.
    """

    effect = "tension"
    needs = frozenset({"curved"})

    def __init__(self, setting: Setting) -> None:
        super().__init__(setting)
        random, count = setting.random, len(self.rig.chambers)
        self._tight = random.uniform(0.25, 0.8) * random.uniform(0.85, 1.15, count)
        self._longer = random.uniform(2.0, 8.0)  # the pull that its lengthening makes at full deflection

    @staticmethod
    def _moves(pull: Floats) -> Floats:
        """How far it moves, as a share, with u squared = pull."""
        u = np.sqrt(np.maximum(pull, 0.0))
        small = u < 0.02
        safe = np.where(small, 1.0, u)
        return np.where(small, 1 - 0.4 * u**2, 3 * (safe - np.tanh(safe)) / safe**3)

    def wall(self, path: Path, kpa: Floats, deflection: Floats, strength: float) -> Floats:
        longer = self._longer * deflection**2
        return deflection * (self._moves(longer + strength * self._tight) / self._moves(longer))


class TightCover(Law):
    """Tight cover: it evens out how far neighbouring places have moved, most while they have not moved far yet.

    R. Szilard, Theory and Analysis of Plates, Prentice-Hall, 1974, on membranes on an elastic body: its pull times the
    curvature of what it covers is a pressure that flattens it. The cover was laced tighter than modelled; as the body
    grows the model's own pull takes over, and what is too much of it counts less and less.
    """

    effect = "tension"
    needs = frozenset({"markers", "curved"})

    def __init__(self, setting: Setting) -> None:
        super().__init__(setting)
        random, rig = setting.random, self.rig
        assert rig.rest_mm is not None
        _, radius_mm = body_mm(rig)
        apart = np.sum((rig.rest_mm[:, None] - rig.rest_mm) ** 2, axis=2)
        near = np.exp(-apart / (2 * (random.uniform(0.3, 0.6) * radius_mm) ** 2))
        near += 0.15 * near.mean()  # seams all around: its edge pulls towards rest
        self._even = near / near.sum(axis=1, keepdims=True) * random.uniform(0.75, 0.95)
        self._pull = random.uniform(0.5, 1.0)
        far = positions(rig, rig.shape(np.diag(reached(rig, setting.path)))) - rig.rest_mm
        self._fades_mm = random.uniform(0.5, 1.0) * float(np.sqrt(np.mean(np.sum(far**2, axis=2))))
        self._seen = np.flatnonzero((columns(rig) >= 0).any(axis=1))

    def seen(self, path: Path, deflection: Floats, values: Floats, strength: float) -> Floats:
        assert self.rig.rest_mm is not None
        points = positions(self.rig, values)
        gone = points - self.rig.rest_mm
        far_mm = np.sqrt(np.mean(np.sum(gone[:, self._seen] ** 2, axis=2), axis=1))[:, None, None]
        share = strength * self._pull / (1 + strength * self._pull + (far_mm / self._fades_mm) ** 2)
        return moved(self.rig, values, points + share * (self._even @ gone - gone))
