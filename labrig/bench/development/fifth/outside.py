"""Laws outside the library, of the fifth portion: real phenomena that none of its names describes."""

import numpy as np

from labrig.arrays import Floats
from labrig.bench._nature import Law, Path, Setting
from labrig.bench.development._places import direction, full, overlap, shift, some, span
from labrig.bench.development._story import pauses, steps

_MANY = 1009


class StaleFrames(Law):
    """Stale frames: now and then the logger writes again what it last saw before the actuation, in a part of the rows.

    L. Lamport, Time, clocks, and the ordering of events in a distributed system, Communications of the ACM 21, 1978;
    from laboratory experience.
    """

    effect = "stale_frames"

    def __init__(self, setting: Setting) -> None:
        super().__init__(setting)
        random = setting.random
        seldom = random.random(_MANY) < random.uniform(0.1, 0.25)
        self._stale = seldom * random.uniform(0.1, 0.8, _MANY)

    def seen(self, path: Path, deflection: Floats, values: Floats, strength: float) -> Floats:
        begins = np.flatnonzero(np.diff(path.event, prepend=-1))
        last = np.maximum(begins[path.event - path.event[0]] - 1, 0)
        share = -np.expm1(-strength * self._stale[path.event % _MANY])
        return values + share[:, None] * (values[last] - values)


class CrossedHoses(Law):
    """Crossed hoses: two fittings leak into each other, or were swapped; each of two chambers gets some of the other's.

    G. Kirchhoff, Ueber den Durchgang eines elektrischen Stromes durch eine Ebene, Annalen der Physik 140, 1845 (his
    rules for nodes); from laboratory experience.
    """

    effect = "crossed_hoses"
    needs = frozenset({"several"})

    def __init__(self, setting: Setting) -> None:
        super().__init__(setting)
        random = setting.random
        self._one, self._other = random.permutation(len(self.rig.chambers))[:2]
        self._crosses = random.uniform(0.1, 0.5)

    def pressure(self, path: Path, kpa: Floats, strength: float) -> Floats:
        share = -np.expm1(-strength * self._crosses)
        out, load = kpa.copy(), full(self.rig, kpa)
        more = share * (load[:, self._other] - load[:, self._one])
        out[:, self._one] += more * self.rig.high_kpa[self._one]
        out[:, self._other] -= more * self.rig.high_kpa[self._other]
        return out


class Footsteps(Law):
    """Footsteps: people walk by at some time, and the floor swings all that is seen, in bursts that die away.

    H. Bachmann, W. Ammann, Vibrations in Structures: Induced by Man and Machines, IABSE, Zürich, 1987.
    """

    effect = "footsteps"

    def __init__(self, setting: Setting) -> None:
        super().__init__(setting)
        random, seen_s = setting.random, setting.path.time_s[setting.path.row]
        count = int(random.integers(12, 40))
        self._at_s = random.uniform(float(seen_s.min()), float(seen_s.max()), count)
        self._fades_s = random.uniform(2.0, 8.0, count) * float(np.ptp(seen_s)) / 1000
        self._round_s = random.uniform(0.4, 1.5)
        self._first = random.uniform(0, 2 * np.pi, count)
        self._size = random.exponential(1.0, count)
        self._way = shift(self.rig, span(self.rig) * random.uniform(0.2, 0.5) * direction(random))

    def seen(self, path: Path, deflection: Floats, values: Floats, strength: float) -> Floats:
        since = path.time_s[:, None] - self._at_s
        fades = np.exp(-np.maximum(since, 0.0) / self._fades_s) * (since >= 0)
        swing = np.sum(self._size * fades * np.sin(2 * np.pi * since / self._round_s + self._first), axis=1)
        return values + strength * swing[:, None] * self._way


class DraggedAlong(Law):
    """Dragged along: a wall that moves drags its neighbours a little by friction; they stay so until they move.

    P. Painlevé, Leçons sur le frottement, Hermann, Paris, 1895. What it drags fades with each step of their own.
    """

    effect = "dragged_along"
    needs = frozenset({"several"})

    def __init__(self, setting: Setting) -> None:
        super().__init__(setting)
        random, near = setting.random, overlap(self.rig)
        tied = near / max(float(near.max()), 1e-9) * random.uniform(0.5, 1.5, near.shape)
        self._drags = random.uniform(0.05, 0.15) * tied
        self._lets_go = random.uniform(0.05, 0.2)

    def wall(self, path: Path, kpa: Floats, deflection: Floats, strength: float) -> Floats:
        move = steps(deflection)
        dragged, behind = move @ self._drags.T, np.zeros(deflection.shape[1])
        stays, out = np.exp(-np.abs(move) / self._lets_go), np.empty_like(deflection)
        for t in range(len(out)):
            behind = behind * stays[t] + dragged[t]
            out[t] = behind
        return deflection + strength * out


class PoorRepeatability(Law):
    """Poor repeatability: a cheap regulator comes to rest beside its set-point, by an error of its own each time.

    ISO 10094-1, Pneumatic fluid power: electro-pneumatic pressure control valves, 2010; from laboratory experience.
    """

    effect = "poor_repeatability"

    def __init__(self, setting: Setting) -> None:
        super().__init__(setting)
        random, count = setting.random, len(self.rig.chambers)
        self._off = random.normal(size=(_MANY, count)) * some(random, count, 0.02, 0.06, 0.8)

    def pressure(self, path: Path, kpa: Floats, strength: float) -> Floats:
        open_ = np.tanh(np.abs(full(self.rig, kpa)) / 0.05)
        return kpa + strength * self.rig.high_kpa * open_ * self._off[path.event % _MANY]


class PulledCable(Law):
    """Pulled cable: the camera's cable is caught by the moving rig, and turns the camera by as much as it is pulled.

    From laboratory experience; S. Timoshenko, D. H. Young, Engineering Mechanics, 4th ed., McGraw-Hill, 1956. It is
    pulled only once a share of the chambers' way has used up its slack, and some of the turn stays until the rig rests.
    """

    effect = "pulled_cable"

    def __init__(self, setting: Setting) -> None:
        super().__init__(setting)
        random, count = setting.random, len(self.rig.chambers)
        self._weights = random.dirichlet(np.full(count, 1.0))
        far = np.abs(self.rig.deflection(setting.path.kpa)) @ self._weights
        self._slack = float(np.quantile(far, random.uniform(0.3, 0.6)))
        self._comes_back_s = np.exp(random.uniform(np.log(8), np.log(60)))
        self._stays = random.uniform(0.2, 0.6)
        self._way = shift(self.rig, span(self.rig) * random.uniform(0.3, 0.8) * direction(random))

    def seen(self, path: Path, deflection: Floats, values: Floats, strength: float) -> Floats:
        pulled = np.maximum(np.abs(deflection) @ self._weights - self._slack, 0.0)
        gone_s, kept, out = pauses(path), 0.0, np.empty_like(pulled)
        for t, now in enumerate(pulled):
            kept = max(self._stays * now, kept * np.exp(-gone_s[t] / self._comes_back_s))
            out[t] = max(now, kept)
        return values + strength * out[:, None] * self._way
