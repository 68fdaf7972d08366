"""Bases that are wrong in form: right in general, off by a little nearly everywhere."""

from collections.abc import Callable

import numpy as np

from labrig.arrays import Floats
from labrig.bench._nature import Rig
from labrig.bench.development._places import body_mm, columns, moved, positions

_Base = Callable[[Floats, float], Floats]


def another_wall(rig: Rig, random: np.random.Generator) -> _Base:
    """Another law of the walls: right at rest and at full pressure, bent otherwise in between, by chamber."""
    bend = random.uniform(0.6, 2.0) * random.uniform(0.7, 1.3, len(rig.chambers))
    softens = random.random() < 0.5

    def base(kpa: Floats, wrong: float) -> Floats:
        wall = rig.deflection(kpa)
        size = np.abs(wall)
        other = wall * (1 + bend) / (1 + bend * size) if softens else wall * (1 + bend * size) / (1 + bend)
        return rig.shape(wall + wrong * (other - wall))

    return base


def other_places(rig: Rig, random: np.random.Generator) -> _Base:
    """Patches and leverages elsewhere: markers move as others beside them do; a single force has another lever."""
    lever = random.uniform(-0.5, 0.5, len(rig.chambers)) + 0.5 * random.choice([-1.0, 1.0])
    mixed = _beside(rig, random) if columns(rig).max(initial=-1) >= 0 else None

    def base(kpa: Floats, wrong: float) -> Floats:
        wall = rig.deflection(kpa)
        values = rig.shape(wall)
        if mixed is None:
            return values + wrong * (rig.shape(wall * (1 + lever * wall)) - values)
        points = positions(rig, values)
        way = points - positions(rig, rig.at_rest[None])
        elsewhere = np.einsum("mn,tnx->tmx", mixed, way)
        return moved(rig, values, points + wrong * (elsewhere - way))

    return base


def _beside(rig: Rig, random: np.random.Generator) -> Floats:
    """Weights (M, M): whose motion each marker has in a model whose patches are elsewhere."""
    assert rig.rest_mm is not None
    radius = body_mm(rig)[1]
    aside_mm = 0.3 * radius * random.normal(size=rig.rest_mm.shape) / np.sqrt(
        3
    ) + 0.25 * radius * random.normal(size=3)
    place = rig.rest_mm + aside_mm
    distance = np.linalg.norm(place[:, None] - rig.rest_mm[None], axis=2)
    weight = np.exp(-0.5 * (distance / (0.4 * radius)) ** 2) + 1e-12
    return weight / weight.sum(axis=1, keepdims=True)
