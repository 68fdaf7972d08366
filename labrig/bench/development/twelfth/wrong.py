"""Wrong bases of the twelfth portion: no interplay, Hooke's sensors, a response surface."""

from collections.abc import Callable

import numpy as np

from labrig.arrays import Floats
from labrig.bench._nature import Rig, WrongForm

_Base = Callable[[Floats, float], Floats]


def _towards(rig: Rig, model: Callable[[Floats], Floats]) -> _Base:
    """A base that goes from the rig to a model of it."""

    def base(kpa: Floats, wrong: float) -> Floats:
        kpa = np.asarray(kpa, dtype=float)
        values = rig.settled(kpa)
        return values + wrong * (model(kpa) - values)

    return base


def _draws(rig: Rig, random: np.random.Generator, count: int) -> Floats:
    return random.uniform(rig.low_kpa, rig.high_kpa, (count, len(rig.chambers)))


def no_interplay(rig: Rig, random: np.random.Generator) -> _Base:
    """No interplay: each chamber was tried alone, and what they do together was taken for the sum.

    G. E. P. Box, W. G. Hunter, J. S. Hunter, Statistics for Experimenters, Wiley, 1978: one factor at a time. Where
    chambers do not care for each other, or there is but one, it is a response surface.
    """
    kpa = _draws(rig, random, 60)

    def together(kpa: Floats) -> Floats:
        alone = [rig.settled(kpa * own) - rig.at_rest for own in np.eye(len(rig.chambers))]
        return rig.at_rest + np.sum(alone, axis=0)

    true = rig.settled(kpa)
    if np.mean((together(kpa) - true) ** 2) > 1e-4 * np.mean((true - rig.at_rest) ** 2):
        return _towards(rig, together)
    return response_surface(rig, random)


def hookes_sensors(rig: Rig, random: np.random.Generator) -> _Base:
    """Hooke's sensors: of some sensors nobody knows how they come about, and a straight line of the others must do.

    R. Hooke, De Potentia Restitutiva, 1678. A force is taken for a spring's, an angle for a lever's, whatever is met
    or levers by an arm that changes.
    """
    count = len(rig.observables)
    true = rig.settled(_draws(rig, random, 80))
    derived = np.sort(random.permutation(count)[: max(1, count // 2)])
    others = np.setdiff1d(np.arange(count), derived)
    if not len(others):
        return response_surface(rig, random)
    basis = np.column_stack([np.ones(len(true)), true[:, others]])
    fit = np.linalg.lstsq(basis, true[:, derived], rcond=None)[0]
    if np.mean((basis @ fit - true[:, derived]) ** 2) < 1e-4 * np.mean((true - rig.at_rest) ** 2):
        return response_surface(rig, random)

    def model(kpa: Floats) -> Floats:
        values = rig.settled(kpa)
        values[:, derived] = np.column_stack([np.ones(len(values)), values[:, others]]) @ fit
        return values

    return _towards(rig, model)


def response_surface(rig: Rig, random: np.random.Generator) -> _Base:
    """Response surface: a polynomial of second degree of all pressures, fitted to a few dozen poses.

    G. E. P. Box, K. B. Wilson, On the experimental attainment of optimum conditions, J. Royal Statistical Society B 13,
    1951.
    """
    count = len(rig.chambers)
    pairs = [(i, j) for i in range(count) for j in range(i, count)]

    def terms(kpa: Floats) -> Floats:
        load = kpa / rig.high_kpa
        return np.column_stack([np.ones(len(load)), load, *(load[:, i] * load[:, j] for i, j in pairs)])

    kpa = _draws(rig, random, int(random.integers(3, 6)) * (1 + count + len(pairs)))
    fit = np.linalg.lstsq(terms(kpa), rig.settled(kpa), rcond=None)[0]
    return _towards(rig, lambda kpa: terms(kpa) @ fit)


WRONG: dict[str, WrongForm] = {
    "no_interplay": no_interplay,
    "hookes_sensors": hookes_sensors,
    "response_surface": response_surface,
}
