"""Tension of the eighth portion: membranes that were mounted tighter, looser or more crookedly than the model's."""

from collections.abc import Callable

import numpy as np

from labrig.arrays import Floats
from labrig.bench._nature import Law, Path, Setting
from labrig.bench.development._places import either_way, full, some


def _held(deflect: Callable[[Floats], Floats], kpa: Floats, pull: Callable[[Floats], Floats]) -> Floats:
    """The deflection (T, C) at which `pull` (kpa of deflection, of its sign) and the wall balance the pressures."""
    free = deflect(kpa)
    low, high = np.minimum(free, 0.0), np.maximum(free, 0.0)
    for _ in range(30):
        middle = (low + high) / 2
        above = deflect(kpa - pull(middle)) > middle
        low, high = np.where(above, middle, low), np.where(above, high, middle)
    return (low + high) / 2


def _cubic_membrane(deflection: Floats, tension: Floats, stretch: Floats) -> Floats:
    """The deflection of a membrane with so many times its modelled tension, the cubic part unchanged."""
    load = deflection + stretch * deflection**3
    root = np.sqrt(3 * stretch / tension)
    return 2 / root * np.sinh(np.arcsinh(1.5 * root * load / tension) / 3)


class InitialTension(Law):
    """Initial tension: the membranes were mounted tighter than modelled, and pull back in proportion to deflection.

    S. Timoshenko and S. Woinowsky-Krieger, Theory of Plates and Shells, McGraw-Hill, 1959. The pull takes a share of
    the pressure; the wall's own curve, which bends, does the rest. Each membrane was clamped by hand.
    """

    effect = "tension"
    needs = frozenset({"curved"})

    def __init__(self, setting: Setting) -> None:
        super().__init__(setting)
        self._pull = some(setting.random, len(self.rig.chambers), 0.08, 0.25)

    def wall(self, path: Path, kpa: Floats, deflection: Floats, strength: float) -> Floats:
        if strength == 0:
            return deflection
        pull = strength * self._pull * self.rig.high_kpa
        held = _held(self.rig.deflection, kpa, lambda middle: pull * middle)
        return deflection + held - self.rig.deflection(kpa)


class FilmOnRing(Law):
    """Film on a ring: one film over all openings has another residual stress than modelled, tighter or slacker.

    J. J. Vlassak and W. D. Nix, A new bulge test technique for the determination of Young's modulus and Poisson's ratio
    of thin films, Journal of Materials Research 7(12), 1992. Pressure is a linear term, of the stress, and a cubic
    one, of the stretch; only the linear one is wrong, so that small deflections are the most wrong.
    """

    effect = "tension"
    needs = frozenset({"curved"})

    def __init__(self, setting: Setting) -> None:
        super().__init__(setting)
        random, count = setting.random, len(self.rig.chambers)
        self._log = random.uniform(0.2, 0.4) * random.choice([-1.0, 1.0, 1.0])
        self._stretch = random.uniform(1.0, 4.0) * random.uniform(0.85, 1.15, count)

    def wall(self, path: Path, kpa: Floats, deflection: Floats, strength: float) -> Floats:
        tension = np.full(len(self._stretch), np.exp(strength * self._log))
        return _cubic_membrane(deflection, tension, self._stretch)


class LooseSkin(Law):
    """Loose skin: some membranes were cut too large, and their slack blows out at the first breath of pressure.

    C. H. Jenkins (editor), Gossamer Spacecraft: Membrane and Inflatable Structures Technology, AIAA, 2001. Folds have
    no stiffness of their own; once they are drawn, the membrane is as modelled.
    """

    effect = "tension"
    needs = frozenset({"curved"})

    def __init__(self, setting: Setting) -> None:
        super().__init__(setting)
        random, count = setting.random, len(self.rig.chambers)
        self._slack = some(random, count, 0.05, 0.12, share=0.7)
        self._drawn = random.uniform(0.06, 0.15, count)  # the share of the pressure that draws the folds

    def wall(self, path: Path, kpa: Floats, deflection: Floats, strength: float) -> Floats:
        return deflection + strength * self._slack * np.tanh(full(self.rig, kpa) / self._drawn)


class PreStrainOfElastomer(Law):
    """Pre-strain of an elastomer: each sheet was strained before it was framed, but not by what the drawing says.

    R. Pelrine, R. Kornbluh, Q. Pei and J. Joseph, High-speed electrically actuated elastomers with strain greater than
    100%, Science 287, 2000. The tension is that of a neo-Hookean sheet strained alike both ways: one less the sixth
    power of the inverse stretch. It levels off, so that a wall far out hardly knows how it was mounted.
    """

    effect = "tension"
    needs = frozenset({"curved"})

    def __init__(self, setting: Setting) -> None:
        super().__init__(setting)
        random, count = setting.random, len(self.rig.chambers)
        self._drawn = random.uniform(0.06, 0.12)  # the drawing's strain
        self._log = either_way(setting, 0.15, 0.35)
        self._rise = random.uniform(0.3, 0.6, count)  # of the stretch, at full deflection

    def wall(self, path: Path, kpa: Floats, deflection: Floats, strength: float) -> Floats:
        further = np.sqrt(1 + self._rise * np.clip(np.abs(deflection), 0.0, 3.0) ** 2)
        modelled = 1 - ((1 + self._drawn) * further) ** -6
        mounted = 1 - ((1 + self._drawn * np.exp(strength * self._log)) * further) ** -6
        return deflection + self.rig.deflection(kpa * modelled / mounted) - self.rig.deflection(kpa)


class SkinPulledAskew(Law):
    """Skin pulled askew: one skin over all chambers was drawn tight at one end and came to lie slack at the other.

    D. J. Steigmann and A. C. Pipkin, Finite deformations of wrinkled membranes, Quarterly Journal of Mechanics and
    Applied Mathematics 42, 1989. The tension runs from too high to too low along the row of chambers.
    """

    effect = "tension"
    needs = frozenset({"curved"})

    def __init__(self, setting: Setting) -> None:
        super().__init__(setting)
        random, count = setting.random, len(self.rig.chambers)
        place = np.linspace(-1, 1, count) if count > 1 else np.ones(1)
        slope = random.uniform(0.25, 0.5) * random.choice([-1.0, 1.0])
        self._log = slope * (place - random.uniform(-0.3, 0.3))
        self._stretch = np.full(count, random.uniform(1.0, 3.0))

    def wall(self, path: Path, kpa: Floats, deflection: Floats, strength: float) -> Floats:
        return _cubic_membrane(deflection, np.exp(strength * self._log), self._stretch)
