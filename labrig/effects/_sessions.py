"""What is another in each session (a day, a specimen, a mounting): its columns, and which sessions have no value."""

import numpy as np

from labrig.arrays import Floats
from labrig.effects._context import Context

MOST_SESSIONS = 11
"""Of more sessions than this none has a value of its own: whole sessions are left out in turn then."""
_FEWEST = 3  # captures in a session, in the mean: one alone tells a session from nothing else
IN_EACH = ", in each session"


def in_sessions(context: Context) -> Floats | None:
    """Which rows lie in which session, (F, sessions) of 0 and 1; None where there is one session, or too many.

    Where a saved effect is evaluated, one session is enough.
    """
    count = len(context.rows.sessions)
    if not context.shows(1 < count <= min(MOST_SESSIONS, context.rows.n_captures / _FEWEST)):
        return None
    return (context.rows.session[:, None] == np.arange(count)).astype(float)


def keys(context: Context) -> tuple[str, ...]:
    """The sessions' names, which are no other run's."""
    return context.rows.session_keys or context.rows.sessions


def labels(context: Context, parts: tuple[str, ...] = ()) -> tuple[str, ...]:
    """A label for each session, or for each part of each: `DAY`, `DAY: x`."""
    return tuple(f"{key}: {part}" for key in keys(context) for part in parts) if parts else keys(context)


def without_value(context: Context, known: tuple[str, ...]) -> list[str]:
    """The sessions of a run that none of the labels of a saved value is about."""
    return [key for key in keys(context) if not any(n == key or n.startswith(f"{key}: ") for n in known)]
