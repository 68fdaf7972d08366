"""Stiffening of the eleventh portion: entangled chains of finite length, and faces that meet and push each other."""

import numpy as np

from labrig.arrays import Floats
from labrig.bench._nature import Law, Path, Setting
from labrig.bench.development._places import full


class ExtendedTube(Law):
    """Extended tube: chains slip along the tubes of their entanglements, which softens, until they are drawn out.

    M. Kaliske, G. Heinrich, An extended tube-model for rubber elasticity, Rubber Chemistry and Technology 72, 1999.
    Drawn in one direction. The model is neo-Hookean at each place of its curve and was matched at one deflection;
    the true wall is stiffer before it, softer beyond, and stiffer again where chains come to their ends.
    """

    effect = "stiffening"

    def __init__(self, setting: Setting) -> None:
        super().__init__(setting)
        random, count = setting.random, len(self.rig.chambers)
        self._strain = random.uniform(0.35, 0.9) * random.uniform(0.9, 1.1, count)  # at full pressure
        self._tube = random.uniform(0.4, 0.85)  # the share of the entanglements in the stiffness at rest
        self._release = random.uniform(0.2, 0.9)  # beta: how freely they slip
        drawn = self._invariant(1 + self._strain.mean())
        self._short = min(random.uniform(0.05, 0.45) / drawn, 0.2)  # delta squared: how short the chains are
        self._right = random.uniform(0.4, 0.8)  # the deflection at which both agree
        self._at = np.linspace(-2.0, 4.0, 1201)
        self._step = self._at[1] - self._at[0]

    @staticmethod
    def _invariant(stretch: Floats) -> Floats:
        return stretch**2 + 2 / stretch - 3

    def _stiffer(self, deflection: Floats, strain: float) -> Floats:
        """How much more load such a wall takes than a neo-Hookean one of the same stiffness at rest."""
        stretch = 1 + strain * np.where(np.abs(deflection) < 1e-4, 1e-4, deflection)
        stretch = np.maximum(stretch, 0.3)
        rubber = stretch - stretch**-2
        drawn = np.minimum(self._short * self._invariant(stretch), 0.9)
        chains = (1 - self._short) / (1 - drawn) ** 2 - self._short / (1 - drawn)
        chains /= 1 - 2 * self._short
        beta = self._release
        tubes = 2 / beta * (stretch ** (beta / 2 - 1) - stretch ** (-beta - 1)) / rubber
        return (1 - self._tube) * chains + self._tube * tubes

    def wall(self, path: Path, kpa: Floats, deflection: Floats, strength: float) -> Floats:
        out = deflection.copy()
        for c, strain in enumerate(self._strain):
            right = self._stiffer(np.array([self._right]), strain)
            load = self._at * (self._stiffer(self._at, strain) / right) ** strength
            rises = np.maximum(np.diff(load), 0.25 * self._step)  # a wall of these chains never snaps
            load = np.concatenate([[0.0], np.cumsum(rises)])
            load -= np.interp(0.0, self._at, load)
            own = deflection[:, c]
            out[:, c] += np.interp(own, load, self._at) - np.clip(own, self._at[0], self._at[-1])
        return out


class FacesMeet(Law):
    """Faces meet: cells of a bellows bulge until neighbours touch, and from then on they push each other apart.

    B. Mosadegh et al., Pneumatic networks for soft robotics that actuate rapidly, Advanced Functional Materials 24,
    2014. Two round faces touch in a patch whose area grows in proportion to how far they are pressed together; its
    push is that area times the pressure. The model has the cells apart all the way.
    """

    effect = "stiffening"

    def __init__(self, setting: Setting) -> None:
        super().__init__(setting)
        random, count = setting.random, len(self.rig.chambers)
        self._meet = random.uniform(0.2, 0.6) * random.uniform(0.85, 1.15, count)
        self._uneven = random.uniform(0.03, 0.1)  # not all faces meet at once
        self._push = random.uniform(0.15, 0.35) * random.uniform(0.85, 1.15, count)

    def wall(self, path: Path, kpa: Floats, deflection: Floats, strength: float) -> Floats:
        load = np.clip(full(self.rig, kpa), 0.0, 3.0)
        pressed = np.clip(deflection, -1.0, 3.0) - self._meet
        patch = self._uneven * np.logaddexp(0.0, pressed / self._uneven)
        return deflection + strength * self._push * load * patch / (1 - self._meet)
