"""A forward model corrected in its own coordinates: what a rig showed, where the simulator's shapes can show it."""

from dataclasses import dataclass
from functools import cached_property
from typing import Any

import numpy as np

from labrig.arrays import Floats
from labrig.surrogate._kernel import Kernel


@dataclass(frozen=True)
class CorrectedHead:
    """z(x) = z_base(gain x) + constant + sum_j k(x, x_j) weights_j.

    `gain` (C,): how much of each chamber's pressure counts; `points` (J, C) fractions of the captures; `constant`
    (K,), `weights` (J, K).
    """

    kind = "corrected"

    base: Any
    gain: Floats
    kernel: Kernel
    points: Floats
    constant: Floats
    weights: Floats

    def latent(self, x: Floats) -> Floats:
        """z (F, K) at fractions x (F, C)."""
        moved = self.kernel.covariance(self.kernel.bent(x), self._bent) @ self.weights
        return self.base.latent(x * self.gain) + self.constant + moved

    def slopes(self, x: Floats) -> Floats:
        """dz/dx (F, K, C) at fractions x (F, C)."""
        value, first, _ = self.kernel.parts(self.kernel.bent(x), self._bent)
        by_t = np.tensordot(value * first, self.weights, axes=([2], [0]))
        moved = by_t.transpose(1, 2, 0) * self.kernel.slope(x)[:, None, :]
        return self.base.slopes(x * self.gain) * self.gain + moved

    def doubt(self, x: Floats) -> Floats:
        """The base's doubt (F,)."""
        return self.base.doubt(x * self.gain)

    @cached_property
    def _bent(self) -> Floats:
        return self.kernel.bent(self.points)
