"""Delays of the tenth portion: two unlike lags behind a dead time, and air that is warm from being compressed."""

import numpy as np

from labrig.arrays import Floats
from labrig.bench._nature import Law, Path, Setting
from labrig.bench.development._places import full
from labrig.bench.development._story import lagged


class DeadTimeAndTwoLags(Law):
    """Two unlike lags behind a dead time: a hose fills, and through its end a chamber, each in a time of its own.

    D. E. Seborg, T. F. Edgar, D. A. Mellichamp, Process Dynamics and Control, Wiley, 1989: the step of a second-order
    process is one less two exponentials, weighted by their times, so that it begins flat and ends as the slower one.
    """

    effect = "delay"

    def __init__(self, setting: Setting) -> None:
        super().__init__(setting)
        random, count = setting.random, len(self.rig.chambers)
        self._chamber_s = random.uniform(0.35, 0.9) * random.uniform(0.75, 1.25, count)
        self._hose = random.uniform(0.2, 0.6)  # its time, as a share of the chamber's
        self._late = random.uniform(0.1, 0.4)

    def pressure(self, path: Path, kpa: Floats, strength: float) -> Floats:
        if strength <= 0:
            return kpa
        slow = strength * self._chamber_s
        fast, late = self._hose * slow, self._late * slow
        shifted = np.column_stack(
            [np.interp(path.time_s - late[c], path.time_s, kpa[:, c], left=0.0) for c in range(kpa.shape[1])]
        )
        by_slow, by_fast = lagged(path, shifted, slow[None])[:, 0], lagged(path, shifted, fast[None])[:, 0]
        return (by_slow - self._hose * by_fast) / (1 - self._hose)


class WarmAir(Law):
    """Warm air: what is filled fast is hot and takes more room, what is emptied fast is cold; the walls even it out.

    T. Kagawa, Heat transfer effects on the frequency response of a pneumatic nozzle flapper, Trans. ASME, J. Dynamic
    Systems, Measurement and Control 107, 1985, on the thermal time of a volume. The body goes beyond its end and comes
    back exponentially within seconds, by a share of the step, which is the larger, the fuller the chamber was before.
    """

    effect = "delay"

    def __init__(self, setting: Setting) -> None:
        super().__init__(setting)
        random, count = setting.random, len(self.rig.chambers)
        self._evens_out_s = random.uniform(1.2, 4.0) * random.uniform(0.8, 1.25, count)
        self._share = random.uniform(0.15, 0.35) * random.uniform(0.85, 1.15, count)
        self._fuller = random.uniform(0.0, 0.6)

    def wall(self, path: Path, kpa: Floats, deflection: Floats, strength: float) -> Floats:
        hot = deflection - lagged(path, deflection, self._evens_out_s[None])[:, 0]
        weight = 1 + self._fuller * np.clip(full(self.rig, kpa), -1.0, 1.5)
        return deflection + strength * self._share * weight * hot
