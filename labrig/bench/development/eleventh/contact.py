"""Contact of the eleventh portion: a sticky block that lets go late, and a stand that heels over its edge."""

import numpy as np

from labrig.arrays import Floats
from labrig.bench._nature import Law, Path, Setting
from labrig.bench.development._places import (
    alone,
    body_mm,
    columns,
    full,
    moved,
    positions,
    reached,
    some,
    span,
    turned,
)


class SticksToABlock(Law):
    """Johnson-Kendall-Roberts: a wall that meets a soft block is drawn on by adhesion, and tears off later than it met.

    K. L. Johnson, K. Kendall, A. D. Roberts, Surface energy and the contact of elastic solids, Proceedings of the Royal
    Society A 324, 1971, in the units of D. Maugis. Farther in, the block pushes back as in Hertz's contact.
    """

    effect = "contact"

    def __init__(self, setting: Setting) -> None:
        super().__init__(setting)
        random, count = setting.random, len(self.rig.chambers)
        most = reached(self.rig, setting.path)
        self._gap = random.uniform(0.25, 0.55) * random.uniform(0.8, 1.2, count) * most
        self._unit = random.uniform(0.03, 0.08) * most  # of depth, with which adhesion can do something
        self._hard = some(random, count, 0.08, 0.25, 0.7)
        radius = np.geomspace(1.5 ** (1 / 3), 60.0, 500)  # from where a dead weight would tear it off
        self._depth = radius**2 - 2 / 3 * np.sqrt(6 * radius)
        self._force = radius**3 - radius * np.sqrt(6 * radius)

    def wall(self, path: Path, kpa: Floats, deflection: Floats, strength: float) -> Floats:
        out = deflection.copy()
        for c in np.flatnonzero(self._hard):
            over = (deflection[:, c] - self._gap[c]) / self._unit[c]
            goes = self._depth + strength * self._hard[c] * self._force  # how far it would be, at a depth
            touch, held = False, np.zeros(len(over), dtype=bool)
            for i, far in enumerate(over.tolist()):
                touch = far >= (goes[0] if touch else 0.0)
                held[i] = touch
            depth = np.interp(over, goes, self._depth)
            out[:, c] += self._unit[c] * np.where(held, depth - over, 0.0)
        return out


class HeelsOver(Law):
    """Heeling: what the rig stands on lifts off on one side once its thrust is beyond the foot, and turns it all.

    G. W. Housner, The behavior of inverted pendulum structures during earthquakes, Bulletin of the Seismological
    Society of America 53, 1963. Up to there nothing moves; then all turns about the edge of the foot, to whichever
    side the chambers together lean, in proportion to what is too much, as the foot's rim is soft.
    """

    effect = "contact"
    needs = frozenset({"markers"})

    def __init__(self, setting: Setting) -> None:
        super().__init__(setting)
        random, rig, path = setting.random, self.rig, setting.path
        assert rig.rest_mm is not None
        where = columns(rig)
        each = np.where(where >= 0, alone(rig)[:, where], 0.0)[..., :2].mean(axis=1)  # (C, 2)
        size = np.sqrt(np.mean(each**2)) + 1e-9
        self._leans = each / size + random.normal(0, 0.5, each.shape)
        _, radius_mm = body_mm(rig)
        self._foot_mm = np.append(rig.rest_mm[:, :2].mean(axis=0), rig.rest_mm[:, 2].min())
        self._foot_mm[2] -= random.uniform(0.1, 0.6) * radius_mm
        self._edge_mm = random.uniform(0.5, 1.2) * radius_mm
        usual = np.linalg.norm(full(rig, path.kpa[path.row]) @ self._leans, axis=1)
        self._from = float(np.quantile(usual, random.uniform(0.35, 0.7)) * random.uniform(0.8, 0.95))
        self._turns = 1.0
        values = rig.settled(path.kpa[path.row])
        change = self._heeled(values, path.kpa[path.row], 1e-5) - values
        wanted = random.uniform(0.2, 0.4) * span(rig) / max(float(np.sqrt(np.mean(change**2))) / 1e-5, 1e-12)
        self._turns = min(wanted, 0.12 / max(float(usual.max()) - self._from, 1e-9))

    def _heeled(self, values: Floats, kpa: Floats, strength: float) -> Floats:
        leans = full(self.rig, kpa) @ self._leans
        size = np.linalg.norm(leans, axis=1, keepdims=True)
        way = leans / np.maximum(size, 1e-12)
        turn = strength * self._turns * np.clip(size - self._from, 0.0, 1e3)
        axis = np.column_stack([-way[:, 1], way[:, 0], np.zeros(len(way))])
        edge = self._foot_mm + self._edge_mm * np.column_stack([way, np.zeros(len(way))])
        return moved(self.rig, values, turned(positions(self.rig, values), edge[:, None], turn * axis))

    def seen(self, path: Path, deflection: Floats, values: Floats, strength: float) -> Floats:
        return values if strength == 0 else self._heeled(values, path.kpa, strength)
