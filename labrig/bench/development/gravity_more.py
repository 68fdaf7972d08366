"""Further gravity: a cantilever, a hose that hangs from it, heavy markers, a filling, weights on a stiffening body."""

import numpy as np

from labrig.arrays import Floats
from labrig.bench._nature import Law, Path, Setting
from labrig.bench.development._places import (
    alone,
    body_mm,
    columns,
    compliance,
    down,
    long_axis,
    moved,
    pattern,
    positions,
    span,
)


class Cantilever(Law):
    """Cantilever under its own weight: clamped at one end it sags across its axis, and more where pressure softens it.

    J. M. Gere, B. J. Goodno, Mechanics of Materials, 7th ed., Cengage, 2009.
    """

    effect = "gravity"
    needs = frozenset({"markers", "tilt"})

    def __init__(self, setting: Setting) -> None:
        super().__init__(setting)
        random = setting.random
        self._axis, along = long_axis(self.rig)
        along = along if random.random() < 0.5 else 1 - along
        self._sags = along**2 * (6 - 4 * along + along**2) / 3
        self._sag_mm = span(self.rig) * random.uniform(0.15, 0.5)
        self._softens = random.uniform(0.0, 0.8)

    def seen(self, path: Path, deflection: Floats, values: Floats, strength: float) -> Floats:
        pull = down(path.tilt_deg)
        across = pull - (pull @ self._axis)[:, None] * self._axis
        soft = 1 + self._softens * np.maximum(deflection, 0.0).mean(axis=1)
        sag = self._sag_mm * self._sags[:, None] * (soft[:, None] * across)[:, None]
        return moved(self.rig, values, positions(self.rig, values) + strength * sag)


class HangingHoses(Law):
    """Hanging hoses: their weight at one side turns the body about its foot, otherwise in each position of the base.

    H. M. Irvine, Cable Structures, MIT Press, 1981.
    """

    effect = "gravity"
    needs = frozenset({"markers", "tilt"})

    def __init__(self, setting: Setting) -> None:
        super().__init__(setting)
        assert self.rig.rest_mm is not None
        random = setting.random
        centre, radius = body_mm(self.rig)
        beside = random.normal(size=3)
        self._foot_mm = centre + radius * random.uniform(0.3, 1.0) * beside / np.linalg.norm(beside)
        self._arm_mm = self.rig.rest_mm - self._foot_mm
        lever = random.normal(size=3) + 0.5 * (centre - self._foot_mm) / radius
        self._lever = lever / np.linalg.norm(lever)
        self._turn = span(self.rig) / radius * random.uniform(0.1, 0.3)

    def seen(self, path: Path, deflection: Floats, values: Floats, strength: float) -> Floats:
        turn = self._turn * np.cross(self._lever, down(path.tilt_deg))
        points = positions(self.rig, values)
        return moved(self.rig, values, points + strength * np.cross(turn[:, None], self._arm_mm))


class MarkerWeights(Law):
    """Heavy markers: each has a weight of its own, and hangs down from the soft skin by as much.

    A. Cappozzo, F. Catani, A. Leardini et al., Position and orientation in space of bones during movement:
    experimental artefacts, Clinical Biomechanics 11, 1996.
    """

    effect = "gravity"
    needs = frozenset({"markers", "tilt"})

    def __init__(self, setting: Setting) -> None:
        super().__init__(setting)
        random = setting.random
        heavy = np.exp(random.normal(0, random.uniform(0.3, 0.8), len(self.rig.marker_names)))
        self._sag_mm = span(self.rig) * random.uniform(0.05, 0.15) * heavy * (0.2 + compliance(self.rig))

    def seen(self, path: Path, deflection: Floats, values: Floats, strength: float) -> Floats:
        sag = self._sag_mm[:, None] * down(path.tilt_deg)[:, None]
        return moved(self.rig, values, positions(self.rig, values) + strength * sag)


class HydrostaticHead(Law):
    """Hydrostatic head: a filling presses more on the chambers that lie lower, which changes as the base is turned.

    B. Pascal, Traités de l'équilibre des liqueurs, et de la pesanteur de la masse de l'air, Paris, 1663.
    """

    effect = "gravity"
    needs = frozenset({"markers", "several", "tilt"})

    def __init__(self, setting: Setting) -> None:
        super().__init__(setting)
        assert self.rig.rest_mm is not None
        random, where = setting.random, columns(self.rig)
        centre, radius = body_mm(self.rig)
        moves = np.sum(np.where(where >= 0, alone(self.rig)[:, where], 0.0) ** 2, axis=2)  # (C, M)
        place = moves @ (self.rig.rest_mm - centre) / moves.sum(axis=1, keepdims=True) / radius
        self._place = place + random.normal(0, 0.15, place.shape)
        self._head_kpa = random.uniform(0.03, 0.1) * float(np.mean(self.rig.high_kpa))

    def pressure(self, path: Path, kpa: Floats, strength: float) -> Floats:
        return kpa + strength * self._head_kpa * (down(path.tilt_deg) @ self._place.T)


class PayloadAgainstStiffness(Law):
    """Load on a muscle: what hangs on the body gives it way the less, the more pressure makes it stiff.

    C.-P. Chou, B. Hannaford, Measurement and modeling of McKibben pneumatic artificial muscles, IEEE Trans. Robotics
    and Automation 12, 1996.
    """

    effect = "gravity"
    needs = frozenset({"payload"})

    def __init__(self, setting: Setting) -> None:
        super().__init__(setting)
        random = setting.random
        most_kg = max(float(setting.path.payload_kg.max()), 0.01)
        way = span(self.rig) * np.sqrt(len(self.rig.observables)) * pattern(self.rig)
        self._per_kg = -random.uniform(0.15, 0.4) * way / most_kg
        self._stiffer = random.uniform(0.5, 3.0)

    def seen(self, path: Path, deflection: Floats, values: Floats, strength: float) -> Floats:
        gives = path.payload_kg / (1 + self._stiffer * np.maximum(deflection, 0.0).mean(axis=1))
        return values + strength * gives[:, None] * self._per_kg
