"""Marker slip of the sixth portion: steps to any side, oil under stretched skin, a pin that unscrews."""

import numpy as np

from labrig.arrays import Floats
from labrig.bench._nature import Path, Setting
from labrig.bench.development._places import alone, direction, reached, shift, span
from labrig.bench.development._story import pauses, steps
from labrig.bench.development.marker_slip import Slip

_MANY = 4001


class WandersByChance(Slip):
    """Random walk: from a moment on each actuation lets a loose marker creep a little, to whichever side.

    A. Einstein, Über die von der molekularkinetischen Theorie der Wärme geforderte Bewegung von in ruhenden
    Flüssigkeiten suspendierten Teilchen, Annalen der Physik 322, 1905.
    """

    def __init__(self, setting: Setting) -> None:
        super().__init__(setting)
        random, path = setting.random, setting.path
        count = max(int(path.event.max()) + 1, 2)
        first = int(random.integers(1, max(2, count // 2)))
        goes = random.normal(size=(_MANY, 3))
        goes[:first] = 0.0
        size = span(self.rig) * random.uniform(0.3, 0.9) / np.sqrt(count - first)
        self._gone = self._own * shift(self.rig, size * np.cumsum(goes, axis=0))

    def seen(self, path: Path, deflection: Floats, values: Floats, strength: float) -> Floats:
        return values + strength * self._gone[np.minimum(path.event, _MANY - 1)]


class OilUnderIt(Slip):
    """Film of oil: it flows in proportion to what the stretched skin pulls with, and a marker slides while it is.

    I. Newton, Philosophiae Naturalis Principia Mathematica, London, 1687 (the resistance of liquids). Vented it stays
    where it is. The oil has crept in by some moment.
    """

    def __init__(self, setting: Setting) -> None:
        super().__init__(setting)
        random = setting.random
        pulls = np.linalg.norm(alone(self.rig) * self._own, axis=1)
        self._pulls = pulls / max(float(pulls.sum()), 1e-9)
        self._at_s = self._begin_s + self._length_s * random.uniform(0.0, 0.6)
        self._ends = random.uniform(0.3, 1.5)  # the way at which it has run dry
        path, few = setting.path, np.abs(self.rig.deflection(setting.path.kpa))
        begun = self._run(path, few)
        self._all = max(float(begun[path.row].max()), 1e-9)

    def _run(self, path: Path, deflection: Floats) -> Floats:
        """What has flowed by each moment (T,), in s of full stretch."""
        pull = np.abs(deflection) @ self._pulls
        return np.cumsum(pull * pauses(path) * (path.time_s > self._at_s))

    def seen(self, path: Path, deflection: Floats, values: Floats, strength: float) -> Floats:
        run = self._run(path, deflection) / self._all
        gone = -np.expm1(-self._ends * run) / -np.expm1(-self._ends)
        return values + strength * gone[:, None] * self._way_mm


class UnscrewsItself(Slip):
    """Self-loosening: a marker sits a little off its pin's axis; each large motion turns the pin, and winds it out.

    G. H. Junker, New criteria for self-loosening of fasteners under vibration, SAE Transactions 78, 1969.
    """

    def __init__(self, setting: Setting) -> None:
        super().__init__(setting)
        rig, path, random = self.rig, setting.path, setting.random
        self._holds = reached(rig, path) * random.uniform(0.05, 0.3)
        pulls = np.linalg.norm(alone(rig) * self._own, axis=1)
        self._pulls = pulls / max(float(pulls.max()), 1e-9)
        self._from_s = self._begin_s + self._length_s * random.uniform(0.0, 0.5)
        axis = direction(random)
        one = np.cross(axis, direction(random))
        one /= np.linalg.norm(one)
        self._axes = np.stack([one, np.cross(axis, one), axis])
        self._off_mm = span(rig) * random.uniform(0.2, 0.6)
        self._rises = random.uniform(0.02, 0.12)  # of that, a radian
        turned = self._turned(path, rig.deflection(path.kpa))
        self._rad = random.uniform(1.5, 9.0) / max(float(turned[path.row].max()), 1e-9)

    def _turned(self, path: Path, deflection: Floats) -> Floats:
        """How far the pin is turned at each moment (T,), in natural units."""
        own = path.event - path.event[0]
        begins = np.flatnonzero(np.diff(path.event, prepend=-1))
        ends = np.append(begins[1:], len(path.event)) - 1
        late = path.time_s[begins] > self._from_s
        moves = np.abs(steps(deflection[ends])) - self._holds
        turn = np.maximum(moves, 0.0) @ self._pulls * late
        return np.cumsum(turn)[own]

    def seen(self, path: Path, deflection: Floats, values: Floats, strength: float) -> Floats:
        angle = self._rad * self._turned(path, self.rig.deflection(path.kpa))
        there = np.stack([np.cos(angle) - 1, np.sin(angle), self._rises * angle], axis=1) @ self._axes
        return values + strength * self._off_mm * self._own * shift(self.rig, there)
