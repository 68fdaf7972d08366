"""Leaks of the fifth portion: turbulent gaps, losses that are partly made up, check valves of one manifold."""

import numpy as np

from labrig.arrays import Floats
from labrig.bench._nature import Law, Path, Setting
from labrig.bench.development._places import full, some


class TurbulentGap(Law):
    """Blasius: through a smooth gap the flow is turbulent: it goes with the power 4/7 of the pressure, and ends.

    H. Blasius, Das Ähnlichkeitsgesetz bei Reibungsvorgängen in Flüssigkeiten, Forschungsarbeiten VDI 131, 1913.
    """

    effect = "leak"

    def __init__(self, setting: Setting) -> None:
        super().__init__(setting)
        self._per_s = some(setting.random, len(self.rig.chambers), 1 / 600, 1 / 150, 0.7)

    def pressure(self, path: Path, kpa: Floats, strength: float) -> Floats:
        load = full(self.rig, kpa)
        left = np.abs(load) ** (3 / 7) - (3 / 7) * strength * self._per_s * path.hold_s[:, None]
        return np.sign(load) * np.maximum(left, 0.0) ** (7 / 3) * self.rig.high_kpa


class PartlyMadeUp(Law):
    """Leak against a throttled supply: what is lost is made up in part, so that the pressure falls to a new balance.

    P. Beater, Pneumatic Drives: System Design, Modelling and Control, Springer, 2007; from laboratory experience. A
    regulator that has closed its main valve still bleeds a little air in.
    """

    effect = "leak"

    def __init__(self, setting: Setting) -> None:
        super().__init__(setting)
        random, count = setting.random, len(self.rig.chambers)
        self._tau_s = np.exp(random.uniform(np.log(6), np.log(60), count))
        self._lost = some(random, count, 0.1, 0.35, 0.75)

    def pressure(self, path: Path, kpa: Floats, strength: float) -> Floats:
        keeps = np.exp(-strength * self._lost)
        return kpa * (keeps + (1 - keeps) * np.exp(-path.hold_s[:, None] / self._tau_s))


class SharedManifold(Law):
    """Manifold with one leak: all lose through it, each by its own check valve, the faster, the more it carries.

    A. Parr, Hydraulics and Pneumatics: A Technician's and Engineer's Guide, Butterworth-Heinemann, 1991.
    """

    effect = "leak"
    needs = frozenset({"several"})

    def __init__(self, setting: Setting) -> None:
        super().__init__(setting)
        random, count = setting.random, len(self.rig.chambers)
        self._passes = some(random, count, 0.4, 1.6, 0.8)
        self._per_s = random.uniform(1 / 200, 1 / 60)

    def pressure(self, path: Path, kpa: Floats, strength: float) -> Floats:
        carries = np.abs(full(self.rig, kpa)).mean(axis=1, keepdims=True)
        gone = strength * self._per_s * carries * path.hold_s[:, None]
        return kpa / (1 + self._passes * gone)
