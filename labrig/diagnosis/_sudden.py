"""When the rig changed at one moment, for good or for a while: a fibre that breaks, something that lies on the body."""

from collections.abc import Iterator

import numpy as np

from labrig.arrays import Ints
from labrig.diagnosis._usual import as_pressures
from labrig.effects import (
    MOST_SESSIONS,
    Context,
    Rows,
    Space,
    Stretch,
    acting,
    errors_by_capture,
    pattern,
    pressure,
    stretch_of,
)

_SMALL = 1e-6
"""Share of how chambers move the rig that keeps those of which little is seen from any change; numerical."""


def sudden(context: Context) -> Iterator[Space]:
    """What each chamber does otherwise in the stretch that the residuals say, or where the body lies then."""
    found = changed(context) if context.moves else None
    if found is None:
        return
    held, x = found.holds(context.rows.capture)[:, None], context.rows.fraction
    features = [
        pressure("zero then", held * np.ones_like(x), 0.5),
        pressure("gain then", held * x),
        pressure("bend then", held * x * x, 0.5),
    ]
    key = f"a sudden change {found}"
    yield Space(key, "sudden", acting(features), 0.5, scanned=found.among, absolute=False)
    yield Space(key, "sudden place", (pattern("place then", held[:, 0]),), scanned=found.among)


def changed(context: Context) -> Stretch | None:
    """When each chamber did most otherwise with its own pressure, beside what is another in each session or pose."""
    rows = context.rows
    captures, error = errors_by_capture(context)
    x = rows.fraction[rows.first]
    change = as_pressures(context.jacobian[rows.first] * context.span, error, _SMALL)
    if change is None:
        return None
    phi = np.stack([np.ones_like(x), x], axis=2)
    return stretch_of(captures, change, phi, _parts(rows))


def _parts(rows: Rows) -> Ints:
    """Which captures (n,) have the same session, and the same of what was recorded that takes a few values only."""
    at = rows.first
    told = [rows.session[at].astype(float)]
    for covariate in rows.covariates.values():
        values = np.round(covariate.values[at], 3)
        if np.isfinite(values).all() and len(np.unique(values)) < MOST_SESSIONS:
            told.append(values)
    part = np.unique(np.stack(told, axis=1), axis=0, return_inverse=True)[1].reshape(-1)
    return part if part.max() < MOST_SESSIONS else np.zeros(len(at), dtype=np.int64)
