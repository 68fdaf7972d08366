"""A black box that learns the base's residuals: it lowers the error and names nothing."""

import numpy as np

from labrig.arrays import Floats
from labrig.effects import Rows

_COMPONENTS = 6


def _features(rows: Rows) -> Floats:
    """Pressures now and before, the step, time in hold and time in session, (F, ...)."""
    before = np.maximum(rows.event - 1, 0)
    previous = rows.event_actuation[before]
    hold, time_s = np.nan_to_num(rows.hold_s), np.nan_to_num(rows.time_s)
    clock = np.stack([hold, np.log1p(hold), time_s], axis=1)
    return np.concatenate([rows.actuation, previous, rows.actuation - previous, clock], axis=1)


def learned_error(
    rows: Rows, base: Floats, fresh: Rows, fresh_base: Floats, noisier: Floats | float = 1.0
) -> float | None:
    """Error (rms over captures' means) on the fresh campaign after the residuals of the first were learned.

    Extremely randomised trees on the leading principal components of the residuals, each over how `noisier` its
    observable (K,) is. None without scikit-learn.
    """
    try:
        from sklearn.ensemble import ExtraTreesRegressor
    except ImportError:
        return None
    left = (rows.values - base) / noisier
    seen = np.isfinite(left)
    middle = np.nanmedian(left, axis=0) if seen.all(axis=1).any() else np.zeros(left.shape[1])
    filled = np.where(seen, left, middle)
    spread = 1.4826 * np.median(np.abs(filled - middle))
    filled = np.clip(filled, middle - 8.0 * spread, middle + 8.0 * spread)
    directions = np.linalg.svd(filled - middle, full_matrices=False)[2][:_COMPONENTS]
    trees = ExtraTreesRegressor(n_estimators=100, min_samples_leaf=3, n_jobs=1, random_state=0)
    wanted = (filled - middle) @ directions.T
    trees.fit(_features(rows), wanted[:, 0] if wanted.shape[1] == 1 else wanted)
    score = trees.predict(_features(fresh)).reshape(len(fresh.values), -1)
    return capture_error(fresh, fresh_base + (middle + score @ directions) * noisier, noisier)


def capture_error(rows: Rows, predicted: Floats, noisier: Floats | float = 1.0) -> float:
    """Root mean square, over captures and observables, of the mean residual of each hold, each observable (K,) over how
    `noisier` it is.
    """
    left = (rows.values - predicted) / noisier
    seen = np.isfinite(left)
    captures = int(rows.capture.max()) + 1
    total, count = np.zeros((captures, left.shape[1])), np.zeros((captures, left.shape[1]))
    np.add.at(total, rows.capture, np.where(seen, left, 0.0))
    np.add.at(count, rows.capture, seen)
    mean = total[count > 0] / count[count > 0]
    return float(np.sqrt(np.mean(mean**2)))
