"""Tension of the sixth portion: a film with a tension of its own, springs across, a sleeve that was wound on tight."""

import numpy as np

from labrig.arrays import Floats
from labrig.bench._nature import Setting
from labrig.bench.development._places import some
from labrig.bench.development.tension import HeldBack


class CapOfFilm(HeldBack):
    """Young: a film of constant tension over a round opening presses by its curvature: most as a half sphere.

    T. Young, An essay on the cohesion of fluids, Philosophical Transactions 95, 1805.
    """

    def __init__(self, setting: Setting) -> None:
        super().__init__(setting)
        random, count = setting.random, len(self.rig.chambers)
        self._half_at = random.uniform(0.5, 2.0) * random.uniform(0.85, 1.15, count)
        self._most = random.uniform(0.05, 0.15) * random.uniform(0.8, 1.2, count)

    def _held(self, deflection: Floats) -> Floats:
        high = deflection / self._half_at
        return self._most * 2 * high / (1 + high**2)


class SpringsAcross(HeldBack):
    """Springs across the way: stretched when mounted, they pull aside at first, and back the more they are slanted.

    A. Carrella, M. J. Brennan, T. P. Waters, Static analysis of a passive vibration isolator with
    quasi-zero-stiffness characteristic, J. Sound and Vibration 301, 2007.
    """

    def __init__(self, setting: Setting) -> None:
        super().__init__(setting)
        random, count = setting.random, len(self.rig.chambers)
        self._wide = random.uniform(0.8, 2.0)  # from the wall to where they are held
        self._own = random.uniform(0.2, 0.85, count)  # their own length, over that
        self._stiff = some(random, count, 0.1, 0.35, 0.85)

    def _held(self, deflection: Floats) -> Floats:
        slope = deflection / self._wide
        return self._stiff * deflection * (1 - self._own / np.sqrt(1 + slope**2))


class WoundOnTight(HeldBack):
    """Wound on tight: cords around one wall or two hold it by the squared sine of their angle, until they lie along it.

    J. E. Adkins, R. S. Rivlin, Large elastic deformations of isotropic materials X: reinforcement by inextensible
    cords, Phil. Trans. Royal Society A 248, 1955.
    """

    def __init__(self, setting: Setting) -> None:
        super().__init__(setting)
        random, count = setting.random, len(self.rig.chambers)
        on = random.permutation(count) < int(random.integers(1, 3))
        self._pull = np.where(on, random.uniform(0.08, 0.2, count), 0.0)
        self._cos = np.cos(np.deg2rad(random.uniform(35, 65, count)))
        self._longer = random.uniform(0.2, 0.9, count)  # the share by which it grows at full load
        self._seats = random.uniform(0.03, 0.1)

    def _held(self, deflection: Floats) -> Floats:
        along = self._cos * (1 + self._longer * np.abs(deflection))
        left = np.maximum(1 - along**2, 0.0) / (1 - self._cos**2)
        return self._pull * np.tanh(deflection / self._seats) * left
