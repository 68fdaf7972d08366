"""Further regulators: coarse steps, droop under flow, one wrong reference for all, bows, two ranges."""

import numpy as np

from labrig.arrays import Floats
from labrig.bench._nature import Law, Path, Setting
from labrig.bench.development._places import either_way, full, some


class QuantisedSetPoint(Law):
    """Quantisation: the set-point goes through a converter with few steps, which rounds it or cuts it off.

    B. Widrow, I. Kollár, Quantization Noise, Cambridge University Press, 2008.
    """

    effect = "regulator"

    def __init__(self, setting: Setting) -> None:
        super().__init__(setting)
        self._step = setting.random.uniform(0.05, 0.15) * setting.random.uniform(
            0.9, 1.1, len(self.rig.chambers)
        )
        self._rounds = float(setting.random.choice([0.5, 0.0]))

    def pressure(self, path: Path, kpa: Floats, strength: float) -> Floats:
        if strength <= 0:
            return kpa
        step = strength * self._step * self.rig.high_kpa
        held = step * np.floor(path.commanded_kpa / step + self._rounds + 1e-9)
        return kpa + held - path.commanded_kpa


class DroopUnderFlow(Law):
    """Droop: a self-acting regulator gives less the more it must deliver; a bleed takes the root of the pressure.

    H. D. Baumann, Control Valve Primer, 4th ed., ISA, 2009.
    """

    effect = "regulator"

    def __init__(self, setting: Setting) -> None:
        super().__init__(setting)
        self._droop = some(setting.random, len(self.rig.chambers), 0.04, 0.14, 0.8)
        self._bleed = setting.random.uniform(0.005, 0.05)

    def pressure(self, path: Path, kpa: Floats, strength: float) -> Floats:
        load = np.maximum(full(self.rig, kpa), 0.0)
        flow = np.sqrt(load + self._bleed) - np.sqrt(self._bleed)
        return kpa - self.rig.high_kpa * load * -np.expm1(-strength * self._droop * flow / (load + 1e-9))


class WrongReference(Law):
    """Calibration line: all sensors were set by one wrong gauge, and share its factor and its offset.

    E. O. Doebelin, Measurement Systems: Application and Design, 5th ed., McGraw-Hill, 2004.
    """

    effect = "regulator"

    def __init__(self, setting: Setting) -> None:
        super().__init__(setting)
        random = setting.random
        self._gain = random.uniform(0.03, 0.1) * random.choice([-1.0, 1.0])
        self._offset_kpa = (
            random.uniform(0.01, 0.05) * random.choice([-1.0, 1.0]) * np.mean(self.rig.high_kpa)
        )

    def pressure(self, path: Path, kpa: Floats, strength: float) -> Floats:
        return kpa * np.exp(strength * self._gain) + strength * self._offset_kpa


class SineBow(Law):
    """S-shaped nonlinearity: right at zero, half and full scale, too much on one side of half and too little beyond.

    R. Pallàs-Areny, J. G. Webster, Sensors and Signal Conditioning, 2nd ed., Wiley, 2001.
    """

    effect = "regulator"

    def __init__(self, setting: Setting) -> None:
        super().__init__(setting)
        self._bow = either_way(setting, 0.02, 0.06, 0.8)

    def pressure(self, path: Path, kpa: Floats, strength: float) -> Floats:
        load = np.clip(full(self.rig, kpa), 0.0, 1.0)
        return kpa + strength * self.rig.high_kpa * self._bow * np.sin(2 * np.pi * load)


class TwoRanges(Law):
    """Two ranges: above a switching point another sensor takes over, with a zero and a factor of its own.

    J. G. Webster, H. Eren (eds.), Measurement, Instrumentation, and Sensors Handbook, 2nd ed., CRC Press, 2014.
    """

    effect = "regulator"

    def __init__(self, setting: Setting) -> None:
        super().__init__(setting)
        count = len(self.rig.chambers)
        self._from = setting.random.uniform(0.35, 0.65) * np.ones(count)
        self._jump = either_way(setting, 0.03, 0.1, 0.7)
        self._gain = np.where(self._jump != 0, setting.random.uniform(-0.1, 0.1, count), 0.0)

    def pressure(self, path: Path, kpa: Floats, strength: float) -> Floats:
        load = full(self.rig, kpa)
        past = np.maximum(load - self._from, 0.0)
        error = np.where(load > self._from, self._jump, 0.0) + self._gain * past
        return kpa + strength * self.rig.high_kpa * error
