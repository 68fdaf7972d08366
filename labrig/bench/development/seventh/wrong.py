"""Wrong bases of the seventh portion: walls that were fitted with a wave too many, and ways that are bent."""

from collections.abc import Callable

import numpy as np

from labrig.arrays import Floats
from labrig.bench._nature import Rig
from labrig.bench.development._places import columns, moved, positions, span

_Base = Callable[[Floats, float], Floats]


def wavy_wall(rig: Rig, random: np.random.Generator) -> _Base:
    """Walls with a wave: right at rest and at full deflection, too far out and too little in turn in between."""
    count = len(rig.chambers)
    waves = np.pi * random.integers(2, 4, count)
    size = random.uniform(0.05, 0.12, count) * random.choice([-1.0, 1.0], count)

    def base(kpa: Floats, wrong: float) -> Floats:
        wall = rig.deflection(kpa)
        return rig.shape(wall + wrong * size * np.sin(waves * np.clip(wall, -1.0, 1.0)))

    return base


def bent_ways(rig: Rig, random: np.random.Generator) -> _Base:
    """Ways that are bent: the further a place goes the more it turns aside; a number that is no marker's levels off."""
    markers = columns(rig).max(initial=-1) >= 0
    turn = random.normal(size=3)
    turn = turn / np.linalg.norm(turn)
    own = random.uniform(0.5, 1.0, len(rig.marker_names)) * random.choice([-1.0, 1.0])
    level = random.uniform(0.5, 1.0, len(rig.observables))

    def base(kpa: Floats, wrong: float) -> Floats:
        values = rig.settled(kpa)
        way = values - rig.at_rest
        far = 2 * span(rig)
        if not markers:
            return values + wrong * level * (far * np.tanh(way / far) - way)
        points = positions(rig, values)
        gone = points - positions(rig, rig.at_rest[None])
        size = np.tanh(np.linalg.norm(gone, axis=2) / far) * own
        aside = np.cross(turn, gone)
        return moved(rig, values, points + wrong * 0.3 * size[..., None] * aside)

    return base
