"""Bases that are wrong in form: what a model leaves out or takes to be otherwise."""

from collections.abc import Callable

import numpy as np

from labrig.arrays import Floats
from labrig.bench._nature import Rig
from labrig.bench.exam.tools import seats

Base = Callable[[Floats, float], Floats]


def without_cross_curvature(rig: Rig, random: np.random.Generator) -> Base:
    """A base that adds up what each chamber does alone, and knows no other joint effect."""
    loss = random.uniform(0.8, 1.2)

    def base(kpa: Floats, how_wrong: float) -> Floats:
        exact = rig.settled(kpa)
        if how_wrong == 0:
            return exact
        alone = rig.at_rest * (1 - len(rig.chambers))
        for one in np.eye(len(rig.chambers)):
            alone = alone + rig.settled(kpa * one)
        return exact + how_wrong * loss * (alone - exact)

    return base


def wrong_lever_arm(rig: Rig, random: np.random.Generator) -> Base:
    """A base in which the chambers act a little beside where they do: each does some of what its neighbours do."""
    seat = seats(rig)
    count = len(seat)
    away = np.linalg.norm(seat[:, None] - seat[None], axis=2)
    mix = np.exp(-away / (away.mean() + 1e-6)) * random.uniform(-0.12, 0.12, (count, count))
    bend = random.uniform(0.1, 0.3, count)

    def base(kpa: Floats, how_wrong: float) -> Floats:
        wall = rig.deflection(np.asarray(kpa, dtype=float))
        return rig.shape(wall + how_wrong * (wall * (1 + bend * wall)) @ mix)

    return base


def saturating_wall(rig: Rig, random: np.random.Generator) -> Base:
    """A base whose walls give way along a saturating line, right at both ends and wrong in between."""
    curve = random.uniform(0.8, 2.5, len(rig.chambers))
    high = rig.deflection(rig.high_kpa[None])[0]

    def base(kpa: Floats, how_wrong: float) -> Floats:
        wall = rig.deflection(np.asarray(kpa, dtype=float))
        load = np.maximum(np.asarray(kpa, dtype=float) / rig.high_kpa, 0.0)
        other = high * load * (1 + curve) / (1 + curve * load)
        return rig.shape(wall + how_wrong * (other - wall))

    return base
