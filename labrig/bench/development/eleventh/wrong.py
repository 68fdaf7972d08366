"""Wrong bases of the eleventh portion: small rotations, a coarse table, assumed shapes, straight on beyond what was
tried.
"""

from collections.abc import Callable
from itertools import combinations_with_replacement

import numpy as np

from labrig.arrays import Floats
from labrig.bench._nature import Rig, WrongForm

_Base = Callable[[Floats, float], Floats]


def _towards(rig: Rig, model: Callable[[Floats], Floats]) -> _Base:
    """A base that goes from the rig to a model of it, which was made to begin where the rig rests."""
    off = model(np.zeros((1, len(rig.chambers)))) - rig.at_rest

    def base(kpa: Floats, wrong: float) -> Floats:
        kpa = np.asarray(kpa, dtype=float)
        values = rig.settled(kpa)
        return values + wrong * (model(kpa) - off - values)

    return base


def small_rotations(rig: Rig, random: np.random.Generator) -> _Base:
    """Small rotations: a geometrically linear analysis, in which every place goes straight on as it set out.

    K.-J. Bathe, Finite Element Procedures, Prentice Hall, 1996, chapter 6. Arcs become tangents, and what the chambers
    do is added up; how far the walls give way is right. Where places go straight anyway, the walls are linear too.
    """
    step = random.uniform(0.01, 0.05)
    each = step * np.eye(len(rig.chambers))
    way = (rig.shape(each) - rig.shape(-each)) / (2 * step)
    wall = random.uniform(0.0, 1.0, (40, len(rig.chambers)))
    straight = rig.at_rest + wall @ way
    true = rig.shape(wall)
    if np.mean((straight - true) ** 2) > 1e-4 * np.mean((true - rig.at_rest) ** 2):
        return _towards(rig, lambda kpa: rig.at_rest + rig.deflection(kpa) @ way)
    little = step * np.diag(rig.high_kpa)
    gives = np.linalg.solve(2 * little, rig.deflection(little) - rig.deflection(-little))
    return _towards(rig, lambda kpa: rig.at_rest + kpa @ gives @ way)


def coarse_table(rig: Rig, random: np.random.Generator) -> _Base:
    """Coarse table: poses were computed on a grid of few pressures in every combination, and it is linear in between.

    H. W. Kuhn, Some combinatorial lemmas in topology, IBM Journal of Research and Development 4, 1960: each cell is cut
    into simplices, and the corners of the one that holds the point are weighted.
    """
    count = len(rig.chambers)
    levels = int(random.integers(3, 5) if count <= 4 else random.integers(2, 4))
    even = np.linspace(0.0, 1.0, levels)
    level = np.sort(even + np.where((even > 0) & (even < 1), random.uniform(-0.1, 0.1, levels), 0.0))
    place = levels ** np.arange(count)

    def table(kpa: Floats) -> Floats:
        share = (kpa - rig.low_kpa) / (rig.high_kpa - rig.low_kpa)
        cell = np.clip(np.searchsorted(level, share, side="right") - 1, 0, levels - 2)
        part = (share - level[cell]) / (level[cell + 1] - level[cell])
        order = np.argsort(-part, axis=1)
        falls = np.take_along_axis(part, order, axis=1)
        ones = np.ones((len(kpa), 1))
        weight = np.concatenate([ones, falls], axis=1) - np.concatenate([falls, 0 * ones], axis=1)
        corner = np.cumsum(np.concatenate([(cell @ place)[:, None], place[order]], axis=1), axis=1)
        known, of = np.unique(corner, return_inverse=True)
        at = level[known[:, None] // place % levels]
        told = rig.settled(rig.low_kpa + at * (rig.high_kpa - rig.low_kpa))
        out = np.zeros((len(kpa), told.shape[1]))
        for i, each in enumerate(of.reshape(corner.shape).T):
            out += weight[:, i, None] * told[each]
        return out

    return _towards(rig, table)


def assumed_shapes(rig: Rig, random: np.random.Generator) -> _Base:
    """Assumed shapes: how far places go is a polynomial of where they are, of so low a degree that corners get lost.

    W. Ritz, Über eine neue Methode zur Lösung gewisser Variationsprobleme der mathematischen Physik, J. reine und
    angewandte Mathematik 135, 1909. Numbers that are no markers' are ordered along a line. Where there are too few of
    them to tell, it is their curves over the mean load that are taken for parabolas.
    """
    count = len(rig.observables)
    keeps, kept = np.eye(count), random.uniform(0.25, 0.6)
    if rig.rest_mm is None and count < 4:
        groups, own = [], []
    elif rig.rest_mm is None:
        groups, own = [np.arange(count)], [np.linspace(-1.0, 1.0, count)[:, None]]
    else:
        arms = rig.rest_mm - rig.rest_mm.mean(axis=0)
        _, size, axes = np.linalg.svd(arms, full_matrices=False)
        axes = axes[size > 0.15 * size[0]]
        place = arms @ axes.T / (size[0] / np.sqrt(len(arms)))
        groups = [np.array([k for k, o in enumerate(rig.observables) if o.axis == axis]) for axis in range(3)]
        groups = [group for group in groups if len(group)]
        own = [place[[rig.observables[k].marker for k in group]] for group in groups]
    for group, where in zip(groups, own, strict=True):
        terms = _polynomial(where, max(int(kept * len(group)), 1), random)
        keeps[np.ix_(group, group)] = terms @ np.linalg.pinv(terms)
    kpa = random.uniform(rig.low_kpa, rig.high_kpa, (60, len(rig.chambers)))
    gone = rig.settled(kpa) - rig.at_rest
    if np.mean((gone - gone @ keeps.T) ** 2) > 1e-4 * np.mean(gone**2):
        return _towards(rig, lambda kpa: rig.at_rest + (rig.settled(kpa) - rig.at_rest) @ keeps.T)

    def loads(kpa: Floats) -> Floats:
        mean = np.mean(kpa / rig.high_kpa, axis=1, keepdims=True)
        return np.concatenate([mean, mean**2], axis=1)

    fit = np.linalg.lstsq(loads(kpa), gone, rcond=None)[0]
    return _towards(rig, lambda kpa: rig.at_rest + loads(kpa) @ fit)


def _polynomial(place: Floats, most: int, random: np.random.Generator) -> Floats:
    """The first terms (N, P) of a polynomial of places (N, D), not more than `most`; those of one degree by chance."""
    terms = [np.ones(len(place))]
    for degree in range(1, 4):
        every = list(combinations_with_replacement(range(place.shape[1]), degree))
        terms += [np.prod(place[:, list(every[i])], axis=1) for i in random.permutation(len(every))]
    return np.stack(terms[:most], axis=1)


def straight_on_beyond(rig: Rig, random: np.random.Generator) -> _Base:
    """Straight on: it was tried up to a part of the pressures only, to spare the body, and goes straight on from there.

    N. R. Draper, H. Smith, Applied Regression Analysis, Wiley, 1966: a fit is good for the range that it was made in.
    Each chamber is taken back to what was tried; from there the last slope leads on.
    """
    tried = random.uniform(0.4, 0.65) * random.uniform(0.9, 1.1, len(rig.chambers))
    back = random.uniform(0.1, 0.3)

    def straight(kpa: Floats) -> Floats:
        inside = np.clip(kpa, tried * rig.low_kpa, tried * rig.high_kpa)
        there = rig.settled(inside)
        return there + (there - rig.settled(inside - back * (kpa - inside))) / back

    return _towards(rig, straight)


WRONG: dict[str, WrongForm] = {
    "small_rotations": small_rotations,
    "coarse_table": coarse_table,
    "assumed_shapes": assumed_shapes,
    "straight_on_beyond": straight_on_beyond,
}
