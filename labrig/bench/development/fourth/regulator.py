"""Regulators of the fourth portion: converters with wrong bits, nozzles with flappers, bridges of one gauge."""

import numpy as np

from labrig.arrays import Floats
from labrig.bench._nature import Law, Path, Setting
from labrig.bench.development._places import some


def _share(law: Law, kpa: Floats) -> Floats:
    """Pressures as shares (T, C) of the way from the lower limits to the upper ones."""
    low = law.rig.low_kpa
    return np.clip((kpa - low) / (law.rig.high_kpa - low), 0.0, 1.0)


def _range(law: Law) -> Floats:
    """The ranges (C,) in kPa."""
    return law.rig.high_kpa - law.rig.low_kpa


class BitWeights(Law):
    """Wrong bit weights: each of a converter's upper bits adds too much or too little, with steps where they change.

    W. Kester (ed.), The Data Conversion Handbook, Newnes, 2005.
    """

    effect = "regulator"

    def __init__(self, setting: Setting) -> None:
        super().__init__(setting)
        random, count = setting.random, len(self.rig.chambers)
        self._bits = 2.0 ** np.arange(1, int(random.integers(4, 7)))  # 2, 4, ...: the weight is one over it
        size = some(random, count, 0.03, 0.09, 0.85)
        self._off = random.normal(size=(len(self._bits), count)) * size / np.sqrt(self._bits)[:, None]

    def pressure(self, path: Path, kpa: Floats, strength: float) -> Floats:
        share = np.minimum(_share(self, kpa), 1 - 1e-9)
        error = np.zeros_like(kpa)
        for bit, off in zip(self._bits, self._off, strict=True):
            error += np.floor(share * bit) % 2 * off
        return kpa + strength * _range(self) * error


class NozzleFlapper(Law):
    """Nozzle and flapper: its pressure falls with one over one plus the gap's square, straight only for small motions.

    H. E. Merritt, Hydraulic Control Systems, Wiley, 1967.
    """

    effect = "regulator"

    def __init__(self, setting: Setting) -> None:
        super().__init__(setting)
        random, count = setting.random, len(self.rig.chambers)
        self._gap = random.uniform(0.4, 1.0) * random.uniform(0.85, 1.15, count)
        self._moves = some(random, count, 0.15, 0.45, 0.9)

    def pressure(self, path: Path, kpa: Floats, strength: float) -> Floats:
        share = _share(self, kpa)
        most = 0.9 * self._gap
        moves = most * np.tanh(np.maximum(strength * self._moves, 1e-6) / most)
        first, last, now = (
            1 / (1 + (self._gap + moves * (1 - 2 * at)) ** 2) for at in (np.zeros(1), np.ones(1), share)
        )
        change = (now - first) / (last - first) - share
        return kpa + np.where(strength * self._moves > 0, _range(self) * change, 0.0)


class BridgeOfOneGauge(Law):
    """Quarter bridge: one active gauge makes a hyperbola of the line, set right at zero and at full scale.

    E. O. Doebelin, Measurement Systems: Application and Design, McGraw-Hill, 1966.
    """

    effect = "regulator"

    def __init__(self, setting: Setting) -> None:
        super().__init__(setting)
        random, count = setting.random, len(self.rig.chambers)
        self._bends = random.choice([-1.0, 1.0]) * some(random, count, 0.12, 0.4, 0.9)

    def pressure(self, path: Path, kpa: Floats, strength: float) -> Floats:
        share = _share(self, kpa)
        bends = np.expm1(np.clip(strength * self._bends, -3.0, 3.0))
        return kpa + _range(self) * share * ((1 + bends) / (1 + bends * share) - 1)
