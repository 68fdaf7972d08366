"""Gravity: weight and payload pull the body down, the more where it gives way."""

import numpy as np

from labrig.arrays import Floats
from labrig.bench._nature import Law, Path, Setting
from labrig.bench.development._places import body_mm, compliance, down, moved, positions, span


class OwnWeight(Law):
    """Own weight: an elastic body sags along gravity in proportion to its compliance, also when its base is turned.

    S. P. Timoshenko, J. N. Goodier, Theory of Elasticity, 3rd ed., McGraw-Hill, 1970.
    """

    effect = "gravity"
    needs = frozenset({"markers", "tilt"})

    def __init__(self, setting: Setting) -> None:
        super().__init__(setting)
        power = setting.random.uniform(0.7, 1.5)
        self._sag_mm = span(self.rig) * setting.random.uniform(0.05, 0.2) * compliance(self.rig) ** power

    def seen(self, path: Path, deflection: Floats, values: Floats, strength: float) -> Floats:
        sag = self._sag_mm[:, None] * down(path.tilt_deg)[:, None]
        return moved(self.rig, values, positions(self.rig, values) + strength * sag)


class InflatedDroop(Law):
    """Inflated beam: a body that only its pressure keeps stiff droops less the more it is inflated.

    R. L. Comer, S. Levy, Deflections of an inflated circular-cylindrical cantilever beam, AIAA J. 1, 1963.
    """

    effect = "gravity"
    needs = frozenset({"markers", "tilt"})

    def __init__(self, setting: Setting) -> None:
        super().__init__(setting)
        self._sag_mm = span(self.rig) * setting.random.uniform(0.08, 0.25) * compliance(self.rig)
        self._stiffer = setting.random.uniform(0.5, 2.5)

    def seen(self, path: Path, deflection: Floats, values: Floats, strength: float) -> Floats:
        gives = 1 / (1 + self._stiffer * np.maximum(deflection, 0.0).mean(axis=1))
        sag = self._sag_mm[:, None] * (gives[:, None] * down(path.tilt_deg))[:, None]
        return moved(self.rig, values, positions(self.rig, values) + strength * sag)


class LiftedPayload(Law):
    """Lifted payload: a part of each chamber's pressure only carries what hangs on the body.

    F. Daerden, D. Lefeber, Pneumatic artificial muscles: actuators for robotics and automation, European J.
    Mechanical and Environmental Engineering 47, 2002.
    """

    effect = "gravity"
    needs = frozenset({"payload"})

    def __init__(self, setting: Setting) -> None:
        super().__init__(setting)
        share = setting.random.uniform(0.04, 0.12) * setting.random.dirichlet(
            np.full(len(self.rig.chambers), 3.0)
        )
        most_kg = max(float(setting.path.payload_kg.max()), 0.01)
        self._kpa_per_kg = share * len(self.rig.chambers) * self.rig.high_kpa / most_kg

    def pressure(self, path: Path, kpa: Floats, strength: float) -> Floats:
        return kpa - strength * path.payload_kg[:, None] * self._kpa_per_kg


class PayloadAtAPoint(Law):
    """Payload at one point: the body is pulled down there by the unit-load method, and less the farther from it.

    S. P. Timoshenko, Strength of Materials, Part I, 3rd ed., Van Nostrand, 1955.
    """

    effect = "gravity"
    needs = frozenset({"markers", "payload"})

    def __init__(self, setting: Setting) -> None:
        super().__init__(setting)
        rig = self.rig
        assert rig.rest_mm is not None
        soft = compliance(rig)
        at = int(setting.random.choice(np.flatnonzero(soft >= np.median(soft))))
        distance = np.linalg.norm(rig.rest_mm - rig.rest_mm[at], axis=1) / body_mm(rig)[1]
        near = np.exp(-0.5 * (distance / setting.random.uniform(0.6, 1.5)) ** 2)
        most_kg = max(float(setting.path.payload_kg.max()), 0.01)
        self._mm_per_kg = (
            span(rig) * setting.random.uniform(0.1, 0.3) / most_kg * near * np.sqrt(soft * soft[at])
        )

    def seen(self, path: Path, deflection: Floats, values: Floats, strength: float) -> Floats:
        pull = path.payload_kg[:, None] * down(path.tilt_deg)
        points = positions(self.rig, values) + strength * self._mm_per_kg[:, None] * pull[:, None]
        return moved(self.rig, values, points)
