"""The covariance of the forward model: a product over the chambers of a constant and a bell in a bent coordinate.

    k(x, y) = prod_c (1 + s_c g_c) / (1 + s_c),   g_c = exp(-(t_c(x) - t_c(y))^2 / (2 l_c^2)),
    t_c(x) = log(1 + b_c x_c) / log(1 + b_c)

Multiplied out it is a sum over all subsets of chambers (an ANOVA kernel): with small shares s the chambers act
side by side, with large ones each combination is something of its own. The bend b follows the inflation of a
chamber, which is quick at first and stiffens. x is the pressure as a fraction of each chamber's range.
"""

from dataclasses import dataclass

import numpy as np

from labrig.arrays import Floats


@dataclass(frozen=True)
class Kernel:
    """Parameters by chamber, each (C,): length in the bent coordinate, bend and share, all positive."""

    length: Floats
    bend: Floats
    share: Floats

    def bent(self, x: Floats) -> Floats:
        """The bent coordinate t of fractions x, same shape (..., C); straight below zero."""
        inside = np.maximum(x, 0.0)
        return (np.log1p(self.bend * inside) + self.bend * (x - inside)) / np.log1p(self.bend)

    def slope(self, x: Floats) -> Floats:
        """dt/dx, same shape (..., C)."""
        return self.bend / (1.0 + self.bend * np.maximum(x, 0.0)) / np.log1p(self.bend)

    def covariance(self, t: Floats, s: Floats) -> Floats:
        """k between bent points t (n, C) and s (m, C), shape (n, m)."""
        result = np.ones((len(t), len(s)))
        for c in range(t.shape[1]):
            step = (t[:, c, None] - s[None, :, c]) / self.length[c]
            result *= (1.0 + self.share[c] * np.exp(-0.5 * step * step)) / (1.0 + self.share[c])
        return result

    def parts(self, t: Floats, s: Floats) -> tuple[Floats, Floats, Floats]:
        """k (n, m), and relative to it the derivatives by t_c, and by t_c and s_c, each (C, n, m).

        By s_c the first one changes its sign; by t_c and s_d of two chambers it is minus the product of theirs.
        """
        value = np.ones((len(t), len(s)))
        first = np.empty((t.shape[1], len(t), len(s)))
        second = np.empty_like(first)
        for c in range(t.shape[1]):
            step = (t[:, c, None] - s[None, :, c]) / self.length[c]
            bell = self.share[c] * np.exp(-0.5 * step * step)
            value *= (1.0 + bell) / (1.0 + self.share[c])
            bell /= 1.0 + bell
            first[c] = -bell * step / self.length[c]
            second[c] = bell * (1.0 - step * step) / self.length[c] ** 2
        return value, first, second

    def with_slopes(self, t: Floats, s: Floats) -> Floats:
        """Covariance of values and slopes at t with values and slopes at s: (n (1 + C), m (1 + C)).

        Rows: n values, then n slopes by the first bent coordinate, and so on; columns alike.
        """
        value, first, second = self.parts(t, s)
        C, n, m = first.shape
        result = np.empty((1 + C, n, 1 + C, m))
        result[0, :, 0] = value
        for c in range(C):
            by_t = value * first[c]
            result[1 + c, :, 0] = by_t
            result[0, :, 1 + c] = -by_t
            for d in range(C):
                result[1 + c, :, 1 + d] = value * second[c] if c == d else -by_t * first[d]
        return result.reshape((1 + C) * n, (1 + C) * m)
