"""Rest shapes of the tenth portion: a body that leans, and creases from its box that pressure irons out."""

import numpy as np

from labrig.arrays import Floats
from labrig.bench._nature import Law, Path, Setting
from labrig.bench.development._places import body_mm, direction, long_axis, span, spread

_MARKERS = frozenset({"markers"})


class Leans(Law):
    """Lean: the mould was cast askew, and the further a place is from the foot the more it is off, in proportion.

    A. E. H. Love, A Treatise on the Mathematical Theory of Elasticity, Cambridge University Press, 1892, on simple
    shear. Sections stay parallel to each other, and each is shifted along itself.
    """

    effect = "rest_shape"
    needs = _MARKERS

    def __init__(self, setting: Setting) -> None:
        super().__init__(setting)
        random = setting.random
        axis, along = long_axis(self.rig)
        if random.random() < 0.5:
            along = 1 - along
        way = direction(random)
        way = way - (way @ axis) * axis
        far_mm = random.uniform(0.2, 0.4) * span(self.rig) * np.sqrt(3.0)
        self._off = spread(self.rig, far_mm * along[:, None] * way / np.linalg.norm(way))

    def seen(self, path: Path, deflection: Floats, values: Floats, strength: float) -> Floats:
        return values + strength * self._off


class CreasesIronedOut(Law):
    """Creases: empty, the skin still has the folds of its box, and each fold flattens as the air in it pulls it flat.

    F. Lechenault, B. Thiria, M. Adda-Bedia, Mechanical response of a creased sheet, Physical Review Letters 112, 2014:
    a crease is a hinge with an angle of its own, against the pull of the sheet. What is left of it is one over one
    plus the load of its surroundings, squared.
    """

    effect = "rest_shape"
    needs = _MARKERS

    def __init__(self, setting: Setting) -> None:
        super().__init__(setting)
        random, rig = setting.random, self.rig
        assert rig.rest_mm is not None
        centre, radius_mm = body_mm(rig)
        folds = int(random.integers(1, 4))
        field = np.zeros_like(rig.rest_mm)
        for _ in range(folds):
            across, out = direction(random), direction(random)
            on = centre + random.normal(0, 0.4, 3) * radius_mm
            beside = np.abs((rig.rest_mm - on) @ across) / (random.uniform(0.4, 0.8) * radius_mm)
            field += random.choice([-1.0, 1.0]) * np.exp(-beside)[:, None] * out  # a sharp ridge
        field *= random.uniform(0.2, 0.4) * span(rig) / np.sqrt(np.mean(field**2))
        self._off = spread(rig, field)
        self._flat_at = random.uniform(0.2, 0.6)
        self._pulls = random.dirichlet(np.full(len(rig.chambers), 5.0))

    def seen(self, path: Path, deflection: Floats, values: Floats, strength: float) -> Floats:
        load = np.maximum(deflection, 0.0) @ self._pulls
        left = 1 / (1 + load / self._flat_at) ** 2
        return values + strength * left[:, None] * self._off
