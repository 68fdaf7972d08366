"""Gravity of the fourth portion: a skin that hangs through, a column that nearly falls over, a load off its centre."""

import numpy as np

from labrig.arrays import Floats
from labrig.bench._nature import Law, Path, Setting
from labrig.bench.development._places import body_mm, direction, down, long_axis, moved, positions, span
from labrig.bench.development.rigs._common import cubic_membrane


class HangingSkin(Law):
    """Elastic cable: held at both ends it hangs through as a parabola, and by the cube root of its weight across.

    H. M. Irvine, Cable Structures, MIT Press, 1981.
    """

    effect = "gravity"
    needs = frozenset({"markers", "tilt"})

    def __init__(self, setting: Setting) -> None:
        super().__init__(setting)
        random = setting.random
        self._axis, along = long_axis(self.rig)
        self._hangs = 4 * along * (1 - along)
        self._across = 1.0 - random.uniform(0.7, 1.0)  # how much of the weight along itself counts
        self._cubic = np.array([random.uniform(0.2, 0.8)])
        self._tighter = random.uniform(0.0, 1.0)  # under pressure
        self._sag_mm = span(self.rig) * random.uniform(0.15, 0.5)

    def seen(self, path: Path, deflection: Floats, values: Floats, strength: float) -> Floats:
        pull = down(path.tilt_deg)
        pull = pull - (1 - self._across) * (pull @ self._axis)[:, None] * self._axis
        weight = np.linalg.norm(pull, axis=1, keepdims=True)
        load = weight / (1 + self._tighter * np.abs(deflection).mean(axis=1, keepdims=True))
        sag = self._sag_mm * cubic_membrane(load, self._cubic) * pull / np.maximum(weight, 1e-9)
        change = strength * sag[:, None] * self._hangs[:, None]
        return moved(self.rig, values, positions(self.rig, values) + change)


class StandingColumn(Law):
    """Heavy column: standing its weight pushes it further over, hanging it pulls it straight; lying it does neither.

    A. G. Greenhill, Determination of the greatest height consistent with stability that a vertical pole or mast can be
    made, Proc. Cambridge Philosophical Society 4, 1881.
    """

    effect = "gravity"
    needs = frozenset({"tilt"})

    def __init__(self, setting: Setting) -> None:
        super().__init__(setting)
        random = setting.random
        self._near = random.choice([-1.0, 1.0]) * random.uniform(0.12, 0.35)  # of the weight that it bears
        self._leans_deg = random.uniform(-8, 8)

    def seen(self, path: Path, deflection: Floats, values: Floats, strength: float) -> Floats:
        stands = np.cos(np.deg2rad(path.tilt_deg + self._leans_deg))
        near = 0.75 * np.tanh(strength * self._near / 0.75) * stands
        return self.rig.at_rest + (values - self.rig.at_rest) / (1 - near)[:, None]


class OffCentreLoad(Law):
    """Load off the axis: its moment bends the body by the square of the length, and twists it in proportion to it.

    A. J. C. Barré de Saint-Venant, Mémoire sur la torsion des prismes, Mémoires des Savants étrangers 14, 1855.
    """

    effect = "gravity"
    needs = frozenset({"markers", "payload"})

    def __init__(self, setting: Setting) -> None:
        super().__init__(setting)
        random, (self._centre_mm, radius) = setting.random, body_mm(self.rig)
        self._axis, along = long_axis(self.rig)
        self._along = along if random.random() < 0.5 else 1 - along
        self._arm = direction(random)
        most_kg = max(float(setting.path.payload_kg.max()), 0.01)
        self._bends_mm = span(self.rig) * random.uniform(0.2, 0.5) / most_kg
        self._twists = span(self.rig) / radius * random.uniform(0.2, 0.6) / most_kg
        self._stiffer = random.uniform(0.0, 0.8)

    def seen(self, path: Path, deflection: Floats, values: Floats, strength: float) -> Floats:
        soft = strength / (1 + self._stiffer * np.abs(deflection).mean(axis=1))
        moment = (soft * path.payload_kg)[:, None] * np.asarray(
            np.cross(self._arm, down(path.tilt_deg)), float
        )
        twist = (moment @ self._axis)[:, None] * self._axis
        bends = self._bends_mm * np.asarray(np.cross(moment - twist, self._axis), float)
        points = positions(self.rig, values)
        turned = np.cross(self._twists * twist[:, None], points - self._centre_mm) * self._along[:, None]
        return moved(self.rig, values, points + bends[:, None] * self._along[:, None] ** 2 + turned)
