"""Delay of the fourth portion: controllers that act at ticks, smooth ramps, lines in which gas is squeezed.

The stronger the law, the longer it takes.
"""

from collections.abc import Callable

import numpy as np

from labrig.arrays import Floats
from labrig.bench._nature import Law, Path, Setting
from labrig.bench.development._places import some
from labrig.bench.development._story import pauses


def _late(path: Path, kpa: Floats, gone: Callable[[int, Floats], Floats]) -> Floats:
    """Pressures (T, C) of which each actuation has done only the share `gone(its first moment, time since (N, 1))`."""
    out, before = np.empty_like(kpa), np.zeros(kpa.shape[1])
    begins = np.flatnonzero(np.diff(path.event, prepend=-1)).tolist()
    for first, end in zip(begins, [*begins[1:], len(kpa)], strict=True):
        out[first:end] = before + gone(first, path.hold_s[first:end, None]) * (kpa[first:end] - before)
        before = out[end - 1]
    return out


class TicksOfClock(Law):
    """Sampled control: the controller acts at the ticks of its clock only, and at each takes a share of what is left.

    K. J. Åström, B. Wittenmark, Computer-Controlled Systems: Theory and Design, 3rd ed., Prentice Hall, 1997.
    """

    effect = "delay"

    def __init__(self, setting: Setting) -> None:
        super().__init__(setting)
        self._tick_s = setting.random.uniform(1.2, 2.5)
        self._first_s = setting.random.uniform(0.0, self._tick_s)
        self._stays = setting.random.uniform(0.15, 0.4, len(self.rig.chambers))

    def pressure(self, path: Path, kpa: Floats, strength: float) -> Floats:
        if strength <= 0:
            return kpa

        def gone(first: int, hold_s: Floats) -> Floats:
            waits_s = strength * float((self._first_s - path.time_s[first]) % self._tick_s)
            ticks = np.floor(np.maximum((hold_s - waits_s) / (strength * self._tick_s) + 1, 0.0))
            return 1 - self._stays ** np.minimum(ticks, 99.0)

        return _late(path, kpa, gone)


class SmoothRamp(Law):
    """Smooth ramp: each change, small or large, is spread over the same time along the curve of least jerk.

    T. Flash, N. Hogan, The coordination of arm movements: an experimentally confirmed mathematical model, J.
    Neuroscience 5, 1985.
    """

    effect = "delay"

    def __init__(self, setting: Setting) -> None:
        super().__init__(setting)
        random, count = setting.random, len(self.rig.chambers)
        self._whole_s = random.uniform(2.5, 6.0) * some(random, count, 0.85, 1.15, random.uniform(0.6, 1.0))

    def pressure(self, path: Path, kpa: Floats, strength: float) -> Floats:
        if strength <= 0:
            return kpa
        takes_s = np.maximum(strength * self._whole_s, 1e-6)

        def gone(first: int, hold_s: Floats) -> Floats:
            x = np.minimum(hold_s / takes_s, 1.0)
            return np.where(self._whole_s > 0, x**3 * (10 - 15 * x + 6 * x**2), 1.0)

        return _late(path, kpa, gone)


class SqueezedGas(Law):
    """Laminar line of gas: the flow goes with the difference of the squared pressures; chambers fill faster than empty.

    P. Beater, Pneumatic Drives: System Design, Modelling and Control, Springer, 2007.
    """

    effect = "delay"

    def __init__(self, setting: Setting) -> None:
        super().__init__(setting)
        random, count = setting.random, len(self.rig.chambers)
        self._tau_s = some(random, count, 0.8, 1.7, random.uniform(0.6, 1.0))  # near the upper limit

    def pressure(self, path: Path, kpa: Floats, strength: float) -> Floats:
        if strength <= 0:
            return kpa
        tau_s, air = np.maximum(strength * self._tau_s, 1e-6), 101.3
        asked = np.maximum(kpa + air, 5.0)
        turns = np.tanh(0.5 * asked / (self.rig.high_kpa + air) * pauses(path)[:, None] / tau_s)
        state, out = np.full(kpa.shape[1], air), np.empty_like(kpa)
        for t, now in enumerate(asked):
            state = now * (state + now * turns[t]) / (now + state * turns[t])
            out[t] = state
        return np.where(self._tau_s > 0, out - air, kpa)
