"""Leaks of the ninth portion: a capillary, an orifice, a permeated skin, a crack in all, and pinholes."""

from collections.abc import Callable

import numpy as np

from labrig.arrays import Floats
from labrig.bench._nature import Law, Path, Setting
from labrig.bench.development._places import columns, some
from labrig.bench.development._story import pauses

_AIR_KPA = 101.3
_OPEN_S, _FILLS_S = (
    0.6,
    0.12,
)  # how long valves open at an actuation, and their time constant


def _lost(path: Path, aim: Floats, rate: Callable[[int, Floats], Floats]) -> Floats:
    """What is missing (T, C) from what the valves let in, `aim`; `rate` (moment, what is there) is per s."""
    pause = pauses(path)
    gone = np.zeros(aim.shape[1])
    out = np.empty_like(aim)
    for i in range(len(aim)):
        since = path.hold_s[i]
        before = since - pause[i] if i and path.event[i] == path.event[i - 1] else 0.0
        opened = max(min(since, _OPEN_S) - before, 0.0)
        closed = max(since - max(before, _OPEN_S), 0.0)
        gone = gone * np.exp(-opened / _FILLS_S)
        there = aim[i] - gone
        gone = gone - there * np.expm1(-rate(i, there) * closed)
        out[i] = gone
    return out


class Capillary(Law):
    """A capillary, such as a scratch under a ferrule: laminar flow, by the difference of squares.

    K. Jousten (editor), Handbook of Vacuum Technology, Wiley-VCH, 2008, on Hagen's and Poiseuille's law for
    gases. All fittings leak, each as it was tightened.
    """

    effect = "leak"

    def __init__(self, setting: Setting) -> None:
        super().__init__(setting)
        random, count = setting.random, len(self.rig.chambers)
        self._per_s = random.uniform(0.002, 0.004) * random.lognormal(0.0, 0.5, count)  # at full pressure

    def pressure(self, path: Path, kpa: Floats, strength: float) -> Floats:
        most = self.rig.high_kpa + 2 * _AIR_KPA

        def rate(_: int, there: Floats) -> Floats:
            return strength * self._per_s * np.maximum(there + 2 * _AIR_KPA, 0.0) / most

        return kpa - _lost(path, kpa, rate)


class Orifice(Law):
    """An orifice, a hole in some of the chambers: compressible flow, choked at a high pressure ratio.

    ISO 6358-1, Pneumatic fluid power: determination of flow-rate characteristics of components, 2013: the
    flow is C p1 sqrt(1 - ((p2/p1 - b) / (1 - b))^2), and C p1 once p2/p1 is below b.
    """

    effect = "leak"

    def __init__(self, setting: Setting) -> None:
        super().__init__(setting)
        random, count = setting.random, len(self.rig.chambers)
        self._critical = random.uniform(0.2, 0.5)
        self._per_s = some(random, count, 0.003, 0.006, 0.7)  # at full pressure

    def _flow(self, there: Floats) -> Floats:
        inside = np.maximum(_AIR_KPA + there, 1.0)
        up, down = np.maximum(inside, _AIR_KPA), np.minimum(inside, _AIR_KPA)
        over = np.maximum(down / up - self._critical, 0.0) / (1 - self._critical)
        return up * np.sqrt(np.maximum(1 - over**2, 0.0))

    def pressure(self, path: Path, kpa: Floats, strength: float) -> Floats:
        high = self.rig.high_kpa
        size = strength * self._per_s * high / self._flow(high)

        def rate(_: int, there: Floats) -> Floats:
            return size * self._flow(there) / np.maximum(np.abs(there), 1e-3 * high)

        return kpa - _lost(path, kpa, rate)


class PermeatedSkin(Law):
    """A skin that air permeates: one skin over all chambers, wider and thinner as the body is blown up.

    G. J. van Amerongen, The permeability of different rubbers to gases and its relation to diffusivity and
    solubility, J. Applied Physics 17, 1946: the flow is P A dp / h; area A and thickness h go with the
    stretch of the whole skin, squared and inverse squared.
    """

    effect = "leak"

    def __init__(self, setting: Setting) -> None:
        super().__init__(setting)
        random, count = setting.random, len(self.rig.chambers)
        self._per_s = random.uniform(0.001, 0.002) * random.uniform(0.9, 1.1, count)  # unstretched
        self._stretch = random.uniform(0.1, 0.4)

    def pressure(self, path: Path, kpa: Floats, strength: float) -> Floats:
        blown = np.clip(np.abs(self.rig.deflection(kpa)).mean(axis=1), 0.0, 2.0)
        wider = (1 + self._stretch * blown) ** 4

        def rate(i: int, there: Floats) -> Floats:
            return strength * self._per_s * wider[i]

        return kpa - _lost(path, kpa, rate)


class CrackInTheWhole(Law):
    """A crack in the whole, with one supply for all: the shape sags as one, with a power of its filling.

    ASTM E779, Standard test method for determining air leakage rate by fan pressurization, 1981: the flow is
    C dp^n, with n from a half (turbulent) to one (laminar).
    """

    effect = "leak"

    def __init__(self, setting: Setting) -> None:
        super().__init__(setting)
        random = setting.random
        self._power = random.uniform(0.55, 0.9)
        self._per_s = random.uniform(0.002, 0.0035)

    def seen(self, path: Path, deflection: Floats, values: Floats, strength: float) -> Floats:
        held = np.abs(deflection).mean(axis=1, keepdims=True)

        def rate(_: int, there: Floats) -> Floats:
            return strength * self._per_s * np.maximum(there, 1e-3) ** (self._power - 1)

        share = np.clip(_lost(path, held, rate) / np.maximum(held, 1e-3), 0.0, 1.0)
        return values + share * (self.rig.at_rest - values)


class Pinholes(Law):
    """Pinholes at some places: the pocket under each lets its air out, and the place sinks back.

    P. O. Moore, C. N. Jackson, C. N. Sherlock (editors), Nondestructive Testing Handbook 1: Leak Testing,
    ASNT, 1998, on the decay of pressure. Other places, of other pockets, stay where they are.
    """

    effect = "leak"

    def __init__(self, setting: Setting) -> None:
        super().__init__(setting)
        random, rig = setting.random, self.rig
        share = random.uniform(0.4, 0.8)
        rates = some(random, len(rig.observables), 0.003, 0.007, share)
        if rig.marker_names:
            of = np.array([observable.marker for observable in rig.observables])
            by_marker = some(random, len(columns(rig)), 0.003, 0.007, share)
            rates = np.where(of >= 0, by_marker[of], rates)
        self._per_s = rates

    def seen(self, path: Path, deflection: Floats, values: Floats, strength: float) -> Floats:
        return values - _lost(path, values - self.rig.at_rest, lambda _, there: strength * self._per_s)
