"""What a body remembers of a campaign: lags, plays, and the path with moments in between.

A path tells the whole story, pauses between sessions included; before its first moment the rig was vented for long.
"""

import numpy as np
from scipy.optimize import nnls

from labrig.arrays import Floats, Ints
from labrig.bench._nature import Path, Setting


def pauses(path: Path) -> Floats:
    """The time (T,) since the moment before, in s."""
    return np.diff(path.time_s, prepend=path.time_s[0])


def a_moment_s(setting: Setting) -> float:
    """A moment just before some measured row between a fifth and three quarters of a campaign, in s."""
    rows_s = setting.path.time_s[setting.path.row]
    return float(rows_s[int(setting.random.uniform(0.2, 0.75) * len(rows_s))]) - 0.3


def steps(drive: Floats) -> Floats:
    """The change (T, C) of a drive since the moment before."""
    return np.diff(drive, axis=0, prepend=np.zeros((1, drive.shape[1])))


def finely(path: Path, drive: Floats, largest: float) -> tuple[Floats, Floats, Ints]:
    """The steps (N, C) and pauses (N,) of a drive cut so that none moves by more, and where the T moments are in N."""
    whole = steps(drive)
    parts = np.maximum(1, np.ceil(np.abs(whole).max(axis=1) / largest)).astype(int)
    of = np.repeat(np.arange(len(parts)), parts)
    return (whole / parts[:, None])[of], (pauses(path) / parts)[of], np.cumsum(parts) - 1


def lagged(path: Path, drive: Floats, tau_s: Floats) -> Floats:
    """The drive (T, C) as it is after exponential lags: (T, N, C) for `tau_s` (N,), or (N, C) by chamber."""
    tau = np.maximum(tau_s.reshape(len(tau_s), -1), 1e-9)
    share = -np.expm1(-pauses(path)[:, None, None] / tau)
    state = np.zeros((len(tau_s), drive.shape[1]))
    out = np.empty((len(drive), *state.shape))
    for i in range(len(drive)):
        state = state + share[i] * (drive[i] - state)
        out[i] = state
    return out


UNIT_S = 60.0
"""Chains below yield 1 in all after a minute under constant load."""


def as_chain(compliance: Floats, time_s: Floats) -> tuple[Floats, Floats]:
    """A retarded compliance at times (N,) as a chain: its times in s and how much each yields, 1 in a minute in all."""
    tau_s = np.geomspace(0.3, 3e4, 16)
    # such fits are so nearly alike that three turns for each of them, the usual limit, are now and then too few
    yields = nnls(-np.expm1(-time_s[:, None] / tau_s), compliance, maxiter=100 * len(tau_s))[0]
    return in_a_minute(tau_s[yields > 0], yields[yields > 0])


def in_a_minute(tau_s: Floats, yields: Floats) -> tuple[Floats, Floats]:
    """A chain, scaled so that it yields 1 in a minute."""
    return tau_s, yields / np.sum(yields * -np.expm1(-UNIT_S / tau_s))


def plays(drive: Floats, half_width: Floats) -> Floats:
    """The drive (T, C) behind plays: (T, N, C) for half widths (N, C)."""
    state = np.zeros_like(half_width)
    out = np.empty((len(drive), *state.shape))
    low, high = drive[:, None] - half_width, drive[:, None] + half_width
    for i in range(len(drive)):
        state = np.minimum(np.maximum(state, low[i]), high[i])
        out[i] = state
    return out
