"""Coupling: chambers inflated together move the surface otherwise than the sum of what each does alone."""

import numpy as np

from labrig.arrays import Floats
from labrig.bench._nature import Law, Path, Setting
from labrig.bench.development._places import full, overlap, some


class SupplySag(Law):
    """Shared supply: the pressure of the supply falls with what the other chambers take from it.

    P. Beater, Pneumatic Drives: System Design, Modelling and Control, Springer, 2007.
    """

    effect = "coupling"
    needs = frozenset({"several"})

    def __init__(self, setting: Setting) -> None:
        super().__init__(setting)
        count = len(self.rig.chambers)
        self._takes = some(setting.random, count, 0.5, 1.5) / count
        self._sag = setting.random.uniform(0.1, 0.35)

    def pressure(self, path: Path, kpa: Floats, strength: float) -> Floats:
        taken = np.maximum(full(self.rig, kpa), 0.0) * self._takes
        others = taken.sum(axis=1, keepdims=True) - taken
        return kpa / (1 + strength * self._sag * others)


class PressingNeighbours(Law):
    """Neighbours in touch: two bulges that lie side by side press on each other as far as both are out.

    K. L. Johnson, Contact Mechanics, Cambridge University Press, 1985.
    """

    effect = "coupling"
    needs = frozenset({"several"})

    def __init__(self, setting: Setting) -> None:
        super().__init__(setting)
        near = overlap(self.rig)
        touch = near * (near >= 0.5 * near.max())
        self._press = touch / touch.sum(axis=1).max() * setting.random.uniform(0.1, 0.35)

    def wall(self, path: Path, kpa: Floats, deflection: Floats, strength: float) -> Floats:
        out = np.maximum(deflection, 0.0)
        change = np.zeros_like(deflection)
        for c, press in enumerate(self._press):
            shared = np.minimum(out[:, c : c + 1], out) @ press
            change[:, c] = -out[:, c] * -np.expm1(-strength * shared)
        return deflection + change


class TwoFactorInteraction(Law):
    """Two-factor interaction: of some pairs each chamber's way changes by a factor that the other one sets.

    G. E. P. Box, W. G. Hunter, J. S. Hunter, Statistics for Experimenters, Wiley, 1978.
    """

    effect = "coupling"
    needs = frozenset({"several"})

    def __init__(self, setting: Setting) -> None:
        super().__init__(setting)
        count = len(self.rig.chambers)
        upper = np.triu_indices(count, 1)
        pairs = np.zeros((count, count))
        sizes = some(setting.random, len(upper[0]), 0.08, 0.3, 0.4)
        pairs[upper] = sizes * setting.random.choice([-1.0, 1.0], p=[0.7, 0.3])
        self._pairs = (pairs + pairs.T) * 2 / count

    def wall(self, path: Path, kpa: Floats, deflection: Floats, strength: float) -> Floats:
        return deflection * np.exp(np.minimum(strength * deflection @ self._pairs, 1.5))


class SharedSkin(Law):
    """Inextensible net: what one bulge takes of the common skin, its neighbours lack, the more the further it is out.

    R. S. Rivlin, Plane strain of a net formed by inextensible cords, J. Rational Mechanics and Analysis 4, 1955.
    """

    effect = "coupling"
    needs = frozenset({"several"})

    def __init__(self, setting: Setting) -> None:
        super().__init__(setting)
        near = overlap(self.rig) + 0.1
        np.fill_diagonal(near, 0.0)
        self._share = near / near.sum(axis=1).max() * setting.random.uniform(0.3, 1.0)

    def wall(self, path: Path, kpa: Floats, deflection: Floats, strength: float) -> Floats:
        taken = deflection**2 @ self._share.T
        return deflection / np.sqrt(1 + strength * taken)
