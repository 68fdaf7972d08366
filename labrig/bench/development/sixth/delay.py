"""Delay of the sixth portion: Bessel's filter, tubes by conductance, pilot valves, volumes that grow as they fill.

The stronger the law, the longer it takes.
"""

import numpy as np

from labrig.arrays import Floats
from labrig.bench._nature import Law, Path, Setting
from labrig.bench.development._places import full, some
from labrig.bench.development._story import pauses

_POLES = np.roots([1.0, 6.0, 15.0, 15.0])
_ROOM_KPA = 101.3


class BesselsFilter(Law):
    """Filter of flattest delay: set-points go through a third-order low pass, which rounds their steps evenly.

    W. E. Thomson, Delay networks having maximally flat frequency characteristics, Proc. IEE 96, 1949.
    """

    effect = "delay"

    def __init__(self, setting: Setting) -> None:
        super().__init__(setting)
        random, count = setting.random, len(self.rig.chambers)
        self._takes_s = random.uniform(1.2, 2.2) * some(random, count, 0.85, 1.15, random.uniform(0.6, 1.0))
        others = [np.delete(_POLES, k) for k in range(3)]
        self._parts = np.array([-15.0 / p / np.prod(p - q) for p, q in zip(_POLES, others, strict=True)])

    def pressure(self, path: Path, kpa: Floats, strength: float) -> Floats:
        if strength <= 0:
            return kpa
        takes_s, gone_s = np.maximum(strength * self._takes_s, 1e-3), pauses(path)
        state, out = np.zeros((3, kpa.shape[1]), dtype=complex), np.empty_like(kpa)
        for t, now in enumerate(kpa):
            state = now + (state - now) * np.exp(_POLES[:, None] * gone_s[t] / takes_s)
            out[t] = (self._parts @ state).real
        return np.where(self._takes_s > 0, out, kpa)


class TubeByConductance(Law):
    """Tube: below a critical ratio of the pressures the flow is constant, and then it falls off by a quarter ellipse.

    F. E. Sanville, A new method of specifying the flow capacity of pneumatic fluid power valves, 2nd Fluid Power
    Symposium, BHRA, 1971. So the ratio nears one along a sine, and is there after a while.
    """

    effect = "delay"

    def __init__(self, setting: Setting) -> None:
        super().__init__(setting)
        random, count = setting.random, len(self.rig.chambers)
        self._critical = random.uniform(0.1, 0.45)
        wide = np.log1p(self.rig.high_kpa / _ROOM_KPA)
        self._takes_s = some(random, count, 2.5, 4.5, random.uniform(0.6, 1.0))  # a whole step
        ratio = np.maximum(np.exp(-wide), self._critical)
        self._left = np.arccos((ratio - self._critical) / (1 - self._critical))
        self._vents_slower = random.uniform(1.0, 1.3)

    def pressure(self, path: Path, kpa: Floats, strength: float) -> Floats:
        if strength <= 0:
            return kpa
        b, out, before = self._critical, kpa.copy(), np.zeros(kpa.shape[1])
        per_s = self._left / np.maximum(strength * self._takes_s, 1e-6)
        for first, end in _begins(path):
            now = kpa[first:end]
            old, new = np.maximum(_ROOM_KPA + before, 3.0), np.maximum(_ROOM_KPA + kpa[end - 1], 3.0)
            fills = new >= old
            ratio = np.where(fills, old / new, new / old)
            speed = per_s / np.where(fills, 1.0, self._vents_slower)
            until = np.maximum(b - ratio, 0.0)  # the way at constant flow
            begin = np.arcsin(np.clip((ratio - b) / (1 - b), 0.0, 1.0))
            phase = begin + speed * path.hold_s[first:end, None] - until / (1 - b)
            late = b + (1 - b) * np.where(phase > 0, np.sin(np.minimum(phase, 0.5 * np.pi)), phase)
            there = np.where(fills, new * late, new / np.maximum(late, ratio)) - _ROOM_KPA
            # nothing gets ahead of its own valve
            whole = kpa[end - 1] - before
            gone = np.where(
                np.abs(whole) > 1e-9, (there - before) / np.where(np.abs(whole) > 1e-9, whole, 1.0), 1.0
            )
            ahead = np.where(
                np.abs(whole) > 1e-9, (now - before) / np.where(np.abs(whole) > 1e-9, whole, 1.0), 1.0
            )
            mixed = before + whole * np.minimum(np.clip(gone, 0.0, 1.0), ahead)
            out[first:end] = np.where(self._takes_s > 0, mixed, now)
            before = out[end - 1]
        return out


def _begins(path: Path) -> list[tuple[int, int]]:
    """First moment of each actuation, and of the next one."""
    first = np.flatnonzero(np.diff(path.event, prepend=-1)).tolist()
    return list(zip(first, [*first[1:], len(path.event)], strict=True))


class PilotValve(Law):
    """Pilot-operated valve: what has got through opens it further, so that a step comes late and then fast, in an S.

    P.-F. Verhulst, Notice sur la loi que la population suit dans son accroissement, Correspondance mathématique et
    physique 10, 1838. The pilot always lets a little through.
    """

    effect = "delay"

    def __init__(self, setting: Setting) -> None:
        super().__init__(setting)
        random, count = setting.random, len(self.rig.chambers)
        self._pilot = np.exp(random.uniform(np.log(0.01), np.log(0.1)))
        self._tau_s = random.uniform(0.4, 0.8) * some(random, count, 0.85, 1.15, random.uniform(0.5, 1.0))

    def pressure(self, path: Path, kpa: Floats, strength: float) -> Floats:
        if strength <= 0:
            return kpa
        out, before = kpa.copy(), np.zeros(kpa.shape[1])
        tau_s = np.maximum(strength * self._tau_s, 1e-6)
        for first, end in _begins(path):
            rises = np.exp(-np.minimum(path.hold_s[first:end, None] / tau_s, 60.0))
            left = (1 + self._pilot) * rises / (self._pilot + rises)
            late = kpa[first:end] + (before - kpa[first:end]) * left
            out[first:end] = np.where(self._tau_s > 0, late, kpa[first:end])
            before = out[end - 1]
        return out


class GrowingVolume(Law):
    """Volume that grows: a bulging chamber takes the more air, the fuller it is, and so fills ever more slowly.

    S. Joshi, J. Paik, Pneumatic supply system parameter optimization for soft actuators, Soft Robotics 8, 2021.
    """

    effect = "delay"

    def __init__(self, setting: Setting) -> None:
        super().__init__(setting)
        random, count = setting.random, len(self.rig.chambers)
        self._tau_s = random.uniform(0.4, 0.8) * some(random, count, 0.8, 1.2, random.uniform(0.6, 1.0))
        self._grows = random.uniform(0.5, 2.0, count)

    def pressure(self, path: Path, kpa: Floats, strength: float) -> Floats:
        if strength <= 0:
            return kpa
        load, gone_s = full(self.rig, kpa), pauses(path)
        state, out = np.zeros(kpa.shape[1]), np.empty_like(load)
        for t, now in enumerate(load):
            for _ in range(3):
                slow = 1 + self._grows * np.minimum(np.abs(state), 2.0)
                state = now + (state - now) * np.exp(
                    -gone_s[t] / 3 / np.maximum(strength * self._tau_s * slow, 1e-6)
                )
            out[t] = state
        return np.where(self._tau_s > 0, out * self.rig.high_kpa, kpa)
