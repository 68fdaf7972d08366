"""Hysteresis: what a wall does depends on where it came from, not on how fast."""

from typing import ClassVar

import numpy as np

from labrig.arrays import Floats
from labrig.bench._nature import Law, Path, Setting
from labrig.bench.exam.tools import confined, history, recursion


class ColemanHodgdon(Law):
    """Duhem hysteresis: a branch that forgets exponentially, along the travelled load, the last turning point.

    B. D. Coleman and M. L. Hodgdon, International Journal of Engineering Science, 1986.
    """

    effect: ClassVar[str] = "hysteresis"

    def __init__(self, setting: Setting) -> None:
        super().__init__(setting)
        count = len(setting.rig.chambers)
        self._forget = setting.random.uniform(2.5, 7.0) * setting.random.uniform(0.8, 1.25, count)
        self._width = setting.random.uniform(0.02, 0.045) * setting.random.uniform(0.7, 1.4, count)

    def wall(self, path: Path, kpa: Floats, deflection: Floats, strength: float) -> Floats:
        """The walls lag behind the load's direction by a width."""
        past = history(path, kpa / self.rig.high_kpa)
        move = np.diff(past.load, axis=0)
        decay = np.exp(-self._forget * np.abs(move))
        push = np.concatenate([np.zeros((1, move.shape[1])), (1 - decay) * np.sign(move)])
        branch = [recursion(decay[:, c], push[:, c]).real for c in range(move.shape[1])]
        return deflection - strength * self._width * past.back(np.column_stack(branch))


class KrasnoselskiiPokrovskii(Law):
    """Generalised play between two ramps: a sum of kernels, each with thresholds of its own up and down.

    M. A. Krasnosel'skii and A. V. Pokrovskii, Systems with Hysteresis, Springer, 1989.
    """

    effect: ClassVar[str] = "hysteresis"

    def __init__(self, setting: Setting) -> None:
        super().__init__(setting)
        random, kernels = setting.random, 6
        self._up = random.uniform(0.15, 0.85, kernels)
        self._down = self._up - random.uniform(0.05, 0.35, kernels)
        self._ramp = random.uniform(0.08, 0.3)
        self._weight = random.dirichlet(np.full(kernels, 2.0))
        self._amount = random.uniform(0.06, 0.14) * random.uniform(0.7, 1.4, len(setting.rig.chambers))

    def wall(self, path: Path, kpa: Floats, deflection: Floats, strength: float) -> Floats:
        """The walls are where the kernels leave them, about the middle of each kernel's two ramps."""
        past = history(path, kpa / self.rig.high_kpa)
        load = past.load[:, None, :]
        late = np.clip((load - self._up[:, None]) / self._ramp, 0, 1)
        soon = np.clip((load - self._down[:, None]) / self._ramp, 0, 1)
        kernel = confined(late, soon) - (late + soon) / 2
        change = np.einsum("njc,j->nc", kernel, self._weight)
        return deflection + strength * self._amount * past.back(change)
