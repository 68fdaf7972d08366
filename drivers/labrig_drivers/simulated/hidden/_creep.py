"""Creep: the membrane goes on yielding after every change of load, and recovers on release."""

import numpy as np

from labrig.arrays import Floats
from labrig_drivers.simulated.hidden._base import Hidden

_LAGS_S = np.geomspace(0.4, 4e4, 16)


def _chain(law) -> Floats:
    """Weights (16,) of a spectrum of lags that follows `law(t)` from 0.3 s to 1e4 s."""
    from scipy.optimize import nnls  # here, since few rigs creep and every simulated one would wait for it

    t = np.geomspace(0.3, 1e4, 200)
    wanted = law(t)
    weight, _ = nnls((1.0 - np.exp(-t[:, None] / _LAGS_S)) / wanted[:, None], np.ones(t.size))
    return weight


class Creep(Hidden):
    """Linear viscoelasticity with the memory of all past loads (Boltzmann superposition).

    The creep law is a power of time (Findley 1944), or a stretched exponential (Kohlrausch), by chance; it is
    carried as a spectrum of lags. `strength`: creep strain at 10 s as a part of the elastic one.
    """

    name = "creep"
    natural = 0.03

    def prepare(self) -> None:
        random = self.setting.random
        if random.random() < 0.5:
            power = random.uniform(0.12, 0.3)
            self.weight = _chain(lambda t: (t / 10.0) ** power)
        else:
            lag, beta = random.uniform(8.0, 60.0), random.uniform(0.4, 0.7)
            self.weight = _chain(lambda t: 1.0 - np.exp(-((t / lag) ** beta)))
        self.share = self.setting.varied(0.2)

    def deflect(self, time_s: Floats, step_s: Floats, deflection_mm: Floats) -> Floats:
        """Elastic deflection plus what each lag of the spectrum has followed of it."""
        del time_s
        lagging = self.memory.get("lagging", np.zeros((_LAGS_S.size, self.setting.chambers)))
        keep = np.exp(-step_s[:, None] / _LAGS_S)
        crept = np.empty_like(deflection_mm)
        for k in range(step_s.size):
            lagging = deflection_mm[k] + (lagging - deflection_mm[k]) * keep[k][:, None]
            crept[k] = self.weight @ lagging
        self.memory["lagging"] = lagging
        return deflection_mm + self.strength * self.share * crept
