"""Delay of the eighth portion: one pole, a dead time and a pole, long hoses, a tracker's filter, small exhausts."""

import numpy as np

from labrig.arrays import Floats
from labrig.bench._nature import Law, Path, Setting
from labrig.bench.development._places import some, span
from labrig.bench.development._story import lagged, pauses

_ROOM_KPA = 101.3


def _before(path: Path, drive: Floats, dead_s: Floats) -> Floats:
    """The drive (T, C) as it was `dead_s` (C,) ago; zero before the campaign."""
    out = np.empty_like(drive)
    for c, dead in enumerate(dead_s):
        out[:, c] = np.interp(path.time_s - dead, path.time_s, drive[:, c], left=0.0)
    return out


class OnePole(Law):
    """One pole: each chamber follows its command exponentially, with a time constant of its own.

    K. Ogata, Modern Control Engineering, Prentice Hall, 1970.
    """

    effect = "delay"

    def __init__(self, setting: Setting) -> None:
        super().__init__(setting)
        random = setting.random
        self._tau_s = random.uniform(0.7, 1.3) * random.uniform(0.85, 1.15, len(self.rig.chambers))

    def pressure(self, path: Path, kpa: Floats, strength: float) -> Floats:
        return lagged(path, kpa, strength * self._tau_s[None])[:, 0]


class DeadTimeAndPole(Law):
    """Dead time and a pole: for a while after a command nothing happens, then the body follows exponentially.

    J. G. Ziegler, N. B. Nichols, Optimum settings for automatic controllers, Transactions of the ASME 64, 1942. The
    plant is the same for all chambers.
    """

    effect = "delay"

    def __init__(self, setting: Setting) -> None:
        super().__init__(setting)
        random = setting.random
        self._dead_s, self._tau_s = random.uniform(0.3, 0.8), random.uniform(0.5, 0.9)

    def wall(self, path: Path, kpa: Floats, deflection: Floats, strength: float) -> Floats:
        count = deflection.shape[1]
        late = _before(path, deflection, np.full(count, strength * self._dead_s))
        return lagged(path, late, np.full((1, count), strength * self._tau_s))[:, 0]


class LongHoses(Law):
    """Long hoses: some chambers hang on metres of thin hose, which pass less air the longer and thinner they are.

    E. Richer, Y. Hurmuzlu, A high performance pneumatic force actuator system, part I: nonlinear mathematical model,
    ASME J. Dynamic Systems, Measurement, and Control 122, 2000. Laminar flow of a gas goes with the difference of the
    squared pressures, so that chambers fill faster than they empty; the wave takes its time too.
    """

    effect = "delay"

    def __init__(self, setting: Setting) -> None:
        super().__init__(setting)
        random, count = setting.random, len(self.rig.chambers)
        long_m, wide_m = some(random, count, 10.0, 18.0, 0.7), random.uniform(1.5e-3, 1.7e-3)
        volume_m3 = random.uniform(0.8e-4, 1.4e-4) * random.uniform(0.9, 1.1, count)
        resists = 128 * 1.82e-5 * long_m / (np.pi * wide_m**4)  # Pa s/m3
        self._tau_s = resists * volume_m3 / (1e3 * _ROOM_KPA)
        self._wave_s = long_m / 340

    def pressure(self, path: Path, kpa: Floats, strength: float) -> Floats:
        supply = np.maximum(_before(path, kpa, strength * self._wave_s) + _ROOM_KPA, 5.0)
        tau_s = np.maximum(strength * self._tau_s, 1e-9)
        pause_s = pauses(path)
        state = np.full(kpa.shape[1], _ROOM_KPA)
        out = np.empty_like(kpa)
        for i, now in enumerate(supply):
            rate = (now + state) / (2 * _ROOM_KPA * tau_s)
            state = state - (now - state) * np.expm1(-pause_s[i] * rate)
            out[i] = state - _ROOM_KPA
        return np.where(tau_s > 1e-9, out, kpa)


class OneEuroFilter(Law):
    """One euro filter: the tracker smooths what it sees, the more the slower it moves, so that slow ends come late.

    G. Casiez, N. Roussel, D. Vogel, 1 € filter: a simple speed-based low-pass filter for noisy input in interactive
    systems, Proc. CHI, 2012. The cutoff is a least one, and more in proportion to the speed.
    """

    effect = "delay"

    def __init__(self, setting: Setting) -> None:
        super().__init__(setting)
        random = setting.random
        self._least_hz = random.uniform(0.09, 0.14)
        self._more = random.uniform(0.02, 0.1) / span(self.rig)  # per unit of the observables
        self._speed_hz = 1.0

    def seen(self, path: Path, deflection: Floats, values: Floats, strength: float) -> Floats:
        state, before, speed = self.rig.at_rest.copy(), self.rig.at_rest, np.zeros(values.shape[1])
        out = np.empty_like(values)
        for i, pause in enumerate(pauses(path)):
            if pause > 0:
                share = -np.expm1(-2 * np.pi * self._speed_hz * pause)
                speed = speed + share * ((values[i] - before) / pause - speed)
            cutoff_hz = self._least_hz + self._more * np.abs(speed)
            state = state - (values[i] - state) * np.expm1(
                -2 * np.pi * cutoff_hz * pause / max(strength, 1e-9)
            )
            before = values[i]
            out[i] = state
        return out if strength > 0 else values


class SmallExhaust(Law):
    """Small exhaust: chambers fill through a wide valve but empty through a narrow one with a clogged silencer.

    P. Beater, Pneumatic Drives: System Design, Modelling and Control, Springer, 2007. Each silencer is clogged more or
    less.
    """

    effect = "delay"

    def __init__(self, setting: Setting) -> None:
        super().__init__(setting)
        random, count = setting.random, len(self.rig.chambers)
        self._out_s = random.uniform(0.7, 1.6, count)
        self._in_s = random.uniform(0.05, 0.2)

    def pressure(self, path: Path, kpa: Floats, strength: float) -> Floats:
        pause_s = pauses(path)
        state = np.zeros(kpa.shape[1])
        out = np.empty_like(kpa)
        for i, now in enumerate(kpa):
            tau_s = strength * np.where(np.abs(now) < np.abs(state), self._out_s, self._in_s)
            state = state - (now - state) * np.expm1(-pause_s[i] / np.maximum(tau_s, 1e-9))
            out[i] = state
        return out if strength > 0 else kpa
