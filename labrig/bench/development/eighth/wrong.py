"""Wrong bases of the eighth portion: walls with another power of pressure, and products that are not there."""

from collections.abc import Callable

import numpy as np

from labrig.arrays import Floats
from labrig.bench._nature import Rig
from labrig.bench.development._places import alone

_Base = Callable[[Floats, float], Floats]


def other_power(rig: Rig, random: np.random.Generator) -> _Base:
    """Walls of another power: right at rest and at full pressure, but the curve between is too bent or too straight."""
    count = len(rig.chambers)
    power = random.uniform(0.2, 0.45) * random.uniform(0.8, 1.2, count) * random.choice([-1.0, 1.0])

    def base(kpa: Floats, wrong: float) -> Floats:
        wall = rig.deflection(kpa)
        return rig.shape(np.sign(wall) * np.abs(wall) ** np.exp(wrong * power))

    return base


def needless_products(rig: Rig, random: np.random.Generator) -> _Base:
    """Products that are not there: a fit with squares and products of the chambers, some of which found only chance."""
    count, each = len(rig.chambers), alone(rig)
    on = np.triu(random.random((count, count)) < 2 / (count + 1))
    own = np.eye(count) > 0
    squares = random.uniform(0.2, 0.5, count) * random.choice([-1.0, 1.0], count)
    size = np.where(own, squares, random.normal(0, 0.25, (count, count)) * on)
    mix = random.dirichlet(np.ones(count), count * count).reshape(count, count, count)
    way = np.einsum("cd,cde,ek->cdk", size, mix, each)

    def base(kpa: Floats, wrong: float) -> Floats:
        wall = np.clip(rig.deflection(kpa), -1.5, 1.5)
        values = rig.settled(kpa)
        products = (
            np.einsum("tc,td->tcd", wall, wall) - wall[:, :, None] * own
        )  # squares vanish at full pressure
        return values + wrong * np.einsum("tcd,cdk->tk", products, way)

    return base
