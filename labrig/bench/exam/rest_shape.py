"""Rest shape: the unloaded body is not the one that was measured or drawn."""

from typing import ClassVar

import numpy as np

from labrig.arrays import Floats
from labrig.bench._nature import Law, Path, Setting
from labrig.bench.exam.tools import Body, chosen, unit


class SwellingPattern(Law):
    """Silicone that took up solvent or oil, more on one side: the body is larger there, and moves in proportion.

    P. J. Flory and J. Rehner, Journal of Chemical Physics, 1943.
    """

    effect: ClassVar[str] = "rest_shape"
    needs: ClassVar[frozenset[str]] = frozenset({"markers"})

    def __init__(self, setting: Setting) -> None:
        super().__init__(setting)
        random = setting.random
        self._body = body = Body(setting.rig)
        place = (body.rest - body.centre) / body.size
        lump = np.exp(-((place - random.normal(0, 0.7, 3)) ** 2).sum(axis=1))
        swollen = 0.3 + 0.4 * place @ unit(random) + random.uniform(0.5, 1.0) * lump
        self._swollen = random.uniform(0.01, 0.03) * swollen[:, None]
        warp = random.uniform(-1.0, 1.0, 3) * body.size * (place**2).sum(axis=1, keepdims=True)
        self._offset = self._swollen * (body.rest - body.clamp) + 0.3 * random.uniform(0.01, 0.03) * warp

    def seen(self, path: Path, deflection: Floats, values: Floats, strength: float) -> Floats:
        """The markers, off by the swelling of the body between the clamp and them."""
        moved = self._body.moved(values)
        return self._body.shifted(values, strength * (self._offset + self._swollen * moved))


class PermanentSet(Law):
    """Rubber that aged under load: some walls never quite return, and have so much less left to give.

    A. V. Tobolsky, I. B. Prettyman and J. H. Dillon, Journal of Applied Physics, 1944 (two networks).
    """

    effect: ClassVar[str] = "rest_shape"

    def __init__(self, setting: Setting) -> None:
        super().__init__(setting)
        random, count = setting.random, len(setting.rig.chambers)
        self._set = random.uniform(0.02, 0.08, count) * chosen(random, count, random.uniform(0.5, 1.0))
        self._left = random.uniform(0.0, 0.5)

    def wall(self, path: Path, kpa: Floats, deflection: Floats, strength: float) -> Floats:
        """The walls, already given way a little before any load."""
        return deflection + strength * self._set * (1 - self._left * deflection)
