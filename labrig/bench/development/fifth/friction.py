"""Friction of the fifth portion: tight spots along a guide, contacts that slip from their rim, drawers that jam."""

import numpy as np

from labrig.arrays import Floats
from labrig.bench._nature import Law, Path, Setting
from labrig.bench.development._places import full, some
from labrig.bench.development._story import steps
from labrig.bench.development.friction import sliding


class TightSpots(Law):
    """Friction by place: a worn or bent guide holds back more at some places of the way than at others, in waves.

    B. Armstrong-Hélouvry, Control of Machines with Friction, Kluwer, 1991.
    """

    effect = "friction"

    def __init__(self, setting: Setting) -> None:
        super().__init__(setting)
        random, count = setting.random, len(self.rig.chambers)
        self._give = random.uniform(0.004, 0.015, count)
        self._waves = random.uniform(0.8, 3.0, count)  # along full scale
        self._first = random.uniform(0, 2 * np.pi, count)
        self._uneven = random.uniform(0.4, 0.9)
        self._held = some(random, count, 0.02, 0.06)

    def pressure(self, path: Path, kpa: Floats, strength: float) -> Floats:
        drive = full(self.rig, kpa)
        tight = 1 + self._uneven * np.sin(2 * np.pi * self._waves * drive + self._first)
        return kpa - strength * self._held * self.rig.high_kpa * tight * sliding(drive, self._give)


class RoundContacts(Law):
    """Mindlin: a round contact slips from its rim inwards, by the power 1.5, and backwards over twice the way.

    R. D. Mindlin, H. Deresiewicz, Elastic spheres in contact under varying oblique forces, J. Applied Mechanics 20,
    1953. Only the last turn is remembered here.
    """

    effect = "friction"

    def __init__(self, setting: Setting) -> None:
        super().__init__(setting)
        random, count = setting.random, len(self.rig.chambers)
        self._slips_at = random.uniform(0.015, 0.05, count)
        self._held = some(random, count, 0.02, 0.06)

    def pressure(self, path: Path, kpa: Floats, strength: float) -> Floats:
        moves, count = steps(full(self.rig, kpa)), kpa.shape[1]
        way, turn, gone, force = np.ones(count), np.zeros(count), np.zeros(count), np.zeros(count)
        held = np.empty_like(kpa)
        for t, move in enumerate(moves):
            turned = move * way < 0
            way, turn = np.where(turned, -way, way), np.where(turned, force, turn)
            gone = np.where(turned, 0.0, gone) + np.abs(move)
            room = np.maximum(1 - way * turn, 1e-9)  # how far the force can still go, 2 after a full slide
            left = np.maximum(1 - gone / (self._slips_at * room), 0.0)
            force = way * (way * turn + room * (1 - left**1.5))
            held[t] = force
        return kpa - strength * self._held * self.rig.high_kpa * held


class JammingDrawer(Law):
    """Drawer: pulled at one side more than at the other a guide jams; it holds back by how unlike the pulls are.

    R. L. Norton, Machine Design: An Integrated Approach, Prentice Hall, 1996; from laboratory experience.
    """

    effect = "friction"
    needs = frozenset({"several"})

    def __init__(self, setting: Setting) -> None:
        super().__init__(setting)
        random, count = setting.random, len(self.rig.chambers)
        self._give = random.uniform(0.005, 0.015, count)
        self._always, self._jams = random.uniform(0.3, 0.6), random.uniform(1.0, 3.0)
        self._held = some(random, count, 0.025, 0.06, 0.9)

    def pressure(self, path: Path, kpa: Floats, strength: float) -> Floats:
        drive = full(self.rig, kpa)
        unlike = np.abs(drive - drive.mean(axis=1, keepdims=True))
        presses = self._always + self._jams * unlike
        return kpa - strength * self._held * self.rig.high_kpa * presses * sliding(drive, self._give)
