"""Regulator: the pressure that the valve makes is not the one that it was told."""

from typing import ClassVar

import numpy as np

from labrig.arrays import Floats
from labrig.bench._nature import Law, Path, Setting


class SupplySaturation(Law):
    """A supply that is too weak: above its limit the pressure hardly rises any more.

    P. Beater, Pneumatic Drives, Springer, 2007.
    """

    effect: ClassVar[str] = "regulator"

    def __init__(self, setting: Setting) -> None:
        super().__init__(setting)
        self._top_kpa = np.maximum(setting.path.kpa.max(axis=0), 1e-6)
        self._depth = setting.random.uniform(0.15, 0.35)
        self._droop = setting.random.uniform(0.0, 0.15)

    def pressure(self, path: Path, kpa: Floats, strength: float) -> Floats:
        """The pressure up to the limit, and a little of what is above."""
        if strength == 0:
            return kpa
        limit_kpa = self._top_kpa / (1 + self._depth * strength)
        return kpa - (1 - self._droop) * np.maximum(kpa - limit_kpa, 0.0)


class QuantisedSetPoint(Law):
    """A coarse converter: set-points in steps of several kPa, each chamber with an offset of its own.

    B. Widrow and I. Kollar, Quantization Noise, Cambridge University Press, 2008.
    """

    effect: ClassVar[str] = "regulator"

    def __init__(self, setting: Setting) -> None:
        super().__init__(setting)
        high_kpa = setting.rig.high_kpa
        self._step_kpa = np.full(len(high_kpa), high_kpa.mean() / setting.random.uniform(7, 13))
        self._offset = setting.random.uniform(-0.3, 0.3, len(high_kpa))

    def pressure(self, path: Path, kpa: Floats, strength: float) -> Floats:
        """The pressure with the rounding error of its set-point."""
        if strength == 0:
            return kpa
        step_kpa = strength * self._step_kpa
        codes = np.round(path.commanded_kpa / step_kpa + self._offset) - self._offset
        error_kpa = np.where(path.commanded_kpa > 0, codes * step_kpa - path.commanded_kpa, 0.0)
        follows = np.clip(kpa / np.where(path.commanded_kpa > 0, path.commanded_kpa, 1.0), 0.0, 1.5)
        return np.maximum(kpa + error_kpa * follows, np.minimum(kpa, 0.0))


class SensorSShape(Law):
    """A piezoresistive sensor with a cubic error: right at both ends and in the middle, S-shaped in between.

    K. Matsuda, K. Suzuki, K. Yamamura and Y. Kanda, Journal of Applied Physics, 1993.
    """

    effect: ClassVar[str] = "regulator"

    def __init__(self, setting: Setting) -> None:
        super().__init__(setting)
        random = setting.random
        self._amount = (
            random.choice([-1.0, 1.0])
            * random.uniform(0.3, 0.7)
            * random.uniform(0.6, 1.4, len(setting.rig.chambers))
        )
        self._middle = random.uniform(0.4, 0.6)

    def pressure(self, path: Path, kpa: Floats, strength: float) -> Floats:
        """The pressure with the sensor's error at it."""
        load = np.clip(kpa / self.rig.high_kpa, -0.2, 1.2)
        error = load * (1 - load) * (self._middle - load)
        return kpa + strength * self._amount * error * self.rig.high_kpa
