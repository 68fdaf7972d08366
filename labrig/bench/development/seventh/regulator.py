"""Regulators of the seventh portion: a tap in the stream, and a coil whose iron saturates."""

import numpy as np

from labrig.arrays import Floats
from labrig.bench._nature import Law, Path, Setting
from labrig.bench.development._places import full, some

_ROOM_KPA = 101.3


class TapInTheStream(Law):
    """Tap in the stream: a bleed flows past the sensor, which misses the stream's own pressure, by its squared speed.

    D. Bernoulli, Hydrodynamica, Strasbourg, 1738. The bleed goes with the pressure, and the air is as dense as it is
    compressed: the chamber holds too much, mostly at high set-points, or too little if the tap faces the stream.
    """

    effect = "regulator"

    def __init__(self, setting: Setting) -> None:
        super().__init__(setting)
        random, count = setting.random, len(self.rig.chambers)
        faces = random.random(count) < (0.8 if random.random() < 0.3 else 0.0)
        self._misses = some(random, count, 0.04, 0.14, 0.85) * np.where(faces, -1.0, 1.0)

    def pressure(self, path: Path, kpa: Floats, strength: float) -> Floats:
        load = full(self.rig, kpa)
        dense = np.maximum(_ROOM_KPA + kpa, 0.0) / (_ROOM_KPA + self.rig.high_kpa)
        return kpa + strength * self.rig.high_kpa * self._misses * load * np.abs(load) * dense


class SaturatedIron(Law):
    """Saturated iron: a coil's pull goes with the current at first and then levels off by an arctangent.

    R. M. Bozorth, Ferromagnetism, Van Nostrand, 1951 (the magnetisation of iron is fitted by such a curve). It was set
    right at half of the range, so that it gives too much below and too little above.
    """

    effect = "regulator"

    def __init__(self, setting: Setting) -> None:
        super().__init__(setting)
        random, count = setting.random, len(self.rig.chambers)
        self._bends = random.uniform(0.6, 2.0) * random.uniform(0.85, 1.15, count)
        self._size = some(random, count, 0.3, 0.9, 0.9)

    def pressure(self, path: Path, kpa: Floats, strength: float) -> Floats:
        load = full(self.rig, kpa)
        pulls = 0.5 * np.arctan(self._bends * load) / np.arctan(0.5 * self._bends)
        return kpa + strength * self._size * self.rig.high_kpa * (pulls - load)
