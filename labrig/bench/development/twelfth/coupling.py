"""Couplings of the twelfth portion: a frame that flexes under all chambers, and a bar that shares their pulls out."""

import numpy as np

from labrig.arrays import Floats
from labrig.bench._nature import Law, Path, Setting

_SEVERAL = frozenset({"several"})


class FrameFlexes(Law):
    """Flexing frame: what carries all chambers is a spring, too, and each of them shifts the ends of all the others.

    J. C. Maxwell, On the calculation of the equilibrium and stiffness of frames, Philosophical Magazine 27, 1864: what
    one does to another is what the other does to it. A printed frame has one weak way, in which all have some part.
    """

    effect = "coupling"
    needs = _SEVERAL

    def __init__(self, setting: Setting) -> None:
        super().__init__(setting)
        random, count = setting.random, len(self.rig.chambers)
        part = random.uniform(0.5, 1.5, count) * random.choice([-1.0, 1.0], count, p=[0.3, 0.7])
        flexes = np.outer(part, part)
        np.fill_diagonal(flexes, 0.0)
        self._flexes = random.uniform(0.06, 0.15) * flexes / np.abs(flexes).sum(axis=0).max()

    def wall(self, path: Path, kpa: Floats, deflection: Floats, strength: float) -> Floats:
        return deflection - strength * deflection @ self._flexes


class WhiffleTree(Law):
    """Whiffletree: chambers pull at the ends of bars that tip, so that what one has too much another gets, to a stop.

    S. Hirose, Y. Umetani, The development of soft gripper for the versatile robot hand, Mechanism and Machine Theory
    13, 1978, on sharing pulls out. As far as the bars may tip all differences are evened out by a share; beyond, they
    lie on their stops, and no more is shared.
    """

    effect = "coupling"
    needs = _SEVERAL

    def __init__(self, setting: Setting) -> None:
        super().__init__(setting)
        random, count = setting.random, len(self.rig.chambers)
        arms = random.uniform(0.7, 1.3, count)
        self._arms = arms / arms.sum()
        self._share = random.uniform(0.12, 0.3)
        self._tips = random.uniform(0.15, 0.5)

    def wall(self, path: Path, kpa: Floats, deflection: Floats, strength: float) -> Floats:
        unlike = deflection - (deflection @ self._arms)[:, None]
        tipped = self._tips * np.tanh(unlike / self._tips)
        return deflection - (1 - np.exp(-strength * self._share)) * tipped
