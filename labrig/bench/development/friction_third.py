"""Friction of the third portion: contacts that age, hairs that lie one way, Bowden sheaths, cones under markers."""

import numpy as np

from labrig.arrays import Floats
from labrig.bench._nature import Law, Path, Setting
from labrig.bench.development._places import full, moved, positions, some, span
from labrig.bench.development._story import pauses, plays, steps
from labrig.bench.development.friction import sliding


class AgeingContacts(Law):
    """Rate and state: the longer a contact has been at rest, the more it holds back when it is moved next.

    J. H. Dieterich, Modeling of rock friction 1: experimental results and constitutive equations, J. Geophysical
    Research 84, 1979.
    """

    effect = "friction"

    def __init__(self, setting: Setting) -> None:
        super().__init__(setting)
        random, count = setting.random, len(self.rig.chambers)
        self._give = random.uniform(0.004, 0.015, count)
        self._ages = random.uniform(0.1, 0.4)  # for each factor e of time
        self._young_s = random.uniform(1.0, 4.0)
        self._held = some(random, count, 0.02, 0.05)

    def pressure(self, path: Path, kpa: Floats, strength: float) -> Floats:
        drive = full(self.rig, kpa)
        moving, pause_s = np.abs(steps(drive)) > 0.1 * self._give, pauses(path)
        rested_s, age, held = np.zeros(drive.shape[1]), np.zeros(drive.shape[1]), np.empty_like(drive)
        for t in range(len(held)):
            begins = moving[t] & (rested_s > 1.0)
            age = np.where(begins, np.log1p(rested_s / self._young_s), age)
            rested_s = np.where(moving[t], 0.0, rested_s + pause_s[t])
            held[t] = 1 + self._ages * age
        return kpa - strength * self._held * self.rig.high_kpa * held * sliding(drive, self._give)


class LyingHairs(Law):
    """Anisotropic friction: fibres that lie one way hold back far more against the nap than along it.

    A. Zmitrowicz, A theoretical model of anisotropic dry friction, Wear 73, 1981.
    """

    effect = "friction"

    def __init__(self, setting: Setting) -> None:
        super().__init__(setting)
        random, count = setting.random, len(self.rig.chambers)
        self._give = random.uniform(0.005, 0.02, count)
        against, along = random.uniform(0.04, 0.1), random.uniform(0.0, 0.02)
        rises = random.random(count) < 0.5
        self._rising = np.where(rises, against, along) * random.uniform(0.8, 1.2, count)
        self._falling = np.where(rises, along, against) * random.uniform(0.8, 1.2, count)

    def wall(self, path: Path, kpa: Floats, deflection: Floats, strength: float) -> Floats:
        way = sliding(deflection, self._give)
        held = np.where(way > 0, self._rising, self._falling) * way
        return deflection - strength * held


class BowdenSheath(Law):
    """Bowden sheath: the far end moves only once the near end's tension has changed by a factor, either way.

    M. Kaneko, T. Yamashita, K. Tanie, Basic considerations on transmission characteristics for tendon drive robots,
    5th Int. Conference on Advanced Robotics, 1991.
    """

    effect = "friction"

    def __init__(self, setting: Setting) -> None:
        super().__init__(setting)
        random, count = setting.random, len(self.rig.chambers)
        self._slack = random.uniform(0.03, 0.1)  # tension, of full, below which the factor counts no more
        self._rubs = some(random, count, 0.04, 0.12, 0.9)

    def pressure(self, path: Path, kpa: Floats, strength: float) -> Floats:
        tension = np.arcsinh(full(self.rig, kpa) / self._slack)
        far = plays(tension, strength * self._rubs[None])[:, 0]
        return self.rig.high_kpa * self._slack * np.sinh(far)


class ConeUnderMarkers(Law):
    """Isotropic dry friction under the skin: each place follows only once it is behind by a length, whichever way.

    J. J. Moreau, Application of convex analysis to some problems of dry friction, Trends in Applications of Pure
    Mathematics to Mechanics II, Pitman, 1979.
    """

    effect = "friction"
    needs = frozenset({"markers"})

    def __init__(self, setting: Setting) -> None:
        super().__init__(setting)
        random = setting.random
        rough = random.uniform(0.6, 1.4, len(self.rig.marker_names))
        self._behind_mm = span(self.rig) * random.uniform(0.03, 0.08) * rough

    def seen(self, path: Path, deflection: Floats, values: Floats, strength: float) -> Floats:
        points = positions(self.rig, values)
        most_mm = strength * self._behind_mm[:, None]
        state, out = positions(self.rig, self.rig.at_rest[None])[0], points.copy()
        for t, now in enumerate(points):
            behind = now - state
            length = np.maximum(np.linalg.norm(behind, axis=1, keepdims=True), 1e-12)
            state = now - behind * np.minimum(1.0, most_mm / length)
            out[t] = state
        return moved(self.rig, values, out)
