"""Laws outside the library, of the sixth portion: real phenomena that none of its names describes."""

import numpy as np

from labrig.arrays import Floats
from labrig.bench._nature import Law, Path, Setting
from labrig.bench.development._places import (
    direction,
    full,
    positions,
    shift,
    smooth_field,
    some,
    span,
    spread,
)

_MANY = 1009


def _ends(path: Path) -> tuple[np.ndarray, np.ndarray]:
    """The first moment of each actuation, and the last one."""
    first = np.flatnonzero(np.diff(path.event, prepend=-1))
    return first, np.append(first[1:], len(path.event)) - 1


class CameraHandover(Law):
    """Hand-over: markers beyond a plane are seen by other cameras, whose calibration puts them a little elsewhere.

    A. M. Aurand, J. S. Dufour, W. S. Marras, Accuracy map of an optical motion capture system with 42 or 21 cameras in
    a large measurement volume, J. Biomechanics 58, 2017.
    """

    effect = "camera_handover"
    needs = frozenset({"markers"})

    def __init__(self, setting: Setting) -> None:
        super().__init__(setting)
        rig, path, random = self.rig, setting.path, setting.random
        assert rig.rest_mm is not None
        seen = positions(rig, rig.settled(path.kpa[path.row][::5]))
        moves = seen - rig.rest_mm
        main = np.linalg.svd(moves.reshape(-1, 3), full_matrices=False)[2][0]
        self._across = main + 0.3 * direction(random)
        self._across /= np.linalg.norm(self._across)
        far = seen @ self._across
        most = far[:, np.argsort(np.ptp(far, axis=0))[-max(1, far.shape[1] // 3) :]]
        self._at_mm = float(np.quantile(most, random.uniform(0.3, 0.7)))
        self._soft_mm = 0.02 * max(float(np.ptp(most)), 1e-6)
        self._there = np.array([o.marker for o in rig.observables])
        self._elsewhere = shift(rig, span(rig) * random.uniform(0.2, 0.6) * direction(random))

    def seen(self, path: Path, deflection: Floats, values: Floats, strength: float) -> Floats:
        past = (positions(self.rig, values) @ self._across - self._at_mm) / self._soft_mm
        other = 0.5 * (1 + np.tanh(past))
        change = other[:, self._there] * self._elsewhere
        return values + strength * np.where(self._there >= 0, change, 0.0)


class EveryOtherTime(Law):
    """Two in turn: a standby valve and its twin take turns, so that every other actuation gets a little more, or less.

    M. J. Feigenbaum, Quantitative universality for a class of nonlinear transformations, J. Statistical Physics 19,
    1978 (a period of two); from laboratory experience.
    """

    effect = "every_other_time"

    def __init__(self, setting: Setting) -> None:
        super().__init__(setting)
        random, count = setting.random, len(self.rig.chambers)
        self._apart = some(random, count, 0.03, 0.1, 0.7) * random.choice([-1.0, 1.0], count)
        self._first = int(random.integers(2))

    def pressure(self, path: Path, kpa: Floats, strength: float) -> Floats:
        turn = np.where((path.event + self._first) % 2 == 0, 1.0, -1.0)
        return kpa * np.exp(strength * turn[:, None] * self._apart)


class CarryOver(Law):
    """Carry-over: of what was asked for the last time a share is still there, and as much until the next actuation.

    B. Jones, M. G. Kenward, Design and Analysis of Cross-Over Trials, Chapman and Hall, 1989. Air is trapped behind a
    valve, and gets out as it opens next.
    """

    effect = "carry_over"

    def __init__(self, setting: Setting) -> None:
        super().__init__(setting)
        random, count = setting.random, len(self.rig.chambers)
        self._share = some(random, count, 0.04, 0.12, 0.8)
        self._last_but_one = random.uniform(0.0, 0.4)

    def pressure(self, path: Path, kpa: Floats, strength: float) -> Floats:
        first, last = _ends(path)
        none = np.zeros((1, kpa.shape[1]))
        before = np.vstack([none, kpa[last][:-1]])
        earlier = np.vstack([none, before[:-1]])
        carried = (before + self._last_but_one * earlier)[np.repeat(np.arange(len(first)), last - first + 1)]
        opens = -np.expm1(-path.hold_s[:, None] / 0.2)
        return kpa + strength * self._share * carried * opens


class LooseContact(Law):
    """Loose contact: a sensor's plug has one of two resistances, and motions shake it from one to the other.

    R. Holm, Electric Contacts: Theory and Application, 4th ed., Springer, 1967; S. Machlup, Noise in semiconductors:
    spectrum of a two-parameter random signal, J. Applied Physics 25, 1954.
    """

    effect = "loose_contact"

    def __init__(self, setting: Setting) -> None:
        super().__init__(setting)
        random, count = setting.random, len(self.rig.chambers)
        self._which = random.permutation(count)[: int(random.integers(1, min(count, 2) + 1))]
        seldom = random.uniform(0.08, 0.4)
        shaken = random.random((_MANY, len(self._which))) < seldom
        self._other = np.cumsum(shaken, axis=0) % 2
        self._off = random.uniform(0.06, 0.2, len(self._which)) * random.choice([-1.0, 1.0])

    def pressure(self, path: Path, kpa: Floats, strength: float) -> Floats:
        out, other = kpa.copy(), self._other[path.event % _MANY]
        out[:, self._which] *= np.exp(strength * self._off * other)
        return out


class NewFolds(Law):
    """New folds: each time the skin goes slack it folds anew, and what it was folded into is seen until the next time.

    E. Cerda, L. Mahadevan, Geometry and physics of wrinkling, Physical Review Letters 90, 2003. Pressure smooths the
    folds out in part.
    """

    effect = "new_folds"

    def __init__(self, setting: Setting) -> None:
        super().__init__(setting)
        random, path, rig = setting.random, setting.path, self.rig
        if rig.rest_mm is not None:
            folds = np.array([spread(rig, smooth_field(setting)) for _ in range(6)])
        else:
            folds = random.normal(size=(6, len(rig.observables)))
        self._folds = span(rig) * random.uniform(0.15, 0.4) * folds
        self._mixed = random.normal(size=(_MANY, 6)) / np.sqrt(6)
        size = np.abs(full(rig, path.kpa[_ends(path)[1]])).mean(axis=1)
        self._slack = max(float(np.quantile(size, random.uniform(0.15, 0.35))), 1e-6)
        self._smooths = random.uniform(0.2, 1.0)

    def seen(self, path: Path, deflection: Floats, values: Floats, strength: float) -> Floats:
        first, last = _ends(path)
        size = np.abs(full(self.rig, path.kpa[last])).mean(axis=1)
        slack = np.repeat(np.cumsum(size <= self._slack), last - first + 1)
        left = np.exp(-self._smooths * np.abs(deflection).mean(axis=1))
        return values + strength * left[:, None] * (self._mixed[slack % _MANY] @ self._folds)
