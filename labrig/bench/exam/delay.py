"""Delay: what is measured belongs to a moment some seconds ago."""

from typing import ClassVar

import numpy as np

from labrig.arrays import Floats
from labrig.bench._nature import Law, Path, Setting
from labrig.bench.exam.tools import history, lagged


class ViscousValve(Law):
    """A throttled valve whose time constant depends on the pressure behind it, slower where it is low or high.

    E. Richer and Y. Hurmuzlu, Journal of Dynamic Systems, Measurement, and Control, 2000.
    """

    effect: ClassVar[str] = "delay"

    def __init__(self, setting: Setting) -> None:
        super().__init__(setting)
        random = setting.random
        self._tau_s = random.uniform(0.6, 1.3) * random.uniform(0.8, 1.25, len(setting.rig.chambers))
        self._more = random.choice([-1.0, 1.0]) * random.uniform(0.4, 0.8)

    def pressure(self, path: Path, kpa: Floats, strength: float) -> Floats:
        """The pressures that pass the throttle."""
        if strength == 0:
            return kpa
        past = history(path, kpa / self.rig.high_kpa)
        slope, base = self._more * strength * self._tau_s, (1 - self._more / 2) * strength * self._tau_s
        least = 0.15 * strength * self._tau_s
        state = past.load[0]
        states = np.empty_like(past.load)
        states[0] = state
        for n, step_s in enumerate(past.step_s, start=1):
            tau_s = np.maximum(base + slope * state, least)
            target = past.load[n]
            state = target + (state - target) * np.exp(-step_s / tau_s)
            states[n] = state
        return past.back(states) * self.rig.high_kpa


class TransportLine(Law):
    """A long thin line, as a chain of lumps with a lag each: a travelling time, after which the front arrives blurred.

    R. B. Schuder and R. C. Binder, Journal of Basic Engineering, 1959.
    """

    effect: ClassVar[str] = "delay"

    def __init__(self, setting: Setting) -> None:
        super().__init__(setting)
        share = setting.random.uniform(0.7, 1.3, int(setting.random.integers(5, 8)))
        self._lump_s = setting.random.uniform(1.1, 2.0) * share / share.sum()

    def pressure(self, path: Path, kpa: Floats, strength: float) -> Floats:
        """The pressures at the far end."""
        if strength == 0:
            return kpa
        past = history(path, kpa)
        here = past.load
        for lump_s in self._lump_s:
            here = lagged(past.step_s, here, strength * lump_s).real
        return past.back(here)


class MovingAverageSensor(Law):
    """A sensor that reports the mean of what it saw in a window of some seconds.

    S. W. Smith, The Scientist and Engineer's Guide to Digital Signal Processing, 1997 (moving average filters).
    """

    effect: ClassVar[str] = "delay"

    def __init__(self, setting: Setting) -> None:
        super().__init__(setting)
        self._window_s = setting.random.uniform(2.2, 3.8)

    def seen(self, path: Path, deflection: Floats, values: Floats, strength: float) -> Floats:
        """The mean of the values over the window, in the same session."""
        if strength == 0:
            return values
        after = np.empty_like(values)
        for number in np.unique(path.session):
            own = path.session == number
            after[own] = self._mean(path.time_s[own], values[own], strength * self._window_s)
        return after

    @staticmethod
    def _mean(time_s: Floats, values: Floats, window_s: float) -> Floats:
        """The running mean of values that run straight between moments, with the first ones held before."""
        time_s = np.concatenate([[time_s[0] - window_s], time_s])
        values = np.concatenate([values[:1], values])
        step_s = np.diff(time_s)[:, None]
        area = np.concatenate(
            [np.zeros((1, values.shape[1])), np.cumsum((values[1:] + values[:-1]) / 2 * step_s, axis=0)]
        )
        since = time_s[1:] - window_s
        left = np.clip(np.searchsorted(time_s, since, side="right") - 1, 0, len(time_s) - 2)
        into_s = (since - time_s[left])[:, None]
        slope = (values[left + 1] - values[left]) / np.maximum(step_s[left], 1e-9)
        before = area[left] + into_s * values[left] + into_s**2 / 2 * slope
        return (area[1:] - before) / window_s
