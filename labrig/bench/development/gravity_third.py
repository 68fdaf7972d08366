"""Gravity of the third portion: mass that is moved about, a mount on springs, weights at a tip, weights on a lever."""

import numpy as np

from labrig.arrays import Floats
from labrig.bench._nature import Law, Path, Setting
from labrig.bench.development._places import body_mm, down, long_axis, moved, pattern, positions, shift, span


class MovedMass(Law):
    """Moment of a body on a soft foot: what the chambers move out shifts its centre of mass, and so how far it leans.

    H. Goldstein, Classical Mechanics, 2nd ed., Addison-Wesley, 1980.
    """

    effect = "gravity"
    needs = frozenset({"markers", "tilt"})

    def __init__(self, setting: Setting) -> None:
        super().__init__(setting)
        assert self.rig.rest_mm is not None
        random, (centre, self._radius_mm) = setting.random, body_mm(self.rig)
        axis, along = long_axis(self.rig)
        end = random.choice([-1.0, 1.0])
        self._foot_mm = (
            centre + 0.8 * end * self._radius_mm * axis + random.normal(0, 0.2, 3) * self._radius_mm
        )
        mass = random.dirichlet(np.full(len(along), 2.0))
        self._mass = mass * (0.3 + np.abs(along - (end > 0)))
        self._mass /= self._mass.sum()
        self._leans = span(self.rig) / self._radius_mm * random.uniform(0.15, 0.4)

    def seen(self, path: Path, deflection: Floats, values: Floats, strength: float) -> Floats:
        points = positions(self.rig, values)
        centre = np.einsum("tmx,m->tx", points, self._mass)
        lean = (
            strength * self._leans * np.cross((centre - self._foot_mm) / self._radius_mm, down(path.tilt_deg))
        )
        return moved(
            self.rig, values, points + np.asarray(np.cross(lean[:, None], points - self._foot_mm), float)
        )


class SpringMount(Law):
    """Mount on unlike springs: the whole body is carried off by their compliance, and not straight down.

    W. T. Thomson, Theory of Vibration with Applications, 3rd ed., Prentice Hall, 1988.
    """

    effect = "gravity"
    needs = frozenset({"markers", "tilt"})

    def __init__(self, setting: Setting) -> None:
        super().__init__(setting)
        random = setting.random
        axes = np.linalg.qr(random.normal(size=(3, 3)))[0]
        soft = span(self.rig) * random.uniform(0.05, 0.3, 3)
        self._soft = (axes * soft) @ axes.T  # mm for a weight along each direction

    def seen(self, path: Path, deflection: Floats, values: Floats, strength: float) -> Floats:
        return values + strength * shift(self.rig, down(path.tilt_deg) @ self._soft)


class WeightAtTip(Law):
    """Cantilever with a weight at its tip: it sags by (3 - x) x^2 / 2, less along its axis, stiffer under pressure.

    J. P. Den Hartog, Strength of Materials, McGraw-Hill, 1949.
    """

    effect = "gravity"
    needs = frozenset({"markers", "payload"})

    def __init__(self, setting: Setting) -> None:
        super().__init__(setting)
        random = setting.random
        self._axis, along = long_axis(self.rig)
        along = along if random.random() < 0.5 else 1 - along
        self._sags = 0.5 * (3 - along) * along**2
        most_kg = max(float(setting.path.payload_kg.max()), 0.01)
        self._mm_per_kg = span(self.rig) * random.uniform(0.15, 0.45) / most_kg
        self._stiffer = random.uniform(0.0, 1.0)

    def seen(self, path: Path, deflection: Floats, values: Floats, strength: float) -> Floats:
        pull = path.payload_kg[:, None] * down(path.tilt_deg)
        across = pull - 0.8 * (pull @ self._axis)[:, None] * self._axis
        soft = 1 / (1 + self._stiffer * np.abs(deflection).mean(axis=1))
        sag = strength * self._mm_per_kg * (soft[:, None] * across)[:, None] * self._sags[:, None]
        return moved(self.rig, values, positions(self.rig, values) + sag)


class WeightOnLever(Law):
    """Weight on a lever: its moment goes with the cosine of the lever's angle, so with how far the body has turned.

    Archimedes, On the Equilibrium of Planes, after T. L. Heath, The Works of Archimedes, Cambridge, 1897.
    """

    effect = "gravity"
    needs = frozenset({"payload"})

    def __init__(self, setting: Setting) -> None:
        super().__init__(setting)
        random = setting.random
        self._way = pattern(self.rig)
        self._full = span(self.rig) * np.sqrt(len(self.rig.observables))
        self._level_rad, self._turns_rad = (
            np.deg2rad(random.uniform(-40, 10)),
            np.deg2rad(random.uniform(30, 80)),
        )
        most_kg = max(float(setting.path.payload_kg.max()), 0.01)
        self._per_kg = random.uniform(0.12, 0.35) * self._full / most_kg

    def seen(self, path: Path, deflection: Floats, values: Floats, strength: float) -> Floats:
        along = (values - self.rig.at_rest) @ self._way / self._full
        lever = np.cos(self._level_rad + self._turns_rad * np.clip(along, -1.5, 1.5))
        back = path.payload_kg * lever * np.cos(np.deg2rad(path.tilt_deg))
        return values - strength * self._per_kg * back[:, None] * self._way
