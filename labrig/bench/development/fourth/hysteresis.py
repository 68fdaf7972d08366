"""Hysteresis of the fourth portion: wires that change phase, pinched loops, a play of all chambers as one vector."""

import numpy as np

from labrig.arrays import Floats
from labrig.bench._nature import Law, Path, Setting
from labrig.bench.development._places import full, some
from labrig.bench.development._story import finely


class SuperelasticWires(Law):
    """Liang-Rogers: wires in the wall turn to martensite along a cosine of the load, and back along a lower one.

    C. Liang, C. A. Rogers, One-dimensional thermomechanical constitutive relations for shape memory materials, J.
    Intelligent Material Systems and Structures 1, 1990. Loops are wide at medium loads, and none is at low ones.
    """

    effect = "hysteresis"

    def __init__(self, setting: Setting) -> None:
        super().__init__(setting)
        random, count = setting.random, len(self.rig.chambers)
        self._back = np.array([random.uniform(0.05, 0.15), random.uniform(0.35, 0.5)])
        self._forth = self._back + random.uniform(0.2, 0.4) + np.array([0.0, random.uniform(0.0, 0.2)])
        self._yields = some(random, count, 0.15, 0.4, 0.9)

    def wall(self, path: Path, kpa: Floats, deflection: Floats, strength: float) -> Floats:
        load = np.abs(deflection)
        forth, back = _turned(load, self._forth), _turned(load, self._back)
        state, now, turned = np.zeros(load.shape[1]), np.zeros(load.shape[1]), np.empty_like(load)
        before = (_turned(now[None], self._forth)[0], _turned(now[None], self._back)[0])
        for t in range(len(load)):
            more = 1 - (1 - state) * (1 - forth[t]) / np.maximum(1 - before[0], 1e-9)
            less = state * back[t] / np.maximum(before[1], 1e-9)
            state = np.clip(
                np.where(load[t] > now, np.maximum(more, state), np.minimum(less, state)), 0.0, 1.0
            )
            now, before = load[t], (forth[t], back[t])
            turned[t] = state
        change = turned - 0.5 * (forth + back)
        return deflection + strength * self._yields * np.sign(deflection) * change


def _turned(load: Floats, between: Floats) -> Floats:
    """The share (T, C) that has turned at loads (T, C), from none at between[0] to all at between[1]."""
    along = np.clip((load - between[0]) / (between[1] - between[0]), 0.0, 1.0)
    return 0.5 * (1 - np.cos(np.pi * along))


class PinchedLoop(Law):
    """Baber-Noori: a hysteretic force that slips where it changes its sign, so that its loops are pinched there.

    T. T. Baber, M. N. Noori, Modeling general hysteresis behavior and random vibration application, J. Vibration,
    Acoustics, Stress, and Reliability in Design 108, 1986.
    """

    effect = "hysteresis"

    def __init__(self, setting: Setting) -> None:
        super().__init__(setting)
        random, count = setting.random, len(self.rig.chambers)
        self._yields_at = random.uniform(0.06, 0.16, count)
        self._round = random.uniform(0.4, 0.7)
        self._slips, self._wide = random.uniform(0.5, 0.9), random.uniform(0.15, 0.4)
        self._where = random.uniform(0.0, 0.25)
        self._held = some(random, count, 0.05, 0.13, 0.9)

    def pressure(self, path: Path, kpa: Floats, strength: float) -> Floats:
        moves, _, last = finely(path, full(self.rig, kpa), 0.03)
        moves = moves / self._yields_at
        force, out = np.zeros(kpa.shape[1]), np.empty_like(moves)
        for t, move in enumerate(moves):
            way = np.sign(move)
            gives = 1 - self._slips * np.exp(-(((force * way - self._where) / self._wide) ** 2))
            bends = 1 - np.abs(force) * (self._round + (1 - self._round) * np.sign(force * way))
            force = np.clip(force + move * gives * bends, -1.0, 1.0)
            out[t] = force
        return kpa - strength * self._held * self.rig.high_kpa * out[last]


class VectorPlay(Law):
    """Vector play: the pressures together, as one point, drag balls of a few radii along; what lags remembers them all.

    P. Krejčí, Hysteresis, Convexity and Dissipation in Hyperbolic Equations, Gakkōtosho, Tokyo, 1996.
    """

    effect = "hysteresis"
    needs = frozenset({"several"})

    def __init__(self, setting: Setting) -> None:
        super().__init__(setting)
        random, count = setting.random, len(self.rig.chambers)
        self._root = np.sqrt(count)
        self._radius = self._root * np.array([0.06, 0.15, 0.35]) * random.uniform(0.7, 1.3, 3)
        self._share = random.dirichlet([2.0, 2.0, 2.0])
        self._metric = random.uniform(0.7, 1.3, count)
        self._held = some(random, count, 0.05, 0.12, 0.9)

    def pressure(self, path: Path, kpa: Floats, strength: float) -> Floats:
        drive = full(self.rig, kpa) * self._metric
        state, held = np.zeros((3, drive.shape[1])), np.empty_like(drive)
        for t, now in enumerate(drive):
            behind = now - state
            length = np.maximum(np.linalg.norm(behind, axis=1), 1e-12)
            behind = behind * np.minimum(1.0, self._radius / length)[:, None]
            state = now - behind
            held[t] = (self._share / self._radius) @ behind
        return kpa - strength * self._held * self.rig.high_kpa * self._root * held
