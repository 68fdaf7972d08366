"""Contact of the tenth portion: a slot that leaves so much play to both sides, and a block that is pushed along."""

import numpy as np

from labrig.arrays import Floats
from labrig.bench._nature import Law, Path, Setting
from labrig.bench.development._places import columns, moved, pattern, positions, reached, some


class InASlot(Law):
    """Slot: the body moves between two parallel rails, and what would go further to either side stays at the rail.

    F. Pfeiffer, C. Glocker, Multibody Dynamics with Unilateral Contacts, Wiley, 1996. The play is the same for each
    place, and begins where it rests; along the rails all is free.
    """

    effect = "contact"
    needs = frozenset({"markers"})

    def __init__(self, setting: Setting) -> None:
        super().__init__(setting)
        random, rig = setting.random, self.rig
        assert rig.rest_mm is not None
        where = columns(rig)
        main = np.where(where >= 0, pattern(rig)[where], 0.0)
        _, _, axes = np.linalg.svd(main, full_matrices=False)
        across = axes[0] * np.sign(random.normal()) + random.uniform(0.0, 0.8) * axes[1]
        self._across = across / np.linalg.norm(across)
        out = positions(rig, rig.settled(setting.path.kpa)) - rig.rest_mm
        self._most_mm = float(np.abs(out @ self._across).max())
        self._nearer = random.uniform(0.25, 0.45)
        self._gives = random.uniform(0.0, 0.15)  # rails bend a little

    def seen(self, path: Path, deflection: Floats, values: Floats, strength: float) -> Floats:
        if strength <= 0:
            return values
        assert self.rig.rest_mm is not None
        points = positions(self.rig, values)
        out_mm = (points - self.rig.rest_mm) @ self._across
        play_mm = self._most_mm / (1 + strength * self._nearer / (1 - self._nearer))
        over_mm = np.sign(out_mm) * np.maximum(np.abs(out_mm) - play_mm, 0.0)
        back_mm = (1 - self._gives) * over_mm[..., None] * self._across
        return moved(self.rig, values, points - back_mm)


class PushesABlock(Law):
    """Block on the bench: a wall that meets it pushes it along against its friction, and leaves it where it turns back.

    M. T. Mason, Mechanics of Robotic Manipulation, MIT Press, 2001, on pushing. Only a wall that goes further than ever
    before is held back; at the start of each session somebody puts the block back, not quite to the same place.
    """

    effect = "contact"

    def __init__(self, setting: Setting) -> None:
        super().__init__(setting)
        random, count = setting.random, len(self.rig.chambers)
        sessions = int(setting.path.session.max()) + 1
        stands = random.uniform(0.15, 0.45, count) + random.normal(0, 0.03, (sessions, count))
        self._stands = stands * reached(self.rig, setting.path)
        self._holds = some(random, count, 0.06, 0.14, 0.7)

    def wall(self, path: Path, kpa: Floats, deflection: Floats, strength: float) -> Floats:
        holds = strength * self._holds
        front, session = self._stands[0], -1
        out = deflection.copy()
        for i in range(len(out)):
            if path.session[i] != session:
                session = int(path.session[i])
                front = self._stands[session % len(self._stands)]
            free = deflection[i]
            held = np.where(free > front, np.maximum(front, free - holds), free)
            out[i] = np.where(holds > 0, held, free)
            front = np.maximum(front, out[i])
        return out
