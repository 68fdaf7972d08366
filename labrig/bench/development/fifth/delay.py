"""Delay of the fifth portion: messages that come late by chance, profiles of a trapezoid, valves that open softly.

The stronger the law, the longer it takes.
"""

import numpy as np

from labrig.arrays import Floats
from labrig.bench._nature import Law, Path, Setting
from labrig.bench.development._places import full, some

_MANY = 1009


def _begins(path: Path) -> list[tuple[int, int]]:
    """First moment of each actuation, and of the next one."""
    first = np.flatnonzero(np.diff(path.event, prepend=-1)).tolist()
    return list(zip(first, [*first[1:], len(path.event)], strict=True))


class LateMessages(Law):
    """Network: each command waits in a queue, mostly a little and now and then long, by a gamma law.

    J. Nilsson, Real-Time Control Systems with Delays, PhD thesis, Lund Institute of Technology, 1998.
    """

    effect = "delay"

    def __init__(self, setting: Setting) -> None:
        super().__init__(setting)
        random = setting.random
        often_s = random.gamma(random.uniform(0.8, 2.0), random.uniform(0.3, 0.9), _MANY)
        self._wait_s = np.minimum(random.uniform(0.8, 1.8) + often_s, 5.0)
        self._soft_s = random.uniform(0.1, 0.3)

    def pressure(self, path: Path, kpa: Floats, strength: float) -> Floats:
        if strength <= 0:
            return kpa
        out, before = kpa.copy(), np.zeros(kpa.shape[1])
        for first, end in _begins(path):
            wait_s = strength * self._wait_s[int(path.event[first]) % _MANY]
            gone = path.hold_s[first:end, None]
            left = np.minimum(1.0, np.exp(-(gone - wait_s) / self._soft_s))
            late = kpa[first:end] + (before - kpa[first:end]) * left
            out[first:end] = late if wait_s > 0 else kpa[first:end]
            before = out[end - 1]
        return out


class TrapezoidProfile(Law):
    """Trapezoid of speed: a small step takes the root of its size, a large one speeds up, goes on evenly, and slows.

    M. W. Spong, S. Hutchinson, M. Vidyasagar, Robot Modeling and Control, Wiley, 2006.
    """

    effect = "delay"

    def __init__(self, setting: Setting) -> None:
        super().__init__(setting)
        random, count = setting.random, len(self.rig.chambers)
        self._cross_s = some(
            random, count, 2.5, 6.0, random.uniform(0.6, 1.0)
        )  # full scale at the highest speed
        self._speeds_up_s = random.uniform(0.5, 1.8)

    def pressure(self, path: Path, kpa: Floats, strength: float) -> Floats:
        if strength <= 0:
            return kpa
        load, out, before = full(self.rig, kpa), kpa.copy(), np.zeros(kpa.shape[1])
        speed = 1 / np.maximum(strength * self._cross_s, 1e-6)
        up_s = strength * self._speeds_up_s
        for first, end in _begins(path):
            step = np.maximum(np.abs(load[end - 1] - before), 1e-9)
            rise_s = np.minimum(up_s, np.sqrt(step * up_s / speed))  # of a triangle, where the step is small
            top = speed * rise_s / up_s
            whole_s = rise_s + step / top
            at_s = np.minimum(path.hold_s[first:end, None], whole_s)
            left_s = whole_s - at_s
            gone = np.where(
                at_s < rise_s,
                0.5 * top * at_s**2 / rise_s,
                np.where(left_s < rise_s, step - 0.5 * top * left_s**2 / rise_s, top * (at_s - 0.5 * rise_s)),
            )
            late = before + (load[first:end] - before) * gone / step
            late = np.where(self._cross_s > 0, late, load[first:end])
            out[first:end] = late * self.rig.high_kpa
            before = late[-1]
        return out


class SoftStart(Law):
    """Soft-start valve: it opens evenly with time, so that what is left falls as a bell: late, then fast.

    ISO 4414, Pneumatic fluid power: general rules and safety requirements for systems, 2010 (slow-start valves).
    """

    effect = "delay"

    def __init__(self, setting: Setting) -> None:
        super().__init__(setting)
        random, count = setting.random, len(self.rig.chambers)
        self._opens_s = random.uniform(1.0, 2.4) * some(random, count, 0.85, 1.15, random.uniform(0.6, 1.0))

    def pressure(self, path: Path, kpa: Floats, strength: float) -> Floats:
        if strength <= 0:
            return kpa
        opens_s, out, before = strength * self._opens_s, kpa.copy(), np.zeros(kpa.shape[1])
        for first, end in _begins(path):
            share = path.hold_s[first:end, None] / np.maximum(opens_s, 1e-6)
            left = np.where(opens_s > 0, np.exp(-0.5 * np.minimum(share, 30.0) ** 2), 0.0)
            out[first:end] = kpa[first:end] + (before - kpa[first:end]) * left
            before = out[end - 1]
        return out
