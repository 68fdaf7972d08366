"""Delays of the eleventh portion: a tracker that estimates speeds, too, and bags that unfold before they fill."""

import numpy as np

from labrig.arrays import Floats
from labrig.bench._nature import Law, Path, Setting
from labrig.bench.development._story import pauses


class AlphaBetaTracker(Law):
    """Alpha-beta filter: what is told is a place and a speed that are led by the measured place, and so it runs over.

    T. R. Benedict, G. W. Bordner, Synthesis of an optimal set of radar track-while-scan smoothing equations, IRE
    Transactions on Automatic Control 7, 1962: their beta is half of the square of a small alpha. Trackers and sensor
    boards smooth so; after each step the told value comes late, goes beyond, and comes back.
    """

    effect = "delay"

    def __init__(self, setting: Setting) -> None:
        super().__init__(setting)
        random = setting.random
        self._smooths_s = random.uniform(0.4, 1.0)  # the tracker's interval over alpha
        self._square = 0.5 * random.uniform(0.85, 1.2)

    def seen(self, path: Path, deflection: Floats, values: Floats, strength: float) -> Floats:
        if strength <= 0:
            return values
        a = 1 / (strength * self._smooths_s)
        b = self._square * a**2
        turns = np.sqrt(b - a**2 / 4)
        pause_s = pauses(path)
        kept = np.exp(-0.5 * a * pause_s)
        c, s = kept * np.cos(turns * pause_s), kept * np.sin(turns * pause_s) / turns
        off, speed, before = np.zeros(values.shape[1]), np.zeros(values.shape[1]), self.rig.at_rest
        out = np.empty_like(values)
        for i in range(len(values)):
            off = off + values[i] - before
            before = values[i]
            off, speed = (
                (c[i] - 0.5 * a * s[i]) * off - s[i] * speed,
                s[i] * b * off + (c[i] + 0.5 * a * s[i]) * speed,
            )
            out[i] = values[i] - off
        return out


class BagUnfoldsFirst(Law):
    """Unfolding bag: a flat bag takes much air before there is any pressure in it, and little once it is taut.

    R. Niiyama et al., Pouch motors: printable soft actuators integrated with computational design, Soft Robotics 2,
    2015, on such bags; by the balance of mass, its time is what pressure adds to its air, over what the hose lets by.
    So it is late on its first way up, quick at high pressure, and has a long tail when it is vented.
    """

    effect = "delay"

    def __init__(self, setting: Setting) -> None:
        super().__init__(setting)
        random, count = setting.random, len(self.rig.chambers)
        self._taut_s = random.uniform(0.35, 0.8) * random.uniform(0.8, 1.25, count)
        self._unfolds = random.uniform(2.0, 6.0)  # how many times slower it is when flat
        self._taut_from = random.uniform(0.08, 0.25)  # of the full pressure

    def pressure(self, path: Path, kpa: Floats, strength: float) -> Floats:
        if strength <= 0:
            return kpa
        now = np.zeros(kpa.shape[1])
        out = np.empty_like(kpa)
        flat_kpa = self._taut_from * self.rig.high_kpa
        for i, pause_s in enumerate(pauses(path).tolist()):
            for _ in range(3):
                slower = 1 + self._unfolds / (1 + np.minimum(np.abs(now) / flat_kpa, 1e6)) ** 2
                tau_s = strength * self._taut_s * slower
                now = now + (kpa[i] - now) * -np.expm1(-pause_s / 3 / tau_s)
            out[i] = now
        return out
