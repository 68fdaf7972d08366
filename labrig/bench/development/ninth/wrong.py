"""Wrong bases of the ninth portion: chambers added up, a polynomial too low, a wrong ratio of stiffness."""

from collections.abc import Callable

import numpy as np

from labrig.arrays import Floats
from labrig.bench._nature import Rig
from labrig.bench.development._places import long_axis

_Base = Callable[[Floats, float], Floats]


def added_up(rig: Rig, random: np.random.Generator) -> _Base:
    """Added up: each chamber was measured alone, at a few pressures, and the effects are added."""
    count, steps = len(rig.chambers), int(random.integers(3, 5))
    tables: list[tuple[Floats, Floats]] = []
    for c in range(count):
        at = np.union1d([rig.low_kpa[c], 0.0], np.linspace(0.0, rig.high_kpa[c], steps))
        kpa = np.zeros((len(at), count))
        kpa[:, c] = at
        effect = rig.settled(kpa) - rig.at_rest
        ends = effect[:1] + effect[:1] - effect[1:2], effect[-1:] + effect[-1:] - effect[-2:-1]
        beyond = np.concatenate([2 * at[:1] - at[1:2], at, 2 * at[-1:] - at[-2:-1]])
        tables.append((beyond, np.concatenate([ends[0], effect, ends[1]])))

    def base(kpa: Floats, wrong: float) -> Floats:
        total = np.broadcast_to(rig.at_rest, (len(kpa), len(rig.at_rest))).copy()
        for c, (at, effect) in enumerate(tables):
            for k in range(effect.shape[1]):
                total[:, k] += np.interp(kpa[:, c], at, effect[:, k])
        values = rig.settled(kpa)
        return values + wrong * (total - values)

    return base


def low_polynomial(rig: Rig, random: np.random.Generator) -> _Base:
    """A polynomial of too low degree: fitted by least squares all over the range, of degree 2 or even 1."""
    count = len(rig.chambers)
    one, other = np.triu_indices(count)
    low, high = rig.low_kpa, rig.high_kpa

    def terms(kpa: Floats, degree: int) -> Floats:
        load = np.clip(kpa, low - 0.3 * high, 1.3 * high) / high
        first = np.column_stack([np.ones(len(load)), load])
        return first if degree == 1 else np.column_stack([first, load[:, one] * load[:, other]])

    tried = random.uniform(low, high, (40 + 6 * len(one), count))
    tried[random.random(tried.shape) < 0.3] = 0.0  # chambers that were left vented
    told = rig.settled(tried)

    def fitted(degree: int) -> Floats:
        return np.asarray(np.linalg.lstsq(terms(tried, degree), told, rcond=None)[0], dtype=float)

    def misses(degree: int) -> float:
        off = terms(tried, degree) @ fitted(degree) - told
        return float(np.sqrt(np.mean(off**2) / np.mean((told - rig.at_rest) ** 2)))

    degree = 2 if misses(2) > 0.04 else 1  # the highest that is too low
    fit = fitted(degree)

    def base(kpa: Floats, wrong: float) -> Floats:
        values = rig.settled(kpa)
        return values + wrong * (terms(kpa, degree) @ fit - values)

    return base


def stiffness_ratio(rig: Rig, random: np.random.Generator) -> _Base:
    """A wrong ratio of stiffness: one end of the body is taken for too soft and the other for too hard.

    The ratio was found at full pressure, where it is right; the parts stiffen differently, and it is off
    below.
    """
    count = len(rig.observables)
    part = np.linspace(-1.0, 1.0, count) if count > 1 else np.ones(1)
    if rig.rest_mm is not None:
        place = long_axis(rig)[1]
        part = np.tanh(3 * (place - random.uniform(0.35, 0.65)))[[o.marker for o in rig.observables]]
    ratio = random.uniform(0.3, 0.6) * random.choice([-1.0, 1.0]) * part

    def base(kpa: Floats, wrong: float) -> Floats:
        values = rig.settled(kpa)
        reached = np.sqrt(np.max(rig.deflection(kpa) ** 2, axis=1, keepdims=True))
        return values + wrong * ratio * np.exp(-2.0 * reached**2) * (values - rig.at_rest)

    return base
