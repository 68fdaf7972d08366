"""Regulators of the eleventh portion: a syringe full of air, and a small pump that works against a bleed hole."""

import numpy as np

from labrig.arrays import Floats
from labrig.bench._nature import Law, Path, Setting
from labrig.bench.development._places import full, some

_ATMOSPHERE_KPA = 101.3


class SyringeOfAir(Law):
    """Syringe of air: a motor pushes a piston as far as a straight line says, and the shut air obeys Boyle.

    R. Boyle, New Experiments Physico-Mechanical, second edition, 1662: volume times absolute pressure is constant. The
    pressure is a hyperbola of the stroke, the more bent the higher it goes, and the less the more the chamber itself
    grows; the line was drawn through rest and one calibrated pressure.
    """

    effect = "regulator"

    def __init__(self, setting: Setting) -> None:
        super().__init__(setting)
        random, count = setting.random, len(self.rig.chambers)
        most = self.rig.high_kpa / (self.rig.high_kpa + _ATMOSPHERE_KPA)
        grows = random.uniform(0.0, 0.5) * random.uniform(0.7, 1.3, count)  # what the chamber takes up
        self._bent = -np.log1p(-np.maximum(most * (1 - grows), 0.03))
        self._right = random.uniform(0.55, 1.0)  # where it was calibrated

    def pressure(self, path: Path, kpa: Floats, strength: float) -> Floats:
        bent = -np.expm1(-strength * self._bent)
        load = full(self.rig, kpa)
        return kpa * (1 - bent * self._right) / np.maximum(1 - bent * np.minimum(load, 1.2), 0.05)


class PumpAgainstBleed(Law):
    """Pump against a bleed hole: its duty sets the pressure at which it delivers what the hole lets out.

    A. A. Stanley et al., Lumped-parameter response time models for pneumatic circuit dynamics, J. Dynamic Systems,
    Measurement and Control 143, 2021, on orifices; a diaphragm pump's flow falls evenly to none at its stall pressure,
    the hole's goes with the root of the pressure. Since duty was calibrated, dust has narrowed the holes, or somebody
    has drilled them open: low pressures are off by the most, as shares, and those near stall by the least.
    """

    effect = "regulator"

    def __init__(self, setting: Setting) -> None:
        super().__init__(setting)
        random, count = setting.random, len(self.rig.chambers)
        self._stall = random.uniform(1.15, 2.2) * random.uniform(0.95, 1.05, count)  # in full pressures
        dust = some(random, count, 0.05, 0.2, share=0.85)
        self._narrower = dust * random.choice([1.0, -1.0], p=[0.7, 0.3])  # a logarithm

    def pressure(self, path: Path, kpa: Floats, strength: float) -> Floats:
        share = np.clip(full(self.rig, kpa) / self._stall, 0.0, 0.98)
        hole = np.exp(-strength * self._narrower)
        duty = np.sqrt(share) / (1 - share)
        root = 2 * duty / (hole + np.sqrt(hole**2 + 4 * duty**2))
        return kpa + (root**2 - share) * self._stall * self.rig.high_kpa
