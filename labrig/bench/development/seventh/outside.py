"""Laws outside the library, of the seventh portion: real phenomena that none of its names describes."""

import numpy as np

from labrig.arrays import Floats
from labrig.bench._nature import Law, Path, Setting
from labrig.bench.development._places import (
    body_mm,
    direction,
    full,
    moved,
    positions,
    shift,
    span,
)
from labrig.bench.development._story import pauses, steps

_MANY = 4001


class NeighbourDraws(Law):
    """Neighbour on the line: now and then someone else draws air for a while, and all chambers get a little less.

    A. K. Erlang, The theory of probabilities and telephone conversations, Nyt Tidsskrift for Matematik B 20, 1909.
    Who draws comes by chance, and stays by chance.
    """

    effect = "neighbour_draws"

    def __init__(self, setting: Setting) -> None:
        super().__init__(setting)
        random, seen_s = setting.random, setting.path.time_s[setting.path.row]
        count = int(random.integers(5, 16))
        self._begin_s, self._long_s = float(seen_s.min()), max(float(np.ptp(seen_s)), 1.0)
        self._from = random.uniform(0.0, 1.0, count)
        self._stays = random.exponential(random.uniform(0.15, 0.4) / count, count) + 0.01
        self._less = random.uniform(0.04, 0.12) * random.uniform(0.8, 1.2, len(self.rig.chambers))

    def pressure(self, path: Path, kpa: Floats, strength: float) -> Floats:
        at = np.mod((path.time_s - self._begin_s) / self._long_s, 1.0)[:, None]
        draws = np.sum((at >= self._from) & (at < self._from + self._stays), axis=1, keepdims=True)
        return kpa * np.exp(-strength * np.minimum(draws, 2) * self._less)


class RubsItselfFull(Law):
    """Charge: motion rubs charge onto the skin, which draws the body to what is near by its square, and leaks away.

    D. J. Lacks, R. M. Sankaran, Contact electrification of insulating materials, J. Physics D 44, 2011.
    """

    effect = "rubbed_charge"

    def __init__(self, setting: Setting) -> None:
        super().__init__(setting)
        random, rig, path = setting.random, self.rig, setting.path
        self._tau_s = np.exp(random.uniform(np.log(20), np.log(300)))
        self._rubs = random.dirichlet(np.ones(len(rig.chambers)))
        self._most = 1.0
        self._most = max(float(self._charge(path, rig.deflection(path.kpa))[path.row].max()), 1e-9)
        self._way = shift(rig, span(rig) * random.uniform(0.3, 0.9) * direction(random))

    def _charge(self, path: Path, deflection: Floats) -> Floats:
        """The charge (T,), 1 at most."""
        rubbed, stays = np.abs(steps(deflection)) @ self._rubs, np.exp(-pauses(path) / self._tau_s)
        charge, out = 0.0, np.empty(len(rubbed))
        for t, more in enumerate(rubbed):
            charge = charge * stays[t] + more
            out[t] = charge
        return out / self._most

    def seen(self, path: Path, deflection: Floats, values: Floats, strength: float) -> Floats:
        charge = self._charge(path, self.rig.deflection(path.kpa))
        return values + strength * charge[:, None] ** 2 * self._way


class FocusBreathes(Law):
    """Focus that breathes: a lens that follows the body by its autofocus changes its scale by as much as it does so.

    R. G. Willson, Modeling and Calibration of Automated Zoom Lenses, PhD thesis, Carnegie Mellon University, 1994.
    """

    effect = "focus_breathes"
    needs = frozenset({"markers"})

    def __init__(self, setting: Setting) -> None:
        super().__init__(setting)
        rig, random, (centre, radius) = self.rig, setting.random, body_mm(self.rig)
        settled = rig.settled(setting.path.kpa[setting.path.row][::3])
        middle = positions(rig, settled).mean(axis=1) - positions(rig, rig.at_rest[None]).mean(axis=1)
        main = np.linalg.svd(middle, full_matrices=False)[2][0]
        looks = main + 0.6 * direction(random)
        self._looks = looks / np.linalg.norm(looks)
        self._far_mm = max(float(np.abs(middle @ self._looks).max()), 1e-9)
        self._focus_mm = centre + radius * random.uniform(0.0, 1.0) * direction(random)
        self._scale = span(rig) / radius * random.uniform(0.15, 0.4) * random.choice([-1.0, 1.0])

    def seen(self, path: Path, deflection: Floats, values: Floats, strength: float) -> Floats:
        points = positions(self.rig, values)
        rest = positions(self.rig, self.rig.at_rest[None]).mean(axis=1)
        near = (points.mean(axis=1) - rest) @ self._looks / self._far_mm
        ray = points - self._focus_mm
        aside = ray - (ray @ self._looks)[..., None] * self._looks
        return moved(self.rig, values, points + strength * self._scale * near[:, None, None] * aside)


class BehindAWire(Law):
    """Behind a wire: where a wire hides a strip of a marker the centre of what is left of it is off to the other side.

    M. R. Shortis, T. A. Clarke, T. Short, A comparison of some techniques for the subpixel location of discrete target
    images, Proc. SPIE 2350, 1994. The wire is across the way of the markers that move most.
    """

    effect = "behind_a_wire"
    needs = frozenset({"markers"})

    def __init__(self, setting: Setting) -> None:
        super().__init__(setting)
        rig, path, random = self.rig, setting.path, setting.random
        assert rig.rest_mm is not None
        seen = positions(rig, rig.settled(path.kpa[path.row][::3]))
        main = np.linalg.svd((seen - rig.rest_mm).reshape(-1, 3), full_matrices=False)[2][0]
        across = main + 0.3 * direction(random)
        self._across = across / np.linalg.norm(across)
        far = seen @ self._across
        most = far[:, np.argsort(np.ptp(far, axis=0))[-max(1, far.shape[1] // 3) :]]
        self._at_mm = float(np.quantile(most, random.uniform(0.25, 0.75)))
        self._round_mm = max(float(np.ptp(most)), 1e-6) * random.uniform(0.12, 0.3)
        self._thin = random.uniform(0.15, 0.45)  # half of the wire, over the marker's radius

    def seen(self, path: Path, deflection: Floats, values: Floats, strength: float) -> Floats:
        points = positions(self.rig, values)
        wire = np.clip((self._at_mm - points @ self._across) / self._round_mm, -1.0, 1.0)
        hides = 4 * self._thin * np.sqrt(1 - wire**2)
        off_mm = -self._round_mm * wire * hides / (np.pi - hides)
        return moved(self.rig, values, points + strength * off_mm[..., None] * self._across)


class GrossErrors(Law):
    """Gross errors: in a few rows one number, or one marker, is far off, since a glint was taken for it.

    P. J. Huber, Robust estimation of a location parameter, Annals of Mathematical Statistics 35, 1964.
    """

    effect = "gross_errors"

    def __init__(self, setting: Setting) -> None:
        super().__init__(setting)
        random, rig = setting.random, self.rig
        place = np.array([o.marker for o in rig.observables])
        self._place = np.where(place >= 0, place, np.arange(len(place)))
        which = random.integers(int(self._place.max()) + 1, size=_MANY)
        hit = random.random(_MANY) < random.uniform(0.04, 0.15)
        far = span(rig) * random.uniform(0.6, 1.5) * random.standard_t(4, (_MANY, 3))
        self._off = (hit[:, None] & (which[:, None] == self._place)) * shift(rig, far)
        self._dim = random.uniform(0.0, 0.6)  # less so where the body is far out

    def seen(self, path: Path, deflection: Floats, values: Floats, strength: float) -> Floats:
        bright = 1 - self._dim * np.tanh(np.abs(full(self.rig, path.kpa)).mean(axis=1, keepdims=True))
        return values + strength * bright * self._off[np.arange(len(values)) % _MANY]
