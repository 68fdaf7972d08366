"""Delay of the third portion: tanks in series, orifices, valves that take turns, a part that comes at once.

The stronger the law, the longer it takes.
"""

import numpy as np

from labrig.arrays import Floats
from labrig.bench._nature import Law, Path, Setting
from labrig.bench.development._places import some
from labrig.bench.development._story import lagged, pauses


class TanksInSeries(Law):
    """Tanks in series: three to five equal volumes fill one after another, so that a change comes late and smeared.

    O. Levenspiel, Chemical Reaction Engineering, 2nd ed., Wiley, 1972.
    """

    effect = "delay"

    def __init__(self, setting: Setting) -> None:
        super().__init__(setting)
        random, count = setting.random, len(self.rig.chambers)
        self._tanks = int(random.integers(3, 6))
        self._whole_s = some(random, count, 1.2, 3.0, random.uniform(0.5, 1.0))

    def pressure(self, path: Path, kpa: Floats, strength: float) -> Floats:
        if strength <= 0:
            return kpa
        out = kpa
        for _ in range(self._tanks):
            out = lagged(path, out, strength * self._whole_s[None] / self._tanks)[:, 0]
        return out


class OrificeFilling(Law):
    """Filling through an orifice: the flow goes with the root of the difference, which is gone after a finite time.

    J. F. Blackburn, G. Reethof, J. L. Shearer, Fluid Power Control, MIT Press, 1960.
    """

    effect = "delay"

    def __init__(self, setting: Setting) -> None:
        super().__init__(setting)
        random, count = setting.random, len(self.rig.chambers)
        self._whole_s = some(random, count, 3.0, 8.0, random.uniform(0.5, 1.0))

    def pressure(self, path: Path, kpa: Floats, strength: float) -> Floats:
        if strength <= 0:
            return kpa
        gains = (
            pauses(path)[:, None] / np.maximum(strength * self._whole_s, 1e-6) * np.sqrt(self.rig.high_kpa)
        )
        state, out = np.zeros(kpa.shape[1]), np.empty_like(kpa)
        for t, now in enumerate(kpa):
            left = now - state
            state = now - np.sign(left) * np.maximum(np.sqrt(np.abs(left)) - gains[t], 0.0) ** 2
            out[t] = state
        return np.where(self._whole_s > 0, out, kpa)


class TakingTurns(Law):
    """Multiplexed valves: one valve serves the chambers in turn, so that each moves later than the one before it.

    N. W. Bartlett, K. P. Becker, R. J. Wood, A fluidic demultiplexer for controlling large arrays of soft actuators,
    Soft Matter 16, 2020.
    """

    effect = "delay"
    needs = frozenset({"several"})

    def __init__(self, setting: Setting) -> None:
        super().__init__(setting)
        random, count = setting.random, len(self.rig.chambers)
        self._turn = random.permutation(count) + 1.0
        self._each_s = random.uniform(2.5, 4.5) / count
        self._opens = np.linspace(-0.5, 0.5, 7)  # moments of a turn over which a chamber fills

    def pressure(self, path: Path, kpa: Floats, strength: float) -> Floats:
        if strength <= 0:
            return kpa
        out = np.zeros_like(kpa)
        for c, turn in enumerate(self._turn):
            for part in self._opens:
                then_s = path.time_s - strength * self._each_s * (turn + part)
                out[:, c] += np.interp(then_s, path.time_s, kpa[:, c], left=0.0) / len(self._opens)
        return out


class LeadAndLag(Law):
    """Lead and lag: a part of each change is there at once, and the rest follows exponentially.

    R. C. Dorf, R. H. Bishop, Modern Control Systems, 12th ed., Pearson, 2011.
    """

    effect = "delay"

    def __init__(self, setting: Setting) -> None:
        super().__init__(setting)
        random, count = setting.random, len(self.rig.chambers)
        self._late = random.uniform(0.4, 0.8) * random.uniform(0.8, 1.2, count)
        self._tau_s = random.uniform(0.8, 2.0)

    def wall(self, path: Path, kpa: Floats, deflection: Floats, strength: float) -> Floats:
        if strength <= 0:
            return deflection
        behind = lagged(path, deflection, np.array([strength * self._tau_s]))[:, 0]
        return deflection + self._late * (behind - deflection)
