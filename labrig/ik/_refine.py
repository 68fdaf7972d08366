"""Closer on the rig itself: Broyden's method on what scans show, begun with the model's derivatives.

As in arXiv 2205.05166, with more to begin with: the derivatives of the heights over the target by the pressures come
from the model once, and every scan corrects them along the step that led to it.
"""

import numpy as np

from labrig._linalg import svd
from labrig.arrays import Floats

_DAMPING = 3e-3
_REACH = 0.25
"""How far a pressure may go from one scan to the next, as a share of its range."""
_TUKEY = 6.0


class Refinement:
    """Proposes pressures from heights (V,), mm, of the realised surface over points of the target.

    `slope` (V, C), mm/kPa: the model's derivatives of these heights; `low`, `high` (C,) limits. Heights may be NaN
    where a scan shows nothing. Registering a scan takes a rigid motion away, so `motions` (V, 6), the heights that
    small motions make, are taken out of the derivatives as well.
    """

    def __init__(self, slope: Floats, motions: Floats, low: Floats, high: Floats) -> None:
        U, size, _ = svd(np.nan_to_num(motions))
        basis = U[:, size > 1e-9 * max(float(size.max(initial=0.0)), 1e-12)]
        known = np.nan_to_num(slope)
        self._slope = known - basis @ (basis.T @ known)
        self._low, self._high = low, high
        self._last: tuple[Floats, Floats] | None = None
        self.best: tuple[float, Floats] | None = None

    def propose(self, pressure_kpa: Floats, height_mm: Floats) -> Floats:
        """Take in what a scan at some pressures showed; returns the pressures to try next, (C,).

        Steps begin at the best pressures so far.
        """
        self._learn(pressure_kpa, height_mm)
        misfit = float(np.nanmean(np.abs(height_mm)))
        if self.best is None or misfit < self.best[0]:
            self.best, self._from = (misfit, pressure_kpa.copy()), height_mm
        start, height = self.best[1], self._from
        weight = _weights(height)
        known = np.nan_to_num(height)
        span = self._high - self._low
        J = self._slope * span
        H = (J * weight[:, None]).T @ J
        H += _DAMPING * np.trace(H) / len(H) * np.eye(len(H))
        g = (J * weight[:, None]).T @ known
        x, low, high = start / span, self._low / span, self._high / span
        step = _bounded(H, g, np.maximum(low - x, -_REACH), np.minimum(high - x, _REACH))
        return np.asarray(np.clip(start + step * span, self._low, self._high), np.float64)

    def _learn(self, pressure: Floats, height: Floats) -> None:
        """Broyden's update: the derivatives that explain the last change and differ least from the old ones."""
        if self._last is not None:
            step = pressure - self._last[0]
            length = float(step @ step)
            both = np.isfinite(height) & np.isfinite(self._last[1])
            if length > 1e-6 and both.any():
                surprise = np.where(both, np.nan_to_num(height - self._last[1]) - self._slope @ step, 0.0)
                self._slope = self._slope + np.outer(surprise, step) / length
        self._last = (pressure.copy(), height.copy())


def _weights(height: Floats) -> Floats:
    known = np.isfinite(height)
    centre = np.nanmedian(height)
    spread = 1.4826 * np.nanmedian(np.abs(height - centre)) + 0.1
    x = np.nan_to_num(height) / (_TUKEY * spread + abs(centre))
    return np.where(known & (np.abs(x) < 1.0), (1.0 - x**2) ** 2, 0.0)


def _bounded(H: Floats, g: Floats, low: Floats, high: Floats) -> Floats:
    """The minimum of x H x / 2 + g x within bounds, one coordinate after the other until nothing changes."""
    x = np.asarray(np.clip(-np.linalg.solve(H, g), low, high), np.float64)
    for _ in range(200):
        before = x.copy()
        for i in range(len(x)):
            x[i] = np.clip(x[i] - (H[i] @ x + g[i]) / H[i, i], low[i], high[i])
        if np.abs(x - before).max() < 1e-9:
            break
    return x
