"""Regulator: a settled chamber holds another pressure than the one commanded."""

import numpy as np

from labrig.arrays import Floats
from labrig.bench._nature import Law, Path, Setting
from labrig.bench.development._places import either_way, full, some


class WrongGain(Law):
    """Sensitivity error: each chamber's sensor is off by a factor of its own.

    J. P. Bentley, Principles of Measurement Systems, 4th ed., Pearson, 2005.
    """

    effect = "regulator"

    def __init__(self, setting: Setting) -> None:
        super().__init__(setting)
        self._gain = either_way(setting, 0.04, 0.15, 0.8)

    def pressure(self, path: Path, kpa: Floats, strength: float) -> Floats:
        return kpa * np.maximum(1 + strength * self._gain, 0.0)


class ZeroOffset(Law):
    """Zero error: the regulator holds a constant pressure too much or too little; of some, only while they are open.

    J. Fraden, Handbook of Modern Sensors, 4th ed., Springer, 2010.
    """

    effect = "regulator"

    def __init__(self, setting: Setting) -> None:
        super().__init__(setting)
        self._offset = either_way(setting, 0.02, 0.08, 0.8)
        self._only_open = bool(setting.random.random() < 0.5)

    def pressure(self, path: Path, kpa: Floats, strength: float) -> Floats:
        load = full(self.rig, kpa)
        acts = np.clip(load / 0.02, 0.0, 1.0) if self._only_open else 1.0
        return kpa + strength * self.rig.high_kpa * self._offset * acts


class DeadBand(Law):
    """Dead band: below a threshold the valve does not open; above it the loss stays, or fades towards full scale.

    G. Tao, P. V. Kokotovic, Adaptive Control of Systems with Actuator and Sensor Nonlinearities, Wiley, 1996.
    """

    effect = "regulator"

    def __init__(self, setting: Setting) -> None:
        super().__init__(setting)
        self._band = some(setting.random, len(self.rig.chambers), 0.04, 0.12, 0.8)
        self._fades = bool(setting.random.random() < 0.5)

    def pressure(self, path: Path, kpa: Floats, strength: float) -> Floats:
        band = np.minimum(strength * self._band, 0.95)
        load = full(self.rig, kpa)
        lost = np.clip(load, 0.0, band)
        if self._fades:
            lost = lost * np.clip((1 - load) / (1 - band), 0.0, 1.0)
        return kpa - self.rig.high_kpa * lost


class BentCharacteristic(Law):
    """Terminal-based nonlinearity: right at zero and at full scale, off by a parabola in between.

    J. Fraden, Handbook of Modern Sensors, 4th ed., Springer, 2010.
    """

    effect = "regulator"

    def __init__(self, setting: Setting) -> None:
        super().__init__(setting)
        self._bow = either_way(setting, 0.02, 0.07, 0.8)

    def pressure(self, path: Path, kpa: Floats, strength: float) -> Floats:
        load = np.clip(full(self.rig, kpa), 0.0, 1.0)
        return kpa + strength * self.rig.high_kpa * self._bow * 4 * load * (1 - load)
