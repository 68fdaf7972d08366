"""Outside the library, of the eleventh portion: integrators, spare bodies, filters, gates; views are beside it."""

import numpy as np

from labrig.arrays import Floats, Ints
from labrig.bench._nature import Law, Path, Setting
from labrig.bench.development._places import either_way, full, some, span
from labrig.bench.development._story import a_moment_s, pauses
from labrig.bench.development.eleventh.outside_more import (
    CutByImageEdge,
    GrazingView,
    MarkersOnStalks,
    SeenAtFixedPlaces,
)


def _ends(path: Path) -> Ints:
    """The last moment (E,) of each actuation."""
    return np.searchsorted(path.event, np.arange(path.event[-1] + 1), side="right") - 1


class IntegralWindsUp(Law):
    """Integral windup: while a regulator cannot quite reach its set-point it sums up its error, and pays it back later.

    K. J. Åström, T. Hägglund, Advanced PID Control, ISA, 2006, chapter 3. After a hold near the top the pressure stays
    above the next, lower set-point, the longer the hold was the more, until the sum has run down.
    """

    effect = "windup"

    def __init__(self, setting: Setting) -> None:
        super().__init__(setting)
        random, count = setting.random, len(self.rig.chambers)
        self._reaches = random.uniform(0.45, 0.75)  # of full pressure, with ease
        self._winds_s = random.uniform(0.4, 2.0)
        self._unwinds_s = random.uniform(1.0, 6.0) * random.uniform(0.8, 1.2, count)
        self._size = some(random, count, 0.3, 0.8, share=0.8)

    def pressure(self, path: Path, kpa: Floats, strength: float) -> Floats:
        ends = _ends(path)
        told = full(self.rig, path.commanded_kpa[ends])
        begins_s = path.time_s[np.concatenate([[0], ends[:-1] + 1])]
        held_s = np.diff(np.append(begins_s, path.time_s[-1]))
        wound = -np.expm1(-held_s[:, None] * np.maximum(told - self._reaches, 0.0) / self._winds_s)
        falls = np.maximum(told[:-1] - told[1:], 0.0)
        none = np.zeros((1, told.shape[1]))
        wound, falls = np.concatenate([none, wound[:-1]]), np.concatenate([none, falls])
        left = strength * self._size * wound[path.event] * np.exp(-path.hold_s[:, None] / self._unwinds_s)
        # right after an actuation the chamber has not come down yet anyway
        surplus = np.minimum(left, 1.0) * falls[path.event] * -np.expm1(-path.hold_s[:, None] / 0.3)
        return kpa + surplus * self.rig.high_kpa


class SpareBody(Law):
    """Spare body: a chamber burst, and from then on a sister from the same mould is measured, with markers of its own.

    JCGM 100, Guide to the Expression of Uncertainty in Measurement, 2008, annex F: between samples of one make. Its
    walls are not quite as thick, give way along a slightly other curve, and the markers were glued on by hand.
    """

    effect = "body_exchanged"

    def __init__(self, setting: Setting) -> None:
        super().__init__(setting)
        random = setting.random
        self._from_s = a_moment_s(setting)
        self._softer = either_way(setting, 0.03, 0.12)
        self._bent = random.normal(0, 0.06, len(self.rig.chambers))
        self._glued = random.normal(0, random.uniform(0.02, 0.08), len(self.rig.observables)) * span(self.rig)

    def wall(self, path: Path, kpa: Floats, deflection: Floats, strength: float) -> Floats:
        late = path.time_s[:, None] >= self._from_s
        other = self._softer + self._bent * (np.clip(deflection, -0.5, 1.5) - 0.5)
        return deflection + strength * late * other * deflection

    def seen(self, path: Path, deflection: Floats, values: Floats, strength: float) -> Floats:
        return values + strength * (path.time_s[:, None] >= self._from_s) * self._glued


class SmoothedAfterwards(Law):
    """Smoothed afterwards: the record was filtered forwards and backwards, and knows of each actuation before it comes.

    D. A. Winter, H. G. Sidwall, D. A. Hobson, Measurement and reduction of noise in kinematics of locomotion, J.
    Biomechanics 7, 1974. Such a filter has no lag; the last frames of a hold look ahead to the next pose, the first
    ones back to that before. Some numbers (hands, say) are filtered more than others.
    """

    effect = "smoothed_afterwards"

    def __init__(self, setting: Setting) -> None:
        super().__init__(setting)
        random = setting.random
        self._tau_s = random.uniform(0.2, 0.45) * random.uniform(0.8, 1.25, len(self.rig.observables))

    @staticmethod
    def _filtered(values: Floats, pause_s: Floats, tau_s: Floats) -> Floats:
        """What follows the values (T, K) one way, after pauses (T,)."""
        share = -np.expm1(-pause_s[:, None] / tau_s)
        state, out = values[0], np.empty_like(values)
        for i in range(len(values)):
            state = state + share[i] * (values[i] - state)
            out[i] = state
        return out

    def seen(self, path: Path, deflection: Floats, values: Floats, strength: float) -> Floats:
        if strength == 0:
            return values
        tau_s, pause_s = strength * self._tau_s, pauses(path)
        there = self._filtered(values, pause_s, tau_s)
        back = np.append(pause_s[1:], 0.0)[::-1]
        return self._filtered(there[::-1], back, tau_s)[::-1]


class JumpsDisbelieved(Law):
    """Jumps disbelieved: what jumps by more than a gate from capture to capture is held for an error, and cut down.

    F. R. Hampel, The influence curve and its role in robust estimation, J. American Statistical Association 69, 1974;
    so do trackers that gate by speed. Each number has its gate, small actuations pass untouched, and what was cut off
    once is caught up with in the next capture, or when a session begins anew.
    """

    effect = "outlier_gate"

    def __init__(self, setting: Setting) -> None:
        super().__init__(setting)
        random, path = setting.random, setting.path
        shown = self.rig.settled(path.commanded_kpa[_ends(path)])
        usual = np.sqrt(np.mean(np.diff(shown, axis=0, prepend=shown[:1]) ** 2, axis=0))
        gate = random.uniform(0.9, 1.6) * random.uniform(0.9, 1.1, usual.size)
        self._gate = gate * np.maximum(usual, 1e-3 * span(self.rig))
        self._cut = random.uniform(0.25, 0.6)  # of what is beyond it, as 1 - exp(-cut)

    def seen(self, path: Path, deflection: Floats, values: Floats, strength: float) -> Floats:
        if strength == 0:
            return values
        gate, cut, ends = self._gate, -np.expm1(-strength * self._cut), _ends(path)
        pose, begins = values[ends], np.diff(path.session[ends], prepend=-1) > 0
        lacks = np.zeros_like(pose)
        for i in range(1, len(pose)):
            if not begins[i]:
                jump = pose[i] - (pose[i - 1] - lacks[i - 1])
                lacks[i] = cut * (jump - np.clip(jump, -gate, gate))
        return values - lacks[path.event]


OUTSIDE: tuple[type[Law], ...] = (
    IntegralWindsUp,
    SpareBody,
    SmoothedAfterwards,
    JumpsDisbelieved,
    MarkersOnStalks,
    GrazingView,
    SeenAtFixedPlaces,
    CutByImageEdge,
)
