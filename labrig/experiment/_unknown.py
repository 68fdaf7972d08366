"""Where to look when nothing has a name: at what a smooth function of what was logged knows least about.

The function is that of the ceiling, kernel ridge regression, which is a Gaussian process; a probe is worth
what it is expected to say about it (its information gain, MacKay, Neural Computation 4 (1992) 590).
"""

from collections.abc import Sequence

import numpy as np
from scipy.linalg import cho_factor, cho_solve

from labrig._errors import LabrigError
from labrig.arrays import Floats, Ints
from labrig.diagnosis import STATIC, covariates, kernel
from labrig.experiment._plan import Probe
from labrig.experiment._problem import Problem
from labrig.experiment._search import Choice

_RIDGE = 0.1
_MOST_RUN_ROWS = 500
_VISITS = 2
"""Each probe is done twice, so that the noise floor is measured beside it."""


def search_unknown(
    problem: Problem, seeds: Sequence[Probe], budget_s: float, carried_by: str | None
) -> tuple[Choice, list[float]]:
    """The probes that say most about a function of what carries the error, and how much each says (nats).

    Without `carried_by` (a word of `_unnamed`), of everything that was logged. Raises `LabrigError` where no probe is
    done in the time.
    """
    probes = [p for p in seeds if p.seconds(problem.limits) <= budget_s]
    if not probes:
        shortest = min(p.seconds(problem.limits) for p in seeds) / 60
        raise LabrigError(
            f"no programme takes {budget_s / 60:g} min or less: the shortest takes {shortest:.2g}"
        )
    joint, planned = problem.joint([p.points for p in probes])
    sets = covariates(joint)
    features = sets.get(_covariates_of(carried_by or ""), list(sets.values())[-1])
    n_run = len(problem.context.rows.capture)
    kept = np.unique(np.linspace(0, n_run - 1, min(n_run, _MOST_RUN_ROWS)).astype(int))
    ahead = features[n_run:]
    known = features[kept]
    factor = cho_factor(kernel(known, known) + _RIDGE * np.eye(len(known)))
    cross = kernel(known, ahead)
    K = kernel(ahead, ahead) - cross.T @ cho_solve(factor, cross)
    seconds = np.array([p.seconds(problem.limits) for p in probes])
    own = [np.flatnonzero(planned.owner == i) for i in range(len(probes))]
    times, gains = [0] * len(probes), [0.0] * len(probes)
    used = 0.0
    while True:
        worth = np.array([_gain(K, rows) for rows in own]) / seconds
        worth[(used + _VISITS * seconds > budget_s) | (np.array(times) > 0)] = -np.inf
        best = int(np.argmax(worth))
        if not np.isfinite(worth[best]):
            break
        times[best] = _VISITS
        gains[best] = float(worth[best] * seconds[best])
        used += _VISITS * seconds[best]
        rows = own[best]
        seen = cho_factor(K[np.ix_(rows, rows)] + _RIDGE * np.eye(len(rows)))
        K = K - K[:, rows] @ cho_solve(seen, K[rows])
    if not any(times):
        times[int(np.argmin(seconds))] = 1
    chosen = [i for i, n in enumerate(times) if n]
    choice = Choice(tuple(probes[i] for i in chosen), tuple(times[i] for i in chosen), sum(gains))
    return choice, [gains[i] for i in chosen]


def _covariates_of(carried_by: str) -> str:
    """The set of covariates that a function of what carries an error is to be learnt from."""
    if not carried_by:
        return ""
    if "history" in carried_by or "hold" in carried_by:
        return "pressure, time in hold, history"
    return "pressure, time in session" if carried_by.startswith(("time", "a sudden")) else STATIC


def in_words(carried_by: str) -> str:
    """What carries an error, as a sentence takes it."""
    if carried_by == "form":
        return "the base's own form, each chamber's pressure"
    return "what follows nothing that was recorded" if carried_by.startswith("nothing") else carried_by


def _gain(K: Floats, rows: Ints) -> float:
    """Information about the function in rows with posterior covariance K, nats."""
    own = K[np.ix_(rows, rows)]
    _, logdet = np.linalg.slogdet(np.eye(len(rows)) + (own + own.T) / (2 * _RIDGE))
    return 0.5 * float(logdet)
