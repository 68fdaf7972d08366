"""What is another in each session (a day, a specimen, a mounting): its columns, and which sessions have no value."""

import numpy as np

from labrig.arrays import Floats
from labrig.effects._context import Context
from labrig.effects._rows import Rows

MOST_SESSIONS = 11
"""Of more sessions than this none has a value of its own: whole sessions are left out in turn then."""
_FEWEST = 3  # captures in a session, in the mean: one alone tells a session from nothing else
IN_EACH = ", in each session"


def in_sessions(context: Context) -> Floats | None:
    """Which rows lie in which session, (F, sessions) of 0 and 1.

    None where there is one session, or too many, or where something that was recorded (a payload, a mounting angle)
    tells the sessions apart: what it does can't be told from what is another in each. Where a saved effect is
    evaluated, they are always there.
    """
    rows = context.rows
    count = len(rows.sessions)
    enough = 1 < count <= min(MOST_SESSIONS, rows.n_captures / _FEWEST)
    if not context.shows(enough and not any(_tells_apart(rows, c.values) for c in rows.covariates.values())):
        return None
    return (rows.session[:, None] == np.arange(count)).astype(float)


def _tells_apart(rows: Rows, values: Floats) -> bool:
    """Whether values (F,) stay the same within each session and do not in all."""
    within = max(float(np.ptp(values[rows.session == s])) for s in np.unique(rows.session))
    return bool(np.isfinite(within) and within < 1e-9 * (1e-12 + np.ptp(values)))


def keys(context: Context) -> tuple[str, ...]:
    """The sessions' names, which are no other run's."""
    return context.rows.session_keys or context.rows.sessions


def labels(context: Context, parts: tuple[str, ...] = ()) -> tuple[str, ...]:
    """A label for each session, or for each part of each: `DAY`, `DAY: x`."""
    return tuple(f"{key}: {part}" for key in keys(context) for part in parts) if parts else keys(context)


def without_value(context: Context, known: tuple[str, ...]) -> list[str]:
    """The sessions of a run that none of the labels of a saved value is about."""
    return [key for key in keys(context) if not any(n == key or n.startswith(f"{key}: ") for n in known)]
