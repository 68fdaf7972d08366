"""Gravity of the ninth portion: a cantilever, a load at its tip, a hinge, chambers that bear weight."""

from collections.abc import Callable

import numpy as np

from labrig.arrays import Floats
from labrig.bench._nature import Law, Path, Rig, Setting
from labrig.bench.development._places import (
    body_mm,
    compliance,
    down,
    full,
    long_axis,
    moved,
    pattern,
    positions,
    span,
)


def _usual_kg(path: Path) -> float:
    """What hangs on the rig when something does, in kg."""
    loaded = path.payload_kg[path.payload_kg > 0]
    return float(loaded.mean()) if len(loaded) else 1.0


def _sagging(rig: Rig, line: Callable[[Floats], Floats]) -> Floats:
    """How far each marker (M,) gives way: by a beam's line from its root, and by its own softness.

    The root is at that end of the long axis where the surface moves less. Root mean square 1.
    """
    soft, along = compliance(rig), long_axis(rig)[1]
    apart = along - along.mean()
    from_root = along if soft @ apart >= 0 else 1 - along
    out = soft * (0.05 + 0.95 * line(from_root))
    return out / np.sqrt(np.mean(out**2))


class CantileverSags(Law):
    """Cantilever sags: a body held at one end bends under its own weight, and stretches where it hangs.

    J. M. Gere, S. P. Timoshenko, Mechanics of Materials, PWS, 1997: w = q x^2 (x^2 - 4 L x + 6 L^2) / 24 E I
    under the weight across the axis, u = q x (2 L - x) / 2 E A under the weight along it.
    """

    effect = "gravity"
    needs = frozenset({"tilt", "markers"})

    def __init__(self, setting: Setting) -> None:
        super().__init__(setting)
        random, rig = setting.random, self.rig
        self._axis = long_axis(rig)[0]
        sag = random.uniform(0.1, 0.22) * span(rig)
        self._bends = sag * _sagging(rig, lambda x: x**2 * (x**2 - 4 * x + 6) / 3)
        self._stretches = sag * random.uniform(0.05, 0.2) * _sagging(rig, lambda x: x * (2 - x))

    def seen(self, path: Path, deflection: Floats, values: Floats, strength: float) -> Floats:
        weight = down(path.tilt_deg)
        along = np.outer(weight @ self._axis, self._axis)
        sag = (weight - along)[:, None] * self._bends[:, None] + along[:, None] * self._stretches[:, None]
        return moved(self.rig, values, positions(self.rig, values) + strength * sag)


class LoadAtTheTip(Law):
    """Load at the tip: what hangs on the end of the body bends it as a spring, in proportion.

    R. G. Budynas, J. K. Nisbett, Shigley's Mechanical Engineering Design, McGraw-Hill, 2011: w = F x^2 (3 L -
    x) / 6 E I. A body without markers goes the way that its chambers take it, under the part of the weight
    that lies in it.
    """

    effect = "gravity"
    needs = frozenset({"payload"})

    def __init__(self, setting: Setting) -> None:
        super().__init__(setting)
        random, rig = setting.random, self.rig
        sag = random.uniform(0.15, 0.35) * span(rig) / _usual_kg(setting.path)
        upright = np.deg2rad(random.uniform(-40, 40))
        sense = np.array([0.0, np.sin(upright), np.cos(upright)]) * random.choice([-1.0, 1.0])
        marker = np.array([o.marker for o in rig.observables])
        ways = np.eye(3)[[o.axis for o in rig.observables]]
        ways = np.where(marker[:, None] >= 0, ways, sense)
        every = pattern(rig) * np.sqrt(len(marker))
        gives = every
        if rig.marker_names:
            gives = np.where(marker >= 0, _sagging(rig, lambda x: x**2 * (3 - x) / 2)[marker], every)
        self._gives = sag * gives[:, None] * ways

    def seen(self, path: Path, deflection: Floats, values: Floats, strength: float) -> Floats:
        weight = path.payload_kg[:, None] * down(path.tilt_deg)
        return values + strength * weight @ self._gives.T


class HingeAtTheRoot(Law):
    """Hinge at the root: the weight turns the body about where it is held, against a spring there.

    L. L. Howell, Compliant Mechanisms, Wiley, 2001, the pseudo-rigid-body model: K theta = m g l, where l is
    the lever across gravity, so that it depends on how the body leans and on where its chambers have brought
    it.
    """

    effect = "gravity"
    needs = frozenset({"tilt", "markers"})

    def __init__(self, setting: Setting) -> None:
        super().__init__(setting)
        random, rig = setting.random, self.rig
        assert rig.rest_mm is not None
        self._soft = compliance(rig)
        stays = (1.05 - self._soft) ** 4
        self._root_mm = stays @ rig.rest_mm / stays.sum()
        far_mm = max(float(np.linalg.norm(body_mm(rig)[0] - self._root_mm)), 0.3 * body_mm(rig)[1])
        self._turn = random.uniform(0.07, 0.18) * span(rig) / far_mm**2
        self._heavier = random.uniform(0.3, 1.0) / _usual_kg(setting.path)

    def seen(self, path: Path, deflection: Floats, values: Floats, strength: float) -> Floats:
        points = positions(self.rig, values)
        arms = points - self._root_mm
        heavy = 1 + self._heavier * path.payload_kg[:, None]
        lever = np.asarray(np.cross(arms.mean(axis=1), down(path.tilt_deg)), dtype=float)
        turn = self._turn * heavy * lever
        sag = np.asarray(np.cross(turn[:, None], arms), dtype=float) * self._soft[:, None]
        return moved(self.rig, values, points + strength * sag)


class ChambersBearTheWeight(Law):
    """Chambers bear the weight: each carries a share of it, and that much of its pressure moves nothing.

    B. Pascal, Traités de l'équilibre des liqueurs, 1663: p = F / A; shares by the law of the lever. When the
    base is turned, those below the centre of mass carry more and those above it less.
    """

    effect = "gravity"
    needs = frozenset({"tilt"})

    def __init__(self, setting: Setting) -> None:
        super().__init__(setting)
        random, count = setting.random, len(self.rig.chambers)
        around = random.uniform(0, 2 * np.pi) + 2 * np.pi * np.arange(count) / count
        lever = random.uniform(1.0, 2.5) * np.sin(around + random.normal(0, 0.15, count))
        area = random.uniform(0.85, 1.15, count)
        self._bears = random.uniform(0.03, 0.08) * self.rig.high_kpa / area
        self._lever = lever
        self._heavier = random.uniform(0.3, 1.0) / _usual_kg(setting.path)

    def pressure(self, path: Path, kpa: Floats, strength: float) -> Floats:
        heavy = 1 + self._heavier * path.payload_kg[:, None]
        turn = np.deg2rad(path.tilt_deg)[:, None]
        share = np.cos(turn) + self._lever * np.sin(turn)
        return kpa - strength * heavy * share * self._bears


class FilledWallsGiveLess(Law):
    """Filled walls give less: a payload pushes each wall back, less where pressure makes it stiff.

    C.-P. Chou, B. Hannaford, Measurement and modeling of McKibben pneumatic artificial muscles, IEEE
    Transactions on Robotics and Automation 12, 1996: the stiffness goes with the pressure, beside that of the
    rubber.
    """

    effect = "gravity"
    needs = frozenset({"payload"})

    def __init__(self, setting: Setting) -> None:
        super().__init__(setting)
        random, count = setting.random, len(self.rig.chambers)
        self._yields = random.uniform(0.08, 0.2) * random.uniform(0.8, 1.2, count) / _usual_kg(setting.path)
        self._stiffer = random.uniform(0.8, 2.5) * random.uniform(0.85, 1.15, count)

    def wall(self, path: Path, kpa: Floats, deflection: Floats, strength: float) -> Floats:
        weight = path.payload_kg * np.cos(np.deg2rad(path.tilt_deg))
        spring = 1 + self._stiffer * np.abs(full(self.rig, kpa))
        return deflection - strength * weight[:, None] * self._yields / spring
