"""A tone: what swings in a record at a frequency of its own, whatever the inputs do. A pump, a fan, the mains.

It has no name, and is no noise either: it is told by where its line stands in the spectrum.
"""

from collections.abc import Iterator
from itertools import combinations_with_replacement
from typing import Any

import numpy as np
from scipy.ndimage import maximum_filter1d
from scipy.optimize import minimize_scalar
from scipy.special import gammainccinv

from labrig.arrays import Floats, Ints
from labrig.diagnosis._observations import Observations
from labrig.effects import Feature, Space, acting, pattern

TONE = "tone"
"""What swings at a frequency of its own."""
_SIDE, _AWAY = 24, 3
"""Frequencies on each side of a line that say what is usual there, and how many next to it are the line's own: the
window spreads it over two (F. J. Harris, Proceedings of the IEEE 66, 1978). Numerical."""
_FEWEST = 128
"""Rows from which on a spectrum is looked at; numerical."""
_BY_CHANCE = 0.001
"""How probable so high a line, anywhere in the spectrum of what has none, may be."""
_TIMES = 10.0
"""How many times the share of the power that anything of the inputs has there a tone has of that of the errors."""
_MOST = 3
"""Tones at most, the strongest: what swings in no sine has its harmonics, too."""


def tones(observations: Observations) -> Iterator[Space]:
    """One space: all tones, each a swing of its own size and phase in every observable and session, which may slowly
    change.

    Of records without holds alone, and looked for in the longest session. A line of the errors is a tone where they
    have far more of their power there than anything that goes by the inputs has.
    """
    rows = observations.context.rows
    if not observations.context.sample_s:
        return
    session = rows.session
    own = np.flatnonzero(session == np.bincount(session).argmax())
    time_s = rows.time_s[own]
    if len(own) < _FEWEST or not np.isfinite(time_s).all():
        return
    errors = observations.values[observations.index[own]][:, observations.seen]
    grid_s = np.linspace(time_s.min(), time_s.max(), len(time_s))
    power = _power(_even(grid_s, time_s, errors))
    alone = _share(power) > _TIMES * _of_inputs(_even(grid_s, time_s, rows.fraction[own]))
    bins = [b for b in _lines(_prominence(power)) if alone[b]][:_MOST]
    found_hz = [_exact(b / np.ptp(grid_s), time_s, errors) for b in bins]
    if found_hz:
        features = [swing for hz in found_hz for swing in _swings(hz, rows.time_s, session)]
        step_s = float(np.median(np.diff(np.sort(time_s))))
        key = _words(found_hz[0], round(step_s / observations.context.sample_s))
        yield Space(key, TONE, acting(features), scanned=len(time_s) // 2)


def _words(strongest_hz: float, every: int) -> str:
    """What carries it, where of a long record one row of so many was looked at: what is faster looks slower then."""
    alias = f" (or faster: one row of {every} is looked at)" if every > 1 else ""
    return f"a swing of {strongest_hz:.3g} Hz that no input has{alias}"


def _even(grid_s: Floats, time_s: Floats, values: Floats) -> Floats:
    """Values (n, q) at moments that are even."""
    order = np.argsort(time_s)
    return np.stack([np.interp(grid_s, time_s[order], v[order]) for v in values.T], axis=1)


def _power(values: Floats) -> Floats:
    """The spectrum (f, q) of each column of even moments."""
    from scipy.signal import periodogram

    return periodogram(values, window="hann", detrend="linear", axis=0)[1]


def _share(power: Floats) -> Floats:
    """How much of all columns' power is at each frequency, (f,)."""
    together = power.sum(axis=1)
    return together / max(together.sum(), 1e-300)


def _prominence(power: Floats) -> Floats:
    """A spectrum (f, q) as a multiple of what is usual beside each frequency; of what has no line its distribution is
    exponential, of mean one. None at the ends, where nothing is beside.
    """
    beside = np.arange(_AWAY, _AWAY + _SIDE)
    inner = np.arange(beside[-1], len(power) - beside[-1])
    usual = np.median(power[inner[:, None] + np.concatenate([-beside, beside])], axis=1) / np.log(2.0)
    out = np.zeros_like(power)
    out[inner] = power[inner] / np.maximum(usual, 1e-300)
    return out


def _lines(power: Floats) -> list[int]:
    """Frequencies, by number, at which all columns (f, q) together have a line; the highest first, each once."""
    together = power.sum(axis=1)
    least = float(gammainccinv(power.shape[1], _BY_CHANCE / len(power)))
    out: list[int] = []
    for f in np.argsort(-together).tolist():
        if together[f] < least:
            break
        if all(abs(f - other) > _AWAY for other in out):
            out.append(f)
    return out


def _of_inputs(x: Floats) -> Floats:
    """The largest share (f,) of its power that anything which goes by the inputs (n, C) has about each frequency: them,
    what has summed them up, their speeds and accelerations, their ways, and products.
    """
    speed = np.gradient(x, axis=0)
    parts = [*x.T, *np.sign(speed).T]
    products = [a * b for a, b in combinations_with_replacement(parts, 2)]
    summed = np.cumsum(x - x.mean(axis=0), axis=0)
    made = [*parts, *products, *summed.T, *speed.T, *np.abs(speed).T, *np.gradient(speed, axis=0).T]
    shares = [_share(_power(each[:, None])) for each in made]
    return maximum_filter1d(np.max(shares, axis=0), 2 * _AWAY + 1)


def _exact(hz: float, time_s: Floats, errors: Floats) -> float:
    """The frequency within a line at which a swing takes most off the errors (n, K)."""
    width = 1 / np.ptp(time_s)

    def left(f: float) -> float:
        """The square of what is left beside a swing."""
        swing = np.stack([np.cos(2 * np.pi * f * time_s), np.sin(2 * np.pi * f * time_s)], axis=1)
        return float(np.square(errors - swing @ np.linalg.lstsq(swing, errors, rcond=None)[0]).sum())

    least: Any = minimize_scalar(left, bounds=(hz - width, hz + width), method="bounded")
    return float(least.x)


def _swings(hz: float, time_s: Floats, session: Ints) -> Iterator[Feature]:
    """A swing of each session, which may grow or fade along it."""
    for s in np.unique(session):
        own = session == s
        along = np.zeros(len(time_s))
        along[own] = time_s[own] - time_s[own].mean()
        along /= np.abs(along).max() or 1.0
        for name, wave in (("cosine", np.cos), ("sine", np.sin)):
            values = np.where(own, wave(2 * np.pi * hz * time_s), 0.0)
            yield pattern(f"{name} {hz:.4g} {s}", values)
            yield pattern(f"{name} {hz:.4g} {s} along", values * along, 0.3)
