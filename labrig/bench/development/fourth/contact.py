"""Contact of the fourth portion: rough faces, sticky stops, parts of the body that meet each other."""

import numpy as np
from scipy.special import wrightomega

from labrig.arrays import Floats
from labrig.bench._nature import Law, Path, Setting
from labrig.bench.development._places import body_mm, moved, positions, reached


class _Stop(Law):
    """A stop before one wall or two, nearer than they came by a share that grows with the strength."""

    effect = "contact"
    shares = (0.3, 0.8)

    def __init__(self, setting: Setting) -> None:
        super().__init__(setting)
        random, count = setting.random, len(self.rig.chambers)
        self._which = random.permutation(count)[: int(random.integers(1, min(count, 2) + 1))]
        self._top = reached(self.rig, setting.path)[self._which]
        self._nearer = random.uniform(*self.shares, len(self._which))


class RoughStop(_Stop):
    """Rough faces: peaks meet one after another, so that a stop resists with the exponential of how near a wall is.

    J. A. Greenwood, J. B. P. Williamson, Contact of nominally flat surfaces, Proc. Royal Society A 295, 1966.
    """

    def __init__(self, setting: Setting) -> None:
        super().__init__(setting)
        self._rough = self._top * setting.random.uniform(0.015, 0.05)

    def wall(self, path: Path, kpa: Floats, deflection: Floats, strength: float) -> Floats:
        if strength <= 0:
            return deflection
        out = deflection.copy()
        past = out[:, self._which] - self._top * np.exp(-strength * self._nearer)
        out[:, self._which] -= self._rough * np.asarray(wrightomega(past / self._rough), dtype=float)
        return out


class AdhesiveStop(_Stop):
    """Adhesion: a wall that has met a sticky stop stays on it until it is pulled back by some way, and then lets go.

    K. L. Johnson, K. Kendall, A. D. Roberts, Surface energy and the contact of elastic solids, Proc. Royal Society A
    324, 1971.
    """

    shares = (0.4, 0.9)

    def __init__(self, setting: Setting) -> None:
        super().__init__(setting)
        self._sticks = self._top * setting.random.uniform(0.05, 0.2)

    def wall(self, path: Path, kpa: Floats, deflection: Floats, strength: float) -> Floats:
        if strength <= 0:
            return deflection
        stop = self._top * np.exp(-strength * self._nearer)
        leaves = stop - self._sticks * -np.expm1(-strength)
        touches, out = np.zeros(len(stop), dtype=bool), deflection.copy()
        for t, now in enumerate(deflection[:, self._which]):
            touches = (now >= stop) | (touches & (now > leaves))
            out[t, self._which] = np.where(touches, stop, now)
        return out


class SelfContact(Law):
    """Self-contact: two places that move towards each other meet, and from then on push each other back.

    M. Müller, B. Heidelberger, M. Hennix, J. Ratcliff, Position based dynamics, J. Visual Communication and Image
    Representation 18, 2007. What is around the two places goes along with them.
    """

    effect = "contact"
    needs = frozenset({"markers"})

    def __init__(self, setting: Setting) -> None:
        super().__init__(setting)
        rig, path, random = self.rig, setting.path, setting.random
        assert rig.rest_mm is not None
        seen = positions(rig, rig.settled(path.kpa[path.row][::5]))
        apart = np.linalg.norm(seen[:, :, None] - seen[:, None], axis=3)
        rest = np.linalg.norm(rig.rest_mm[:, None] - rig.rest_mm, axis=2)
        near = apart.min(axis=0)
        upper = np.triu_indices(len(rest), 1)
        best = np.argsort((near - rest)[upper])[:4]
        pick = int(best[random.integers(len(best))])
        self._one, self._other = int(upper[0][pick]), int(upper[1][pick])
        self._rest_mm, self._near_mm = rest[self._one, self._other], near[self._one, self._other]
        self._sooner = random.uniform(0.3, 0.8)
        wide_mm = body_mm(rig)[1] * random.uniform(0.25, 0.5)
        around = np.exp(-0.5 * (rest[:, [self._one, self._other]] / wide_mm) ** 2)
        self._goes = around[:, 0] - around[:, 1]
        self._goes /= max(self._goes[self._one] - self._goes[self._other], 1e-6)

    def seen(self, path: Path, deflection: Floats, values: Floats, strength: float) -> Floats:
        if strength <= 0:
            return values
        points = positions(self.rig, values)
        meets_mm = self._near_mm + max(self._rest_mm - self._near_mm, 0.0) * -np.expm1(
            -strength * self._sooner
        )
        between = points[:, self._one] - points[:, self._other]
        length = np.maximum(np.linalg.norm(between, axis=1, keepdims=True), 1e-9)
        push = np.maximum(meets_mm - length, 0.0) * between / length
        return moved(self.rig, values, points + push[:, None] * self._goes[:, None])
