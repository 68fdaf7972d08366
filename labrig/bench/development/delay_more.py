"""Further delay: overshoot, a long line before a volume, a limited rate, slow venting, a moving average."""

import numpy as np

from labrig.arrays import Floats
from labrig.bench._nature import Law, Path, Setting
from labrig.bench.development._places import some
from labrig.bench.development._story import lagged, pauses


class Overshoot(Law):
    """Underdamped second-order lag: heavy walls swing past their end and back a few times before they rest.

    K. Ogata, Modern Control Engineering, 5th ed., Prentice Hall, 2010.
    """

    effect = "delay"

    def __init__(self, setting: Setting) -> None:
        super().__init__(setting)
        damped = setting.random.uniform(0.3, 0.6)
        self._rests_s = setting.random.uniform(0.6, 1.5)  # time constant of the swing's envelope
        self._turns = np.sqrt(1 - damped**2) / damped  # angle, in the time in which it decays to 1 / e

    def wall(self, path: Path, kpa: Floats, deflection: Floats, strength: float) -> Floats:
        if strength <= 0:
            return deflection
        pole = (-1 + 1j * self._turns) / (strength * self._rests_s)
        stays = np.exp(pole * pauses(path))
        share = 1 - 1j / self._turns  # of a step, so that the answer starts with no speed
        state, out = np.zeros(deflection.shape[1], dtype=complex), np.empty_like(deflection)
        for t, now in enumerate(deflection):
            step = now - (deflection[t - 1] if t else 0.0)
            state = (state + step * share) * stays[t]
            out[t] = now - state.real
        return out


class LineAndVolume(Law):
    """Dead time and lag: through long lines a change arrives late, and then fills the chamber exponentially.

    J. G. Ziegler, N. B. Nichols, Optimum settings for automatic controllers, Trans. ASME 64, 1942.
    """

    effect = "delay"

    def __init__(self, setting: Setting) -> None:
        super().__init__(setting)
        random, count = setting.random, len(self.rig.chambers)
        long = some(random, count, 0.5, 1.5, random.uniform(0.4, 1.0))
        self._late_s = random.uniform(0.3, 1.2) * long
        self._tau_s = random.uniform(0.3, 1.2) * long

    def pressure(self, path: Path, kpa: Floats, strength: float) -> Floats:
        if strength <= 0:
            return kpa
        out = kpa.copy()
        for c in np.flatnonzero(self._late_s):
            then_s = path.time_s - strength * self._late_s[c]
            out[:, c] = np.interp(then_s, path.time_s, kpa[:, c], left=0.0)
        return lagged(path, out, strength * self._tau_s[None])[:, 0]


class LimitedRate(Law):
    """Limited rate: a small valve fills and vents at a constant rate, so that only large steps arrive late.

    K. J. Åström, R. M. Murray, Feedback Systems, Princeton University Press, 2008.
    """

    effect = "delay"

    def __init__(self, setting: Setting) -> None:
        super().__init__(setting)
        count = len(self.rig.chambers)
        self._whole_s = some(setting.random, count, 2.5, 7.0, setting.random.uniform(0.4, 1.0))

    def pressure(self, path: Path, kpa: Floats, strength: float) -> Floats:
        if strength <= 0:
            return kpa
        rate = self.rig.high_kpa / np.maximum(strength * self._whole_s, 1e-6)
        most = rate * pauses(path)[:, None]
        state, out = np.zeros(kpa.shape[1]), np.empty_like(kpa)
        for t in range(len(out)):
            state = state + np.clip(kpa[t] - state, -most[t], most[t])
            out[t] = state
        return np.where(self._whole_s > 0, out, kpa)


class SlowVenting(Law):
    """Slow venting: air goes in fast from the supply, but out only through a small exhaust (or the other way round).

    B. W. Andersen, The Analysis and Design of Pneumatic Systems, Wiley, 1967.
    """

    effect = "delay"

    def __init__(self, setting: Setting) -> None:
        super().__init__(setting)
        count = len(self.rig.chambers)
        slow_s, fast_s = some(setting.random, count, 0.8, 3.0, 0.8), setting.random.uniform(0.0, 0.3, count)
        vents = setting.random.random() < 0.75
        self._in_s, self._out_s = (fast_s, slow_s) if vents else (slow_s, fast_s)

    def pressure(self, path: Path, kpa: Floats, strength: float) -> Floats:
        if strength <= 0:
            return kpa
        since = -pauses(path)[:, None]
        fills = -np.expm1(since / np.maximum(strength * self._in_s, 1e-9))
        vents = -np.expm1(since / np.maximum(strength * self._out_s, 1e-9))
        state, out = np.zeros(kpa.shape[1]), np.empty_like(kpa)
        for t in range(len(out)):
            ahead = kpa[t] - state
            state = state + np.where(ahead > 0, fills[t], vents[t]) * ahead
            out[t] = state
        return out


class MovingAverage(Law):
    """Moving average: what is seen is the mean of a last little while, so that a change is spread over it.

    A. V. Oppenheim, R. W. Schafer, Discrete-Time Signal Processing, 3rd ed., Pearson, 2010.
    """

    effect = "delay"

    def __init__(self, setting: Setting) -> None:
        super().__init__(setting)
        self._window_s = setting.random.uniform(2.0, 3.2)

    def seen(self, path: Path, deflection: Floats, values: Floats, strength: float) -> Floats:
        if strength <= 0:
            return values
        window_s, time_s = strength * self._window_s, path.time_s
        rest = self.rig.at_rest
        middle = 0.5 * (values[1:] + values[:-1]) - rest
        whole = np.cumsum(middle * np.diff(time_s)[:, None], axis=0)
        whole = np.concatenate([np.zeros((1, len(rest))), whole])
        then_s = np.clip(time_s - window_s, time_s[0], None)
        after = np.clip(np.searchsorted(time_s, then_s, side="right"), 1, len(time_s) - 1)
        early = time_s[after - 1]
        share = ((then_s - early) / (time_s[after] - early))[:, None]
        left, right = values[after - 1] - rest, values[after] - rest
        then = whole[after - 1] + (then_s - early)[:, None] * (left + 0.5 * share * (right - left))
        return rest + (whole - then) / window_s
