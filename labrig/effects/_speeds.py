"""How fast what was logged as a position moves."""

import numpy as np

from labrig.arrays import Floats
from labrig.effects._rows import Rows

LENGTHS = {"m", "cm", "mm", "um", "deg", "rad"}
_NO_MOTION = {"tilt", "orientation"}
_FEWEST = 5
_HALF = 2


def speeds(rows: Rows) -> dict[str, tuple[Floats, float]]:
    """Of each covariate that is a length or an angle its speed per s (F,), and its range; none that is not finite."""
    out = {}
    for name, cov in rows.covariates.items():
        if cov.unit not in LENGTHS or name.lower() in _NO_MOTION:
            continue
        speed = np.zeros(len(cov.values))
        for s in np.unique(rows.session):
            own = np.flatnonzero(rows.session == s)
            if len(own) >= _FEWEST:
                t = rows.time_s[own]
                dated = np.isfinite(t).all() and (np.diff(t) > 0).all()
                speed[own] = np.gradient(
                    _smooth(cov.values[own]), t if dated else np.arange(len(own), dtype=float)
                )
        if np.isfinite(speed).all():
            out[name] = (speed, float(np.ptp(cov.values)))
    return out


def _smooth(x: Floats) -> Floats:
    """Running mean over five samples; at the ends the first and the last one are repeated."""
    return np.convolve(
        np.pad(x, _HALF, mode="edge"), np.full(2 * _HALF + 1, 1 / (2 * _HALF + 1)), mode="valid"
    )
