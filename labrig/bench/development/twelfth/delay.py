"""Delays of the twelfth portion: an amplifier's low pass before the load cells, and readings that are old."""

import numpy as np

from labrig.arrays import Floats
from labrig.bench._nature import Law, Path, Setting
from labrig.bench.development._story import pauses
from labrig.bench.development.twelfth._sensors import added, sensors


class AmplifiersLowPass(Law):
    """Butterworth: the bridges' amplifier has a low pass of the second order, set far too low, and the encoders none.

    S. Butterworth, On the theory of filter amplifiers, Experimental Wireless 7, 1930: it runs over its end by four per
    cent. Only forces come late.
    """

    effect = "delay"
    needs = frozenset({"force"})

    def __init__(self, setting: Setting) -> None:
        super().__init__(setting)
        random = setting.random
        self._forces = sensors(self.rig, "N")
        same = random.random() < 0.6
        each = np.ones(len(self._forces)) if same else random.uniform(0.7, 1.4, len(self._forces))
        self._tau_s = random.uniform(0.45, 1.0) * each

    def seen(self, path: Path, deflection: Floats, values: Floats, strength: float) -> Floats:
        if strength <= 0:
            return values
        rate = 1 / (np.sqrt(2.0) * strength * self._tau_s)  # of the decay, and of the turning, too
        told = values[:, self._forces]
        before, off, speed = self.rig.at_rest[self._forces], 0.0 * rate, 0.0 * rate
        out = np.empty_like(told)
        for i, pause_s in enumerate(pauses(path).tolist()):
            off, before = off + before - told[i], told[i]
            kept = np.exp(-rate * pause_s)
            c, s = kept * np.cos(rate * pause_s), kept * np.sin(rate * pause_s)
            off, speed = (c + s) * off + s * speed / rate, (c - s) * speed - 2 * rate * s * off
            out[i] = off
        return added(values, self._forces, out)


class OldReadings(Law):
    """Old readings: each sensor's message has waited in its own buffer, and stands in the row of a later moment.

    K. W. Tindell, A. Burns, A. J. Wellings, Calculating controller area network (CAN) message response times, Control
    Engineering Practice 3, 1995. How old it is is a sensor's own; of some nothing has to wait.
    """

    effect = "delay"

    def __init__(self, setting: Setting) -> None:
        super().__init__(setting)
        random = setting.random
        self._which = sensors(self.rig)
        count = len(self._which)
        waits = random.random(count) < 0.7
        waits[random.integers(count)] = True
        self._old_s = np.where(waits, random.uniform(1.1, 2.2) * random.uniform(0.8, 1.2, count), 0.0)

    def seen(self, path: Path, deflection: Floats, values: Floats, strength: float) -> Floats:
        told = values[:, self._which]
        now = [
            np.interp(path.time_s - strength * old_s, path.time_s, told[:, k], left=float(rest))
            for k, (old_s, rest) in enumerate(zip(self._old_s, self.rig.at_rest[self._which], strict=True))
        ]
        return added(values, self._which, np.stack(now, axis=1) - told)
