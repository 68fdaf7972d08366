"""Tension of the seventh portion: cloth whose crimp is pulled out, and the slack spokes of a wheel."""

import numpy as np

from labrig.arrays import Floats
from labrig.bench._nature import Setting
from labrig.bench.development._places import some
from labrig.bench.development.tension import HeldBack


class CrimpPulledOut(HeldBack):
    """Crimp: tight cloth holds back by the height of its waves, the root of the crimp that is left, until it is flat.

    F. T. Peirce, The geometry of cloth structure, J. Textile Institute 28, 1937.
    """

    def __init__(self, setting: Setting) -> None:
        super().__init__(setting)
        random, count = setting.random, len(self.rig.chambers)
        self._flat_at = random.uniform(0.6, 1.6) * random.uniform(0.9, 1.1, count)
        self._seats = random.uniform(0.05, 0.15)
        self._most = some(random, count, 0.06, 0.16, 0.9)

    def _held(self, deflection: Floats) -> Floats:
        left = np.sqrt(np.maximum(1 - np.abs(deflection) / self._flat_at, 0.0))
        return self._most * np.tanh(deflection / self._seats) * left


class SpokesOfAWheel(HeldBack):
    """Spokes: tension lets thin threads all around resist from both sides, until those behind go slack one by one.

    H. P. Gavin, Bicycle-wheel spoke patterns and spoke fatigue, J. Engineering Mechanics 122, 1996. What counts here
    is what the threads behind add; it levels off at the tension itself.
    """

    def __init__(self, setting: Setting) -> None:
        super().__init__(setting)
        random, count = setting.random, len(self.rig.chambers)
        self._slack_at = random.uniform(0.05, 0.35) * random.uniform(0.85, 1.15, count)
        self._most = some(random, count, 0.06, 0.16, 0.9)

    def _held(self, deflection: Floats) -> Floats:
        way = np.maximum(np.abs(deflection) / self._slack_at, 1e-12)
        slack = np.arccos(np.minimum(1 / way, 1.0))  # spokes within this angle are slack
        tight = np.sin(slack) + way * (np.pi / 4 - slack / 2 - np.sin(2 * slack) / 4)
        return self._most * np.sign(deflection) * tight
