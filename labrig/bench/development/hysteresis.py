"""Hysteresis: the walls depend on where the load came from, however slowly it changes."""

import numpy as np

from labrig.arrays import Floats
from labrig.bench._nature import Law, Path, Setting
from labrig.bench.development._places import full, some
from labrig.bench.development._story import finely, plays


class PrandtlIshlinskii(Law):
    """Prandtl-Ishlinskii: a share of each wall's way goes through plays, many narrow ones and few wide ones.

    M. Brokate, J. Sprekels, Hysteresis and Phase Transitions, Springer, 1996.
    """

    effect = "hysteresis"

    def __init__(self, setting: Setting) -> None:
        super().__init__(setting)
        count = len(self.rig.chambers)
        fades_at = setting.random.uniform(0.08, 0.25)
        widths = np.linspace(0.03, 0.45, 7)
        self._half_width = widths[:, None] * setting.random.uniform(0.7, 1.3, count)
        self._weight = np.exp(-widths / fades_at) / np.exp(-widths / fades_at).sum()
        self._share = some(setting.random, count, 0.2, 0.5)

    def wall(self, path: Path, kpa: Floats, deflection: Floats, strength: float) -> Floats:
        behind = np.einsum("tnc,n->tc", plays(deflection, self._half_width), self._weight)
        return deflection + strength * self._share * (behind - deflection)


class Preisach(Law):
    """Preisach: each wall is moved by a crowd of relays, whose two thresholds are normally distributed.

    F. Preisach, Über die magnetische Nachwirkung, Zeitschrift für Physik 94, 1935.
    """

    effect = "hysteresis"

    def __init__(self, setting: Setting) -> None:
        super().__init__(setting)
        random = setting.random
        size = (400, len(self.rig.chambers))
        centre = np.abs(random.normal(random.uniform(0.35, 0.6), random.uniform(0.2, 0.35), size))
        half = np.minimum(np.abs(random.normal(0, random.uniform(0.06, 0.16), size)), centre)
        self._down, self._up = centre - half, centre + half
        self._share = some(random, len(self.rig.chambers), 0.25, 0.6)

    def wall(self, path: Path, kpa: Floats, deflection: Floats, strength: float) -> Floats:
        on = np.zeros(self._up.shape, dtype=bool)
        crowd, seen, now = np.empty_like(deflection), np.full(deflection.shape[1], np.inf), None
        for t, drive in enumerate(deflection):
            if now is None or np.abs(drive - seen).max() > 2e-4:
                on = (on | (drive >= self._up)) & (drive > self._down)
                seen, now = drive, np.count_nonzero(on, axis=0) / len(on)
            crowd[t] = now
        return deflection + strength * self._share * (crowd - deflection)


class BoucWen(Law):
    """Bouc-Wen: a restoring pressure that follows the load smoothly up to a limit, and turns with it.

    Y.-K. Wen, Method for random vibration of hysteretic systems, J. Engineering Mechanics Division ASCE 102, 1976.
    """

    effect = "hysteresis"

    def __init__(self, setting: Setting) -> None:
        super().__init__(setting)
        count = len(self.rig.chambers)
        self._width = setting.random.uniform(0.12, 0.35, count)
        self._sharp = float(setting.random.choice([1.0, 1.5, 2.0]))
        self._turn = setting.random.uniform(0.5, 0.85)
        self._held = some(setting.random, count, 0.04, 0.1)

    def pressure(self, path: Path, kpa: Floats, strength: float) -> Floats:
        moves, _, keep = finely(path, full(self.rig, kpa) / self._width, 0.3)
        state = np.zeros(kpa.shape[1])
        out = np.empty_like(moves)
        for t, move in enumerate(moves):
            bound = np.abs(state) ** self._sharp * (1 - self._turn + self._turn * np.sign(move * state))
            state = np.clip(state + move * (1 - bound), -1.0, 1.0)
            out[t] = state
        return kpa - strength * self._held * self.rig.high_kpa * out[keep]


class MaxwellSlip(Law):
    """Maxwell slip: a few springs, each dragging a block that slips at its own force, pull against the load.

    M. Goldfarb, N. Celanovic, A lumped parameter electromechanical model for describing the nonlinear behavior of
    piezoelectric actuators, J. Dynamic Systems, Measurement, and Control 119, 1997.
    """

    effect = "hysteresis"

    def __init__(self, setting: Setting) -> None:
        super().__init__(setting)
        count = len(self.rig.chambers)
        blocks = int(setting.random.integers(2, 5))
        self._slips_at = np.sort(setting.random.uniform(0.04, 0.5, (blocks, count)), axis=0)
        stiff = setting.random.uniform(0.5, 1.5, (blocks, count)) / blocks
        self._stiff = stiff * some(setting.random, count, 0.2, 0.45)

    def pressure(self, path: Path, kpa: Floats, strength: float) -> Floats:
        drive = full(self.rig, kpa)
        pulls = drive[:, None] - plays(drive, self._slips_at)
        return kpa - strength * self.rig.high_kpa * np.sum(self._stiff * pulls, axis=1)
