"""Laws outside the library, of the third portion: real phenomena that none of its names describes."""

import numpy as np

from labrig.arrays import Floats
from labrig.bench._nature import Law, Path, Setting
from labrig.bench.development._places import columns, full, moved, positions, smooth_field, some, span, spread
from labrig.bench.development._story import pauses, steps


class BucklesEitherWay(Law):
    """Pitchfork: above a load the body buckles aside with the root of what is too much, each time to either side.

    W. T. Koiter, On the Stability of Elastic Equilibrium, thesis, Delft, 1945.
    """

    effect = "buckles_either_way"

    def __init__(self, setting: Setting) -> None:
        super().__init__(setting)
        random, path = setting.random, setting.path
        count = len(self.rig.chambers)
        self._bears = random.uniform(0.5, 1.5, count)
        load = self._load(path.kpa[path.row])
        self._over = float(np.quantile(load, random.uniform(0.45, 0.7)))
        self._most = max(float(load.max()) - self._over, 1e-6)
        self._side = random.choice([-1.0, 1.0], 997)
        if columns(self.rig).max(initial=-1) >= 0:
            field = spread(self.rig, smooth_field(setting))
        else:
            field = random.choice([-1.0, 1.0], len(self.rig.observables))
        self._aside = span(self.rig) * random.uniform(0.15, 0.4) * field

    def _load(self, kpa: Floats) -> Floats:
        return np.abs(full(self.rig, kpa)) @ self._bears

    def seen(self, path: Path, deflection: Floats, values: Floats, strength: float) -> Floats:
        past = np.maximum(self._load(path.kpa) - self._over, 0.0) / self._most
        began = np.cumsum(np.diff((past > 0).astype(int), prepend=0) > 0)  # how often it has buckled
        aside = np.sqrt(past) * self._side[began % len(self._side)]
        return values + strength * aside[:, None] * self._aside


class LostCommands(Law):
    """Lossy link: now and then a chamber does not get its new set-point, and stays where it was until the next one.

    L. Schenato, To zero or to hold control inputs with lossy links?, IEEE Trans. Automatic Control 54, 2009.
    """

    effect = "lost_commands"

    def __init__(self, setting: Setting) -> None:
        super().__init__(setting)
        random, count = setting.random, len(self.rig.chambers)
        bad = some(random, count, 0.15, 0.3, 0.5)  # how often each chamber's are lost
        self._lost = random.random((997, count)) < bad
        self._share = random.uniform(0.3, 0.7)

    def pressure(self, path: Path, kpa: Floats, strength: float) -> Floats:
        stays = -np.expm1(-strength * self._share)  # of a lost step; in part where packets repeat
        out, before = kpa.copy(), np.zeros(kpa.shape[1])
        begins = np.flatnonzero(np.diff(path.event, prepend=-1))
        for first, end in zip(begins, np.append(begins[1:], len(kpa)), strict=True):
            lost = self._lost[path.event[first] % len(self._lost)]
            out[first:end] += np.where(lost, stays * (before - out[first:end]), 0.0)
            before = out[end - 1]
        return out


class StickingWalls(Law):
    """Self-adhesion: walls that have lain on each other open late at the next filling, the later the longer they lay.

    G. R. Hamed, Tack and green strength of elastomeric materials, Rubber Chemistry and Technology 54, 1981.
    """

    effect = "sticking_walls"

    def __init__(self, setting: Setting) -> None:
        super().__init__(setting)
        random, count = setting.random, len(self.rig.chambers)
        self._lies = random.uniform(0.2, 0.35)  # deflection below which walls touch
        self._tau_s = np.exp(random.uniform(np.log(3), np.log(40)))
        self._sticks = some(random, count, 0.3, 0.8, 0.85)

    def wall(self, path: Path, kpa: Floats, deflection: Floats, strength: float) -> Floats:
        lies, pause_s = np.abs(deflection) < self._lies, pauses(path)
        lay_s, glued = np.zeros(deflection.shape[1]), np.zeros(deflection.shape[1])
        held, event = np.empty_like(deflection), -1
        for t in range(len(held)):
            if path.event[t] != event:
                event = path.event[t]
                glued = -np.expm1(-lay_s / self._tau_s)  # what this actuation has to open
            lay_s = np.where(lies[t], lay_s + pause_s[t], 0.0)
            held[t] = glued
        return deflection * np.exp(-strength * self._sticks * held)


class Thixotropy(Law):
    """Thixotropy: motion breaks the filler's network down, rest builds it up again, and broken walls give way more.

    J. Mewis, N. J. Wagner, Thixotropy, Advances in Colloid and Interface Science 147-148, 2009.
    """

    effect = "thixotropy"

    def __init__(self, setting: Setting) -> None:
        super().__init__(setting)
        random = setting.random
        self._heals_s = np.exp(random.uniform(np.log(20), np.log(200)))
        self._breaks = random.uniform(0.5, 2.0)  # for each full stroke
        self._softer = some(random, len(self.rig.chambers), 0.15, 0.45, 0.9)

    def wall(self, path: Path, kpa: Floats, deflection: Floats, strength: float) -> Floats:
        stroke = np.abs(steps(full(self.rig, kpa)))
        breaks, heals = np.exp(-self._breaks * stroke), -np.expm1(-pauses(path) / self._heals_s)
        whole, broken = np.ones(deflection.shape[1]), np.empty_like(deflection)
        for t in range(len(broken)):
            whole = whole * breaks[t]
            whole = whole + heals[t] * (1 - whole)
            broken[t] = 1 - whole
        return deflection * np.exp(np.minimum(strength * self._softer * broken, 2.0))


class MergedBlobs(Law):
    """Overlapping spots: the images of two markers that come near each other overlap, and are drawn together.

    M. R. Shortis, T. A. Clarke, T. Short, A comparison of some techniques for the subpixel location of discrete target
    images, Videometrics III, SPIE 2350, 1994.
    """

    effect = "merged_blobs"
    needs = frozenset({"markers"})

    def __init__(self, setting: Setting) -> None:
        super().__init__(setting)
        rig, path, random = self.rig, setting.path, setting.random
        seen = positions(rig, rig.settled(path.kpa[path.row][::7]))
        apart = np.linalg.norm(seen[:, :, None] - seen[:, None], axis=3)
        varies = np.ptp(apart, axis=0)
        upper = np.triu_indices(len(rig.marker_names), 1)
        most = np.argsort(-(varies / (apart.mean(axis=0) + 1e-9))[upper])[
            : max(3, len(rig.marker_names) // 2)
        ]
        self._pairs = np.stack([upper[0][most], upper[1][most]], axis=1)
        self._wide_mm = np.quantile(apart[:, self._pairs[:, 0], self._pairs[:, 1]], 0.3, axis=0) * 0.7
        self._drawn = span(rig) * random.uniform(0.2, 0.5)

    def seen(self, path: Path, deflection: Floats, values: Floats, strength: float) -> Floats:
        points = positions(self.rig, values)
        out = points.copy()
        for (one, other), wide_mm in zip(self._pairs, self._wide_mm, strict=True):
            to = points[:, other] - points[:, one]
            apart = np.linalg.norm(to, axis=1, keepdims=True)
            draws = (
                strength * self._drawn * np.exp(-0.5 * (apart / wide_mm) ** 2) * to / np.maximum(apart, 1e-9)
            )
            out[:, one] += draws
            out[:, other] -= draws
        return moved(self.rig, values, out)
