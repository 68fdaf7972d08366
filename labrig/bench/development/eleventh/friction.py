"""Friction of the eleventh portion: a bolted joint that slips by and by, and talc that wears off in a session."""

import numpy as np

from labrig.arrays import Floats
from labrig.bench._nature import Law, Path, Setting
from labrig.bench.development._story import finely


class BoltedJoint(Law):
    """Valanis: a joint sticks, slips here and there, and then slides on a slope; one equation has all three.

    L. Gaul, J. Lenz, Nonlinear dynamics of structures assembled by bolted joints, Acta Mechanica 125, 1997. The slope
    of the force over the way goes with what is left to full sliding, over one less a part of what is gone; the larger
    that part, the longer it sticks.
    """

    effect = "friction"

    def __init__(self, setting: Setting) -> None:
        super().__init__(setting)
        random, count = setting.random, len(self.rig.chambers)
        self._limit = random.uniform(0.03, 0.07) * random.uniform(0.75, 1.25, count)
        self._gives = random.uniform(0.04, 0.1)  # the way to its limit, if it went on as it begins
        self._slopes = random.uniform(0.05, 0.35)  # further force over a full stroke, sliding
        self._sticks = random.uniform(0.2, 0.7)

    def wall(self, path: Path, kpa: Floats, deflection: Floats, strength: float) -> Floats:
        step, _, where = finely(path, deflection, 0.01)
        at, force = np.zeros(step.shape[1]), np.zeros(step.shape[1])
        out = np.empty_like(step)
        for i in range(len(step)):
            used_up = np.sign(step[i]) * (force - self._slopes * at)
            stiff = (1 - used_up) / (1 - self._sticks * used_up) / self._gives
            at = at + step[i]
            force = force + stiff * step[i]
            force = self._slopes * at + np.clip(force - self._slopes * at, -1.0, 1.0)
            out[i] = force
        return deflection - strength * self._limit * out[where]


class TalcWearsOff(Law):
    """Talc that wears off: skins slide easily at first, and rub the more, the further they have slid since powdered.

    J. F. Archard, Contact and rubbing of flat surfaces, J. Applied Physics 24, 1953: what is worn off goes with the
    way, and what is left of the film as an exponential of it. Before each session somebody powders them again.
    """

    effect = "friction"

    def __init__(self, setting: Setting) -> None:
        super().__init__(setting)
        random, count = setting.random, len(self.rig.chambers)
        self._powdered = random.uniform(0.015, 0.035) * random.uniform(0.75, 1.25, count)
        self._bare = random.uniform(2.0, 5.0)  # how many times more it rubs in the end
        self._lasts = random.uniform(4.0, 15.0) * random.uniform(0.7, 1.4, count)  # full strokes
        self._gives = random.uniform(0.03, 0.09)

    def wall(self, path: Path, kpa: Floats, deflection: Floats, strength: float) -> Floats:
        step, _, where = finely(path, deflection, 0.02)
        session = path.session[np.searchsorted(where, np.arange(len(step)))]
        held, slid = np.zeros(step.shape[1]), np.zeros(step.shape[1])
        out = np.empty_like(step)
        for i in range(len(step)):
            if i > 0 and session[i] != session[i - 1]:
                slid = np.zeros_like(slid)
            limit = self._bare + (1 - self._bare) * np.exp(-slid / self._lasts)
            pulled = held + step[i] / self._gives
            held = np.clip(pulled, -limit, limit)
            slid = slid + self._gives * np.abs(pulled - held)
            out[i] = held
        return deflection - strength * self._powdered * out[where]
