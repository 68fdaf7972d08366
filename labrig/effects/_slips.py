"""Which markers may have slipped, and when: alone, with their neighbours on one plate, or several at one moment."""

from collections.abc import Iterator
from dataclasses import dataclass
from math import comb

import numpy as np

from labrig._gaps import filled
from labrig.arrays import Bools, Floats, Ints
from labrig.effects._context import Context
from labrig.effects._rows import Rows, capture_means

_ON_A_PLATE = 4
_MOST_OF_ALL = 0.6
"""Share of all markers and sensors from which on a group is no few against the others."""
_ALONE = 2
"""How many single markers are asked about: the clearest."""
_DEARER = 2.0
"""What each further coordinate that may step has to explain more, in units of its noise: about its own chance gain."""


def errors_by_capture(context: Context) -> tuple[Ints, Floats]:
    """The captures, and the mean residual of each (n, K), what was not seen filled by what is like it."""
    means, captures = capture_means(context.residual, context.rows.capture)
    return captures, filled(means)


def moment(rows: Rows, capture: int) -> float:
    """The moment half-way between the last row before a capture and its first, s."""
    before, after = rows.time_s[rows.capture < capture].max(), rows.time_s[rows.capture >= capture].min()
    return round(float(before + after) / 2, 3)


@dataclass(frozen=True)
class Slip:
    """Markers that stepped: `first` is the first capture after it, counted from 0, `again` those of further steps,
    `among` how many groups and moments it was chosen from.
    """

    group: tuple[int, ...]
    first: int
    again: tuple[int, ...]
    among: int


def slips(rows: Rows, error: Floats) -> list[Slip]:
    """The clearest steps of a few markers in their errors by capture (n, K), the clearest first."""
    markers = np.unique(rows.marker[rows.marker >= 0])
    among = 2 * len(markers) * len(error)
    groups = dict.fromkeys(group for m in markers for group in _near(rows, m))
    looked = [one for group in groups if (one := _looked_at(rows, error, group, among)) is not None]
    if not looked:
        return []
    knocked = _knocked(rows, error)
    if knocked and knocked not in groups:
        sets = comb(len(markers), len(knocked)) * len(error)
        looked += [one for one in [_looked_at(rows, error, knocked, sets)] if one is not None]
    looked.sort(key=lambda one: -one.clear)
    alone = [one for one in looked if len(one.group) == 1][:_ALONE]
    several = (
        looked[:1] if len(looked[0].group) > 1 else []
    )  # only where they are clearer than each by itself
    return [one.slip for one in several + alone]


@dataclass(frozen=True)
class _Look:
    """What a step after each capture explains of a group, `gain` (n - 1,), and what it has to, by chance: `dear`."""

    group: tuple[int, ...]
    e: Floats
    gain: Floats
    dear: float
    among: int

    @property
    def clear(self) -> float:
        return float(self.gain.max()) - self.dear

    @property
    def slip(self) -> Slip:
        i = int(np.argmax(self.gain))
        again = tuple(j + 1 for j in _more_steps(self.e, i))
        return Slip(self.group, i + 1, again, self.among)


def _looked_at(rows: Rows, error: Floats, group: tuple[int, ...], among: int) -> _Look | None:
    """A group beside all others; None where it is most of all that is seen."""
    own = np.isin(rows.marker, group)
    if len(group) > _MOST_OF_ALL * (len(np.unique(rows.marker[rows.marker >= 0])) + (rows.marker < 0).sum()):
        return None
    e = _beside_others(error, own)
    return _Look(group, e, step_gain(e), _DEARER * float(own.sum()), among)


def _near(rows: Rows, marker: int) -> Iterator[tuple[int, ...]]:
    """A marker by itself, and with its three nearest neighbours, as on one plate."""
    yield (int(marker),)
    if rows.rest_mm is not None and np.isfinite(rows.rest_mm).all() and marker < len(rows.rest_mm):
        away = np.linalg.norm(rows.rest_mm - rows.rest_mm[int(marker)], axis=1)
        yield tuple(sorted(int(m) for m in np.argsort(away)[:_ON_A_PLATE]))


def _knocked(rows: Rows, error: Floats) -> tuple[int, ...]:
    """The few markers, two at least, that step at one moment against the middle of all; none where there is none."""
    e = error.copy()
    for axis in range(3):
        own = rows.axis == axis
        if own.any():
            e[:, own] -= np.median(e[:, own], axis=1, keepdims=True)
    e = in_scatters(e)
    markers = np.unique(rows.marker[rows.marker >= 0])
    gains = np.stack([step_gain(e[:, rows.marker == m]) for m in markers], axis=1)
    coordinates = np.array([(rows.marker == m).sum() for m in markers])
    chance = coordinates + 2 * np.log(
        len(markers) * len(e)
    )  # the largest of so many by chance, in scatters squared
    stepped = gains > chance
    few = (stepped.sum(axis=1) > 1) & (stepped.sum(axis=1) <= len(markers) / 3)
    if not few.any():
        return ()
    at = int(np.argmax(np.where(few, (gains * stepped).sum(axis=1), -1.0)))
    return tuple(int(m) for m in markers[stepped[at]])


def in_scatters(e: Floats) -> Floats:
    """Errors by capture (n, K) about their middle, in units of their own scatter from one capture to the next."""
    e = e - np.median(e, axis=0)
    spread = 1.4826 * np.median(np.abs(np.diff(e, axis=0)), axis=0) / np.sqrt(2) + 1e-12
    return np.clip(e / spread, -30, 30)


def _beside_others(error: Floats, own: Bools) -> Floats:
    """What some observables' errors by capture have that the others' do not say, in units of their own scatter."""
    A = error[:, ~own]
    _, U = np.linalg.eigh(A.T @ A)
    Z = np.column_stack([A @ U[:, -min(6, A.shape[1]) :], np.ones(len(A))])
    ridge = 1e-2 * np.trace(Z.T @ Z) / len(Z.T) * np.eye(Z.shape[1])
    e = error[:, own] - Z @ np.linalg.solve(Z.T @ Z + ridge, Z.T @ error[:, own])
    return in_scatters(e)


def gain_of_cuts(e: Floats) -> Floats:
    """How much less of the square of e (n, K) two means leave than one, if it is cut after each entry, (n - 1,)."""
    n = np.arange(1, len(e))
    return (np.cumsum(e - e.mean(axis=0), axis=0)[:-1] ** 2).sum(axis=1) * len(e) / (n * (len(e) - n))


def step_gain(e: Floats) -> Floats:
    """How much a step after each capture explains; nearer to an end it can't be told from an offset, or from chance."""
    gain = gain_of_cuts(e)
    edge = max(3, len(e) // 10)
    gain[:edge] = gain[-edge:] = 0
    return gain


def _more_steps(e: Floats, first: int) -> list[int]:
    """Where the two pieces beside a first step are best cut again."""
    out = []
    for begin, end in ((0, first + 1), (first + 1, len(e))):
        piece = e[begin:end]
        if len(piece) < 8:
            continue
        at = begin + int(np.argmax(gain_of_cuts(piece)[2:-2])) + 2
        if at >= len(e) // 10:
            out.append(at)
    return out
