"""Delays of the ninth portion: dead time and lag, a slow valve, a heavy body, a sensor, a narrow channel."""

import numpy as np

from labrig.arrays import Floats
from labrig.bench._nature import Law, Path, Setting
from labrig.bench.development._places import long_axis
from labrig.bench.development._story import lagged, pauses


class DeadTimeAndLag(Law):
    """A dead time and a lag of first order: what a tube to each chamber does, the longer the tube the more.

    J. G. Ziegler, N. B. Nichols, Optimum settings for automatic controllers, Transactions of the ASME 64,
    1942: exp(-theta s) / (1 + tau s).
    """

    effect = "delay"

    def __init__(self, setting: Setting) -> None:
        super().__init__(setting)
        random, count = setting.random, len(self.rig.chambers)
        tube = random.uniform(0.6, 1.4, count)
        self._dead_s = random.uniform(0.1, 0.5) * tube
        self._tau_s = random.uniform(0.5, 1.5) * tube

    def pressure(self, path: Path, kpa: Floats, strength: float) -> Floats:
        late = np.empty_like(kpa)
        for c, dead_s in enumerate(strength * self._dead_s):
            late[:, c] = np.interp(path.time_s - dead_s, path.time_s, kpa[:, c], left=0.0)
        return lagged(path, late, strength * self._tau_s[None])[:, 0]


class SlowValve(Law):
    """A slow valve: air comes at most at the rate of choked flow, so that a long way takes longer.

    J. F. Blackburn, G. Reethof, J. L. Shearer, Fluid Power Control, MIT Press, 1960. Venting is slower than
    filling.
    """

    effect = "delay"

    def __init__(self, setting: Setting) -> None:
        super().__init__(setting)
        random, count = setting.random, len(self.rig.chambers)
        self._fills_s = random.uniform(1.0, 3.0) * random.uniform(0.8, 1.2, count)  # for the full way
        self._vents_s = self._fills_s * random.uniform(1.0, 1.8)

    def pressure(self, path: Path, kpa: Floats, strength: float) -> Floats:
        if strength <= 0:
            return kpa
        up = pauses(path)[:, None] * self.rig.high_kpa / (strength * self._fills_s)
        down = pauses(path)[:, None] * self.rig.high_kpa / (strength * self._vents_s)
        now = kpa[0].copy()
        out = np.empty_like(kpa)
        for i in range(len(kpa)):
            now = now + np.clip(kpa[i] - now, -down[i], up[i])
            out[i] = now
        return out


class HeavyBody(Law):
    """A heavy body: mass, spring and damper, through which the whole shape follows.

    K. Ogata, Modern Control Engineering, Prentice-Hall, 1970: w^2 / (s^2 + 2 zeta w s + w^2), damped well
    enough that it hardly swings.
    """

    effect = "delay"

    def __init__(self, setting: Setting) -> None:
        super().__init__(setting)
        random = setting.random
        self._zeta = random.choice([random.uniform(0.65, 0.95), random.uniform(1.05, 1.8)])
        self._period_s = random.uniform(0.4, 1.2)  # 1 / w

    def seen(self, path: Path, deflection: Floats, values: Floats, strength: float) -> Floats:
        if strength <= 0:
            return values
        root = np.sqrt(complex(self._zeta**2 - 1))
        poles = np.array([-self._zeta + root, -self._zeta - root])
        share = (poles[::-1] / (poles[::-1] - poles))[:, None]
        aim = values - self.rig.at_rest
        pause = pauses(path) / (strength * self._period_s)
        goes = -np.expm1(pause[:, None] * poles)[..., None]
        state = np.zeros((2, values.shape[1]), dtype=complex)
        out = np.empty_like(values)
        for i in range(len(aim)):
            state = state + goes[i] * (aim[i] - state)
            out[i] = np.sum(share * state, axis=0).real
        return self.rig.at_rest + out


class AveragingSensor(Law):
    """A sensor that averages: each reading is the mean over a window that ended some time ago.

    S. W. Smith, The Scientist and Engineer's Guide to Digital Signal Processing, California Technical
    Publishing, 1997, on the moving average; the time for transfer and computing comes on top.
    """

    effect = "delay"

    def __init__(self, setting: Setting) -> None:
        super().__init__(setting)
        random = setting.random
        self._window_s = random.uniform(0.8, 3.0)
        self._latency_s = random.uniform(0.1, 0.6)

    def seen(self, path: Path, deflection: Floats, values: Floats, strength: float) -> Floats:
        if strength <= 0:
            return values
        aim = values - self.rig.at_rest
        middle = np.concatenate([aim[:1], (aim[1:] + aim[:-1]) / 2])
        total = np.cumsum(middle * pauses(path)[:, None], axis=0)
        window = max(strength * self._window_s, 1e-3)
        end = path.time_s - strength * self._latency_s
        out = np.empty_like(values)
        for k in range(values.shape[1]):
            until = np.interp(end, path.time_s, total[:, k])
            out[:, k] = (until - np.interp(end - window, path.time_s, total[:, k])) / window
        return self.rig.at_rest + out


class NarrowChannel(Law):
    """A narrow channel: pressure diffuses along it, so that places far from the inlet follow later.

    H. S. Carslaw, J. C. Jaeger, Conduction of Heat in Solids, Oxford, 1959, on a slab that is heated at one
    end: a sum over odd n of 4/(n pi) sin(n pi x/2) exp(-n^2 t/tau) of the old is left at the place x.
    """

    effect = "delay"

    def __init__(self, setting: Setting) -> None:
        super().__init__(setting)
        random, rig = setting.random, self.rig
        place = random.uniform(0.0, 1.0, len(rig.observables))
        if rig.marker_names:
            along = long_axis(rig)[1]
            if random.random() < 0.5:  # the inlet is at the other end
                along = 1 - along
            of = np.array([observable.marker for observable in rig.observables])
            place = np.where(of >= 0, along[of], place)
        odd = np.array([1.0, 3.0, 5.0, 7.0])
        self._left = 4 / (np.pi * odd[:, None]) * np.sin(np.pi / 2 * odd[:, None] * (0.1 + 0.9 * place))
        self._tau_s = random.uniform(0.8, 2.5) / odd**2

    def seen(self, path: Path, deflection: Floats, values: Floats, strength: float) -> Floats:
        aim = values - self.rig.at_rest
        missing = aim[:, None] - lagged(path, aim, strength * self._tau_s)
        return values - np.einsum("tnk,nk->tk", missing, self._left)
