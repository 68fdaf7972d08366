"""Leaks of the sixth portion: sites that take gas up, a foam of cells, air that gets away bubble by bubble."""

import numpy as np

from labrig.arrays import Floats
from labrig.bench._nature import Law, Path, Setting
from labrig.bench.development._places import full, some

_MANY = 1009


class FillsSites(Law):
    """Dual sorption: the wall dissolves gas in proportion to the pressure, and binds some at sites that are soon full.

    W. R. Vieth, J. M. Howell, J. H. Hsieh, Dual sorption theory, J. Membrane Science 1, 1976.
    """

    effect = "leak"

    def __init__(self, setting: Setting) -> None:
        super().__init__(setting)
        random, count = setting.random, len(self.rig.chambers)
        self._tau_s = np.exp(random.uniform(np.log(8), np.log(60), count))
        self._half_at, self._bound = random.uniform(0.1, 0.5), random.uniform(0.4, 1.0)
        self._takes = some(random, count, 0.08, 0.25, 0.8)

    def pressure(self, path: Path, kpa: Floats, strength: float) -> Floats:
        size = np.abs(full(self.rig, kpa))
        sites = self._bound * (1 + self._half_at) / (self._half_at + size) + (1 - self._bound)
        gone = -np.expm1(-path.hold_s[:, None] / self._tau_s)
        return kpa * np.exp(-strength * self._takes * sites * gone)


class FoamOfCells(Law):
    """Foam of cells: each cell of a foamed wall loses its air at a rate of its own (a gamma law): a power of time.

    W. Feller, An Introduction to Probability Theory and Its Applications II, Wiley, 1966 (the gamma law's transform).
    """

    effect = "leak"

    def __init__(self, setting: Setting) -> None:
        super().__init__(setting)
        random, count = setting.random, len(self.rig.chambers)
        self._unlike_s = np.exp(random.uniform(np.log(3), np.log(40)))
        self._power = some(random, count, 0.05, 0.2, 0.75)

    def pressure(self, path: Path, kpa: Floats, strength: float) -> Floats:
        return kpa * (1 + path.hold_s[:, None] / self._unlike_s) ** (-strength * self._power)


class BubbleByBubble(Law):
    """Dripping: a seal lets a bubble out each time enough has gathered behind it, and between two it is tight.

    R. Shaw, The Dripping Faucet as a Model Chaotic System, Aerial Press, 1984. When the first one goes differs from
    actuation to actuation.
    """

    effect = "leak"

    def __init__(self, setting: Setting) -> None:
        super().__init__(setting)
        random, count = setting.random, len(self.rig.chambers)
        self._every_s = random.uniform(1.5, 8.0, count)
        self._first = random.uniform(0.0, 1.0, (_MANY, count))
        self._loses = some(random, count, 1 / 500, 1 / 150, 0.7) * self._every_s  # with each bubble
        self._power = random.uniform(0.5, 1.5)

    def pressure(self, path: Path, kpa: Floats, strength: float) -> Floats:
        per = self._every_s / np.maximum(np.abs(full(self.rig, kpa)), 0.05) ** self._power
        phase = path.hold_s[:, None] / per + self._first[path.event % _MANY]
        bubbles = np.floor(phase)
        soft = np.clip((phase - bubbles) / 0.05, 0.0, 1.0)  # a bubble takes a moment to get out
        gone = np.maximum(bubbles - 1 + soft, 0.0)
        return kpa * np.exp(-strength * self._loses * gone)
