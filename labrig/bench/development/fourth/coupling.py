"""Coupling of the fourth portion: skin that spans valleys, a muffler's back pressure, valves on one power supply."""

from itertools import combinations

import numpy as np

from labrig.arrays import Floats
from labrig.bench._nature import Law, Path, Setting
from labrig.bench.development._places import alone, columns, full, overlap, span, spread


class BridgedValley(Law):
    """Tension field: taut skin spans the valley between two bulges that are both out, as high as the lower one.

    D. J. Steigmann, Tension-field theory, Proc. Royal Society A 429, 1990.
    """

    effect = "coupling"
    needs = frozenset({"markers", "several"})

    def __init__(self, setting: Setting) -> None:
        super().__init__(setting)
        random, near, where = setting.random, overlap(self.rig), columns(self.rig)
        each = np.where(where >= 0, alone(self.rig)[:, where], 0.0)  # (C, M, 3)
        size = np.linalg.norm(each, axis=2)
        way = each / np.maximum(size, 1e-9)[..., None]
        pairs = [p for p in combinations(range(len(near)), 2) if near[p] >= 0.5 * near.max()]
        self._pairs = pairs
        lifts = []
        for one, other in pairs:
            valley = np.sqrt(size[one] * size[other])[:, None] * (way[one] + way[other])
            lifts.append(random.uniform(0.6, 1.4) * spread(self.rig, valley))
        most = max(float(np.sqrt(np.mean(np.square(lifts)))), 1e-9)
        self._lifts = span(self.rig) * random.uniform(0.1, 0.3) / most * np.array(lifts)

    def seen(self, path: Path, deflection: Floats, values: Floats, strength: float) -> Floats:
        out = np.maximum(deflection, 0.0)
        lower = np.stack([np.minimum(out[:, one], out[:, other]) for one, other in self._pairs], axis=1)
        return values + strength * lower @ self._lifts


class MufflerBackPressure(Law):
    """Common exhaust: what all bleed goes through one muffler, whose back pressure (flow squared) lifts each of them.

    B. W. Andersen, The Analysis and Design of Pneumatic Systems, Wiley, 1967.
    """

    effect = "coupling"
    needs = frozenset({"several"})

    def __init__(self, setting: Setting) -> None:
        super().__init__(setting)
        random, count = setting.random, len(self.rig.chambers)
        self._bleeds = _about_one(random, count) / count
        self._back = random.uniform(0.25, 0.7)
        self._opens = random.uniform(0.03, 0.12)

    def pressure(self, path: Path, kpa: Floats, strength: float) -> Floats:
        load = np.maximum(full(self.rig, kpa), 0.0)
        flow = load * self._bleeds
        others = flow.sum(axis=1, keepdims=True) ** 2 - flow**2
        open_ = load / (load + self._opens)  # a vented chamber's regulator is shut
        return kpa + strength * self._back * self.rig.high_kpa * others * open_


class SharedPowerSupply(Law):
    """Sagging voltage: solenoids draw current by the root of what they give, and pull by the square of what is left.

    H. C. Roters, Electromagnetic Devices, Wiley, 1941.
    """

    effect = "coupling"
    needs = frozenset({"several"})

    def __init__(self, setting: Setting) -> None:
        super().__init__(setting)
        random, count = setting.random, len(self.rig.chambers)
        self._draws = _about_one(random, count) / count * random.uniform(0.08, 0.25)

    def pressure(self, path: Path, kpa: Floats, strength: float) -> Floats:
        current = np.sqrt(np.abs(full(self.rig, kpa))) * self._draws
        others = current.sum(axis=1, keepdims=True) - current
        sags = 0.7 * np.tanh(strength * others / 0.7)
        return kpa * (1 - sags) ** 2


def _about_one(random: np.random.Generator, count: int) -> Floats:
    """How much of it each chamber (C,) has, about 1."""
    return random.uniform(0.5, 1.5, count)
