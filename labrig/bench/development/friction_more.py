"""Further friction: sticking and jumping, elastic before it slides, several blocks, a wrapped tendon, a bearing."""

import numpy as np

from labrig.arrays import Floats
from labrig.bench._nature import Law, Path, Setting
from labrig.bench.development._places import full, pattern, reached, some, span
from labrig.bench.development._story import finely, pauses, plays, steps
from labrig.bench.development.friction import sliding


class StickAndBreak(Law):
    """Karnopp: a wall sticks until the load is ahead by its breakaway force, and then slides with less behind it.

    D. Karnopp, Computer simulation of stick-slip friction in mechanical dynamic systems, J. Dynamic Systems,
    Measurement, and Control 107, 1985.
    """

    effect = "friction"

    def __init__(self, setting: Setting) -> None:
        super().__init__(setting)
        random, count = setting.random, len(self.rig.chambers)
        self._sticks = some(random, count, 0.03, 0.08, 0.85)
        self._slides = random.uniform(0.4, 0.8)  # as a share of the breakaway force

    def pressure(self, path: Path, kpa: Floats, strength: float) -> Floats:
        drive, sticks = full(self.rig, kpa), strength * self._sticks
        state, out = np.zeros(drive.shape[1]), np.empty_like(drive)
        for t, now in enumerate(drive):
            ahead = now - state
            free = np.abs(ahead) > sticks
            state = np.where(free, now - self._slides * sticks * np.sign(ahead), state)
            out[t] = state
        return out * self.rig.high_kpa


class ElastoPlastic(Law):
    """Elasto-plastic friction: bristles bend and come back without loss, up to a breakaway bend, and then slide.

    P. Dupont, V. Hayward, B. Armstrong, F. Altpeter, Single state elastoplastic friction models, IEEE Trans. Automatic
    Control 47, 2002.
    """

    effect = "friction"

    def __init__(self, setting: Setting) -> None:
        super().__init__(setting)
        random, count = setting.random, len(self.rig.chambers)
        self._give = random.uniform(0.01, 0.05, count)
        self._elastic = random.uniform(0.4, 0.8)
        self._held = some(random, count, 0.02, 0.06)

    def wall(self, path: Path, kpa: Floats, deflection: Floats, strength: float) -> Floats:
        bends = np.cumsum(np.clip(steps(deflection) / self._give, -4.0, 4.0), axis=0)
        moves, _, keep = finely(path, bends, 0.2)
        state, out = np.zeros(deflection.shape[1]), np.empty_like(moves)
        for t, move in enumerate(moves):
            bend = state * np.sign(move)  # positive where it is bent further
            plastic = np.clip((bend - self._elastic) / (1 - self._elastic), 0.0, 1.0)
            slips = 0.5 - 0.5 * np.cos(np.pi * plastic)
            state = np.clip(state + move * (1 - slips * np.clip(bend, 0.0, 1.0)), -1.0, 1.0)
            out[t] = state
        return deflection - strength * self._held * out[keep]


class GeneralisedMaxwellSlip(Law):
    """Generalised Maxwell slip: a few blocks that give way at small motions one by one, and carry less when fast.

    F. Al-Bender, V. Lampaert, J. Swevers, The generalized Maxwell-slip model: a novel model for friction simulation and
    compensation, IEEE Trans. Automatic Control 50, 2005.
    """

    effect = "friction"

    def __init__(self, setting: Setting) -> None:
        super().__init__(setting)
        random, count = setting.random, len(self.rig.chambers)
        self._give = np.geomspace(0.004, 0.03, 4)[:, None] * random.uniform(0.7, 1.4, count)
        self._carries = random.dirichlet(np.full(4, 3.0))
        self._less = random.uniform(0.1, 0.35)
        self._fast_per_s = random.uniform(0.05, 0.3)
        self._held = some(random, count, 0.02, 0.06)

    def wall(self, path: Path, kpa: Floats, deflection: Floats, strength: float) -> Floats:
        bent = (deflection[:, None] - plays(deflection, self._give)) / self._give
        speed = np.abs(steps(deflection)) / np.maximum(pauses(path), 1e-3)[:, None]
        slow = 1 - self._less * -np.expm1(-speed / self._fast_per_s)
        return deflection - strength * self._held * slow * np.einsum("tnc,n->tc", bent, self._carries)


class Capstan(Law):
    """Capstan: a tendon or sleeve wraps further around as it is pulled, and passes on less by its wrapped angle.

    L. Euler, Remarques sur l'effet du frottement dans l'équilibre, Mémoires de l'Académie des Sciences de Berlin 18,
    1769.
    """

    effect = "friction"

    def __init__(self, setting: Setting) -> None:
        super().__init__(setting)
        random, count = setting.random, len(self.rig.chambers)
        self._give = random.uniform(0.004, 0.015, count)
        self._rubs = some(random, count, 0.03, 0.12, 0.85)
        self._wraps = random.uniform(0.0, 1.5)

    def pressure(self, path: Path, kpa: Floats, strength: float) -> Floats:
        drive = full(self.rig, kpa)
        angle = self._rubs * (1 + self._wraps * np.clip(drive, 0.0, 1.5))
        return kpa * np.exp(-strength * angle * sliding(drive, self._give))


class BearingFriction(Law):
    """Dry bearing: the body as a whole is held back along its main way, whichever chamber moves it.

    B. Armstrong-Hélouvry, P. Dupont, C. Canudas de Wit, A survey of models, analysis tools and compensation methods for
    the control of machines with friction, Automatica 30, 1994.
    """

    effect = "friction"

    def __init__(self, setting: Setting) -> None:
        super().__init__(setting)
        self._way = pattern(self.rig)
        self._full = span(self.rig) * np.sqrt(len(self.rig.observables))
        self._give = setting.random.uniform(0.005, 0.02, 1)
        top = float(reached(self.rig, setting.path).max())
        self._held = setting.random.uniform(0.02, 0.07) * min(top, 1.0)

    def seen(self, path: Path, deflection: Floats, values: Floats, strength: float) -> Floats:
        along = (values - self.rig.at_rest) @ self._way / self._full
        way = sliding(along[:, None], self._give)
        return values - strength * self._held * self._full * way * self._way
