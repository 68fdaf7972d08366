"""Delay: just after a change the old shape is still there, in whole or in part; a little later it is gone.

The stronger the law, the longer it takes. What is slower than two seconds is still seen at a hold's first rows.
"""

import numpy as np

from labrig.arrays import Floats
from labrig.bench._nature import Law, Path, Setting
from labrig.bench.development._places import some
from labrig.bench.development._story import lagged


class FirstOrderLag(Law):
    """First-order lag: some chambers fill through a restriction, exponentially, each in a time of its own.

    P. Beater, Pneumatic Drives: System Design, Modelling and Control, Springer, 2007.
    """

    effect = "delay"

    def __init__(self, setting: Setting) -> None:
        super().__init__(setting)
        self._tau_s = some(setting.random, len(self.rig.chambers), 0.6, 2.5, setting.random.uniform(0.3, 1.0))

    def pressure(self, path: Path, kpa: Floats, strength: float) -> Floats:
        return lagged(path, kpa, strength * self._tau_s[None])[:, 0] if strength > 0 else kpa


class DeadTime(Law):
    """Dead time: for a while after a command nothing happens; a long line also smears out what arrives.

    E. Richer, Y. Hurmuzlu, A high performance pneumatic force actuator system, Part I, J. Dynamic Systems,
    Measurement, and Control 122, 2000.
    """

    effect = "delay"

    def __init__(self, setting: Setting) -> None:
        super().__init__(setting)
        self._late_s = setting.random.uniform(1.2, 2.2) * setting.random.uniform(
            0.9, 1.1, len(self.rig.chambers)
        )
        self._parts = 1 + setting.random.uniform(0.15, 0.4) * np.linspace(-1, 1, 9)

    def pressure(self, path: Path, kpa: Floats, strength: float) -> Floats:
        if strength <= 0:
            return kpa
        out = np.zeros_like(kpa)
        for c, late_s in enumerate(strength * self._late_s):
            for part in self._parts:
                then_s = path.time_s - part * late_s
                out[:, c] += np.interp(then_s, path.time_s, kpa[:, c], left=0.0) / len(self._parts)
        return out


class CriticallyDamped(Law):
    """Second-order lag: heavy walls in a thick medium follow without overshoot, and begin slowly.

    G. F. Franklin, J. D. Powell, A. Emami-Naeini, Feedback Control of Dynamic Systems, 6th ed., Pearson, 2010.
    """

    effect = "delay"

    def __init__(self, setting: Setting) -> None:
        super().__init__(setting)
        self._tau_s = setting.random.uniform(0.4, 1.2)

    def wall(self, path: Path, kpa: Floats, deflection: Floats, strength: float) -> Floats:
        if strength <= 0:
            return deflection
        tau_s = np.array([strength * self._tau_s])
        return lagged(path, lagged(path, deflection, tau_s)[:, 0], tau_s)[:, 0]


class DiffusiveLine(Law):
    """Transport line: pressure diffuses along thin tubes to their closed ends, in a series of ever faster modes.

    H. S. Carslaw, J. C. Jaeger, Conduction of Heat in Solids, 2nd ed., Clarendon Press, 1959.
    """

    effect = "delay"

    def __init__(self, setting: Setting) -> None:
        super().__init__(setting)
        odd = 2 * np.arange(5) + 1
        line_s = setting.random.uniform(1.5, 5.0) * setting.random.uniform(0.4, 1.6, len(self.rig.chambers))
        self._tau_s = 4 * line_s / (np.pi * odd[:, None]) ** 2
        share = (-1.0) ** np.arange(5) / odd
        self._share = share / share.sum()

    def pressure(self, path: Path, kpa: Floats, strength: float) -> Floats:
        if strength <= 0:
            return kpa
        return np.einsum("tnc,n->tc", lagged(path, kpa, strength * self._tau_s), self._share)


class SlowSensor(Law):
    """Sensor lag: a low-pass filter of the measuring system holds back what is seen.

    J. P. Bentley, Principles of Measurement Systems, 4th ed., Pearson, 2005.
    """

    effect = "delay"

    def __init__(self, setting: Setting) -> None:
        super().__init__(setting)
        self._tau_s = setting.random.uniform(0.5, 1.6)

    def seen(self, path: Path, deflection: Floats, values: Floats, strength: float) -> Floats:
        if strength <= 0:
            return values
        rest = self.rig.at_rest
        return rest + lagged(path, values - rest, np.array([strength * self._tau_s]))[:, 0]
