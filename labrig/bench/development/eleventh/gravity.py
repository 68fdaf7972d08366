"""Gravity of the eleventh portion: a chain of hinges, and a weight whose loop slides to the lowest place."""

import numpy as np

from labrig.arrays import Floats
from labrig.bench._nature import Law, Path, Setting
from labrig.bench.development._places import (
    body_mm,
    columns,
    compliance,
    down,
    long_axis,
    moved,
    positions,
    span,
    turned,
)


class ChainOfHinges(Law):
    """Rigid links: the body turns at a few springy hinges, each by the moment of all weights beyond it as they are now.

    R. K. Katzschmann et al., Dynamic motion control of multi-segment soft robots using piecewise constant curvature
    matched with an augmented rigid body model, RoboSoft, 2019. As arms change with the pose, so does what it sags by.
    A payload hangs at the far end.
    """

    effect = "gravity"
    needs = frozenset({"markers"})

    def __init__(self, setting: Setting) -> None:
        super().__init__(setting)
        random, rig, path = setting.random, self.rig, setting.path
        assert rig.rest_mm is not None
        place, soft = long_axis(rig)[1], compliance(rig)
        if np.cov(place, soft)[0, 1] < 0:
            place = 1 - place  # its foot is where it moves least
        count = int(random.integers(2, 5))
        hinge = (np.arange(count) + random.uniform(0.0, 0.5)) / count
        self._beyond = np.clip((place - hinge[:, None]) * count + 0.5, 0.0, 1.0)  # (H, M)
        near = np.exp(-0.5 * ((place - hinge[:, None]) * count / 0.5) ** 2) + 1e-9
        self._near = near / near.sum(axis=1, keepdims=True)
        self._mass = random.dirichlet(np.full(len(place), 6.0))
        at_end = np.exp(-((1 - place) ** 2) / 0.02)
        self._hangs = at_end / at_end.sum() / random.uniform(0.1, 0.4)  # per kg, the body weighing one
        self._gives = random.uniform(0.7, 1.3, count)  # per moment, scaled below
        values = rig.settled(path.kpa[path.row])
        seen_way = down(path.tilt_deg[path.row]), path.payload_kg[path.row]
        change = self._sagged(values, *seen_way, 1e-6) - values
        size = np.sqrt(np.mean(change**2)) / 1e-6
        most = np.abs(self._moments(positions(rig, values), *seen_way)).max() * self._gives.max()
        wanted = random.uniform(0.2, 0.35) * span(rig) / max(float(size), 1e-12)
        self._gives *= min(wanted, 0.15 / max(float(most), 1e-12))

    def _moments(self, points: Floats, way: Floats, payload_kg: Floats) -> Floats:
        """The moment (T, H, 3) at each hinge."""
        weight = self._mass + payload_kg[:, None] * self._hangs
        arms = points[:, None] - np.einsum("hm,tmx->thx", self._near, points)[:, :, None]
        lever = np.einsum("tm,hm,thmx->thx", weight, self._beyond, arms)
        return np.array(np.cross(lever, way[:, None]), dtype=float)

    def _sagged(self, values: Floats, way: Floats, payload_kg: Floats, strength: float) -> Floats:
        points = positions(self.rig, values)
        turns = strength * self._gives[:, None] * self._moments(points, way, payload_kg)
        for h in range(len(self._gives) - 1, -1, -1):  # from the far end to the foot
            about = np.einsum("m,tmx->tx", self._near[h], points)[:, None]
            points = points + self._beyond[h][:, None] * (turned(points, about, turns[:, h]) - points)
        return moved(self.rig, values, points)

    def seen(self, path: Path, deflection: Floats, values: Floats, strength: float) -> Floats:
        if strength == 0:
            return values
        return self._sagged(values, down(path.tilt_deg), path.payload_kg, strength)


class LoopSlidesDown(Law):
    """Sliding loop: a weight hangs on the body by a loop, which slides to wherever the body is lowest, and pulls there.

    E. Torricelli, Opera Geometrica, 1644: weights rest where together they are lowest. Students hang them on soft arms
    so. Places near the loop sag with it, the softer ones more. As the pose changes it goes elsewhere; friction keeps
    it from going all the way.
    """

    effect = "gravity"
    needs = frozenset({"markers", "payload"})

    def __init__(self, setting: Setting) -> None:
        super().__init__(setting)
        random, rig = setting.random, self.rig
        assert rig.rest_mm is not None
        _, radius_mm = body_mm(rig)
        soft = np.sqrt(compliance(rig)) + 0.05
        self._able = (columns(rig) >= 0).any(axis=1) & (soft > 0.3)
        apart = np.sum((rig.rest_mm[:, None] - rig.rest_mm) ** 2, axis=2)
        near = np.exp(-apart / (2 * (random.uniform(0.5, 1.0) * radius_mm) ** 2))
        self._gives = soft[:, None] * near * soft * random.uniform(0.3, 0.6) * span(rig) / 0.1  # mm per kg
        self._drops_mm = random.uniform(0.04, 0.12) * radius_mm
        put = rig.rest_mm[int(random.choice(np.flatnonzero(self._able)))]
        away = np.sum((rig.rest_mm - put) ** 2, axis=1)
        self._keeps = away / (2 * (random.uniform(0.7, 1.5) * radius_mm) ** 2)

    def seen(self, path: Path, deflection: Floats, values: Floats, strength: float) -> Floats:
        points, way = positions(self.rig, values), down(path.tilt_deg)
        low = np.einsum("tmx,tx->tm", points, way) / self._drops_mm - self._keeps
        low = np.where(self._able, low, -np.inf)
        hangs = np.exp(low - low.max(axis=1, keepdims=True))
        hangs /= hangs.sum(axis=1, keepdims=True)
        sag_mm = strength * path.payload_kg[:, None] * (hangs @ self._gives)
        return moved(self.rig, values, points + sag_mm[..., None] * way[:, None])
