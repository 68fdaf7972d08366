"""Sensors that always say the same, chambers that never change, and those that only change together."""

from dataclasses import replace

import numpy as np

from labrig.effects import Context, Rows

_ALIKE = 0.999
"""Correlation of the set-points of chambers that move together."""
_STILL = 1e-9
"""Change of a prediction, as a share of its size, that is rounding."""


def without_dead(context: Context, fitted: bool = False) -> Context:
    """The campaign without observables that never change where the model says that they do, or sensors where the model
    is `fitted` to them; the rows' warnings name them, and chambers whose set-point never changes.
    """
    rows = context.rows
    seen = np.isfinite(rows.values)
    measured, base = (
        np.where(seen, v, -np.inf).max(axis=0, initial=-np.inf)
        - np.where(seen, v, np.inf).min(axis=0, initial=np.inf)
        for v in (rows.values, context.base)
    )
    moves = base > _STILL * np.abs(context.base).max(axis=0, initial=0.0)
    moves |= fitted & (rows.marker < 0)
    dead = (measured == 0) & moves & (seen.sum(axis=0) > 1)
    said = [
        f"chamber {name} is at {rows.event_actuation[0, c]:.3g} {rows.actuation_unit} all the time: nothing can be "
        "said of it"
        for c, name in enumerate(rows.chambers)
        if np.ptp(rows.event_actuation[:, c]) == 0 and len(rows.event_actuation) > 1
    ]
    said += _together(rows)
    if dead.size and dead.all():
        first = rows.observables[0] + (f" (and {len(dead) - 1} more)" if len(dead) > 1 else "")
        said.append(f"{first} never changes, where the model says that it does: are the sensors connected?")
    if dead.all() or not dead.any():
        return replace(context, rows=replace(rows, warnings=(*rows.warnings, *said))) if said else context
    where = "" if fitted else ", where the model says that it changes"
    said += [
        f"{rows.observables[k]} is {rows.values[seen[:, k], k][0]:.3g} {rows.unit[k]} all the time{where}: it is left "
        "out; is its sensor connected?"
        for k in np.flatnonzero(dead)
    ]
    values = np.where(dead, np.nan, rows.values)
    return replace(context, rows=replace(rows, values=values, warnings=(*rows.warnings, *said)))


def _together(rows: Rows) -> list[str]:
    """A line for each group of chambers whose set-points only change together."""
    u = rows.event_actuation
    moved = np.flatnonzero(np.ptp(u, axis=0) > 0) if len(u) > 1 else np.zeros(0, dtype=np.int64)
    if len(moved) < 2:
        return []
    alike = np.asarray(np.corrcoef(u[:, moved].T) > _ALIKE, dtype=bool)
    groups = {tuple(rows.chambers[c] for c in moved[row]) for row in alike if row.sum() > 1}
    return [
        f"chambers {', '.join(names[:-1])} and {names[-1]} only moved together: what is missing of one may be "
        "another's, and where they are apart the model may be off by more than these errors say; move each alone in "
        "some set-points"
        for names in sorted(groups)
    ]
