"""What the laws of the twelfth portion share: which sensors a rig has, and how far each of them goes."""

from collections.abc import Sequence

import numpy as np

from labrig.arrays import Floats, Ints
from labrig.bench._nature import Observable, Path, Rig, Setting


def noises(
    random: np.random.Generator, observables: Sequence[Observable], **between: tuple[float, float]
) -> tuple[float, Floats]:
    """The usual noise of a rig, and how many times as noisy each observable (K,) is, drawn for each unit `between` two
    values; `per_m` is 1/m.
    """
    each = {unit: random.uniform(*ends) for unit, ends in between.items()}
    own = np.array([each[o.unit.replace("1/", "per_")] for o in observables])
    noise = float(np.sqrt(np.mean(own**2)))
    return noise, own / noise


def usual(rig: Rig, path: Path) -> Floats:
    """How far each observable (K,) goes from rest on a path: root mean square over its rows, at least some noises."""
    gone = rig.settled(path.kpa[path.row]) - rig.at_rest
    return np.maximum(np.sqrt(np.mean(gone**2, axis=0)), 8.0 * rig.noise * rig.noisier)


def sensors(rig: Rig, *units: str) -> Ints:
    """The columns of all observables that are no marker's; of these units only, if any are named."""
    seen = enumerate(rig.observables)
    return np.array([k for k, o in seen if o.marker < 0 and (not units or o.unit in units)], dtype=np.int64)


def any_sensor(setting: Setting, *units: str) -> int:
    """The column of one sensor by chance; of these units only, if any are named."""
    return int(setting.random.choice(sensors(setting.rig, *units)))


def added(values: Floats, which: Ints | int, change: Floats) -> Floats:
    """The observables (T, K) with a change (T, N), or (T,), added to some of them."""
    out = values.copy()
    out[:, which] += change
    return out


def loaded(rig: Rig, deflection: Floats) -> Floats:
    """How much all chambers together push, whichever way (T,): about 1 when all are full."""
    return np.mean(np.abs(deflection), axis=1)
