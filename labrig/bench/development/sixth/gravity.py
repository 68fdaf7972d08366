"""Gravity of the sixth portion: a body on a soft foot, a beam on two supports, a loaded plate, a bath of water."""

import numpy as np
from scipy.spatial.transform import Rotation

from labrig.arrays import Floats
from labrig.bench._nature import Law, Path, Setting
from labrig.bench.development._places import body_mm, compliance, down, long_axis, moved, positions, span


class InvertedPendulum(Law):
    """Inverted pendulum: the body leans about its soft foot, and leans further since it leans.

    J. P. Den Hartog, Mechanical Vibrations, McGraw-Hill, 1934. It was modelled as it stands when its base is level.
    """

    effect = "gravity"
    needs = frozenset({"markers", "tilt"})

    def __init__(self, setting: Setting) -> None:
        super().__init__(setting)
        random, (centre, radius) = setting.random, body_mm(self.rig)
        self._foot_mm = centre - radius * random.uniform(0.8, 1.6) * np.array([0.0, 0.0, 1.0])
        self._foot_mm[1] += radius * random.uniform(-0.5, 0.5)
        self._soft = span(self.rig) / radius * random.uniform(0.05, 0.25)
        self._first_rad = random.uniform(-0.2, 0.2)  # where its mass is aside of the foot

    def seen(self, path: Path, deflection: Floats, values: Floats, strength: float) -> Floats:
        tilt, soft = np.deg2rad(path.tilt_deg), min(strength * self._soft, 0.9)
        lean = np.zeros_like(tilt)
        for _ in range(25):
            lean = soft * (np.sin(tilt + self._first_rad + lean) - np.sin(self._first_rad))
        turn = Rotation.from_rotvec(np.column_stack([lean, np.zeros((len(lean), 2))])).as_matrix()
        arm = positions(self.rig, values) - self._foot_mm
        return moved(self.rig, values, self._foot_mm + np.einsum("txy,tmy->tmx", turn, arm))


class OnTwoSupports(Law):
    """Beam on two supports: it sags between them and stands up beyond them, square to its length, by a quartic.

    J. Bernoulli and L. Euler's beam, after S. H. Crandall, N. C. Dahl, T. J. Lardner, An Introduction to the Mechanics
    of Solids, 2nd ed., McGraw-Hill, 1972. Pressure makes it stiffer.
    """

    effect = "gravity"
    needs = frozenset({"markers", "tilt"})

    def __init__(self, setting: Setting) -> None:
        super().__init__(setting)
        random = setting.random
        self._axis, along = long_axis(self.rig)
        first, last = random.uniform(-0.1, 0.15), random.uniform(0.85, 1.1)
        x = (along - first) / (last - first)
        within = np.clip(x, 0.0, 1.0)
        sags = within * (1 - 2 * within**2 + within**3)
        self._sags = 3.2 * (sags - np.abs(x - within))  # beyond a support it goes on straight
        self._mm = span(self.rig) * random.uniform(0.15, 0.5)
        self._stiffer = random.uniform(0.0, 1.5)

    def seen(self, path: Path, deflection: Floats, values: Floats, strength: float) -> Floats:
        pull = down(path.tilt_deg)
        pull = pull - (pull @ self._axis)[:, None] * self._axis
        soft = strength * self._mm / (1 + self._stiffer * np.abs(deflection).mean(axis=1))
        change = soft[:, None, None] * self._sags[:, None] * pull[:, None]
        return moved(self.rig, values, positions(self.rig, values) + change)


class LoadedPlate(Law):
    """Clamped plate: a weight at its middle pushes it in by the square of the radius times its logarithm.

    L. D. Landau, E. M. Lifshitz, Theory of Elasticity, Pergamon Press, 1959. It is pushed where gravity points; what
    the weight stretches makes it a little stiffer.
    """

    effect = "gravity"
    needs = frozenset({"markers", "payload"})

    def __init__(self, setting: Setting) -> None:
        super().__init__(setting)
        random, (centre, radius) = setting.random, body_mm(self.rig)
        assert self.rig.rest_mm is not None
        middle = self.rig.rest_mm[int(random.integers(len(self.rig.rest_mm)))]
        middle = middle + random.uniform(0.2, 0.9) * (centre - middle)
        far = np.linalg.norm(self.rig.rest_mm - middle, axis=1)
        r = np.clip(far / (random.uniform(1.5, 2.5) * radius), 1e-6, 1.0)
        self._sinks = 1 - r**2 + 2 * r**2 * np.log(r)
        self._most_kg = max(float(setting.path.payload_kg.max()), 0.01)
        self._stretches = random.uniform(0.0, 0.6)
        self._mm = span(self.rig) * random.uniform(0.2, 0.7)

    def seen(self, path: Path, deflection: Floats, values: Floats, strength: float) -> Floats:
        weight = path.payload_kg / self._most_kg
        size = strength * self._mm * weight / (1 + self._stretches * weight) ** (1 / 3)
        change = size[:, None, None] * self._sinks[:, None] * down(path.tilt_deg)[:, None]
        return moved(self.rig, values, positions(self.rig, values) + change)


class InABath(Law):
    """Buoyancy: in a bath of water a body is lifted by the volume that it displaces, the more, the fuller it is.

    Archimedes, On Floating Bodies, after T. L. Heath, The Works of Archimedes, Cambridge, 1897. It gives way where it
    is soft, and up is where gravity does not point.
    """

    effect = "gravity"
    needs = frozenset({"markers", "tilt"})

    def __init__(self, setting: Setting) -> None:
        super().__init__(setting)
        random, count = setting.random, len(self.rig.chambers)
        self._volume = random.uniform(0.5, 1.5, count) / count * random.uniform(0.3, 1.5)
        self._weighs_less = random.uniform(0.3, 1.0)  # what it displaces when vented, against its own weight
        self._gives = compliance(self.rig) ** random.uniform(0.5, 1.5)
        self._mm = span(self.rig) * random.uniform(0.15, 0.5)

    def seen(self, path: Path, deflection: Floats, values: Floats, strength: float) -> Floats:
        lift = self._weighs_less + np.maximum(deflection, -0.2) @ self._volume
        change = -strength * self._mm * (lift[:, None] * down(path.tilt_deg))[:, None] * self._gives[:, None]
        return moved(self.rig, values, positions(self.rig, values) + change)
