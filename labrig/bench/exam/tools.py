"""Small tools that the laws of the exam share: the past of a load, lags, confined states, markers as points."""

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray
from scipy.linalg import solve_banded

from labrig.arrays import Floats, Ints
from labrig.bench._nature import Path, Rig, Setting


@dataclass(frozen=True)
class History:
    """The past of a load at N moments: the path's own, and two vented ones before each session's first."""

    time_s: Floats
    load: Floats
    keep: Ints

    @property
    def step_s(self) -> Floats:
        """The time (N - 1,) between the moments, never negative."""
        return np.maximum(np.diff(self.time_s), 0.0)

    def back(self, states: Floats) -> Floats:
        """States (N, ...) at the path's own moments, (T, ...)."""
        return states[self.keep]


def history(path: Path, load: Floats) -> History:
    """The past of a load (T, C), with the rig vented between the sessions and before the first."""
    starts = np.flatnonzero(np.diff(path.session, prepend=path.session[0] - 1))
    before = np.where(starts > 0, path.time_s[starts - 1], path.time_s[0] - 3.0)
    edge = np.clip((path.time_s[starts] - before) / 3, 0.0, 1.0)
    vents = np.column_stack([before + edge, path.time_s[starts] - edge]).ravel()
    where = np.repeat(starts, 2)
    keep = np.arange(len(path.time_s)) + 2 * np.searchsorted(
        starts, np.arange(len(path.time_s)), side="right"
    )
    return History(np.insert(path.time_s, where, vents), np.insert(load, where, 0.0, axis=0), keep)


def recursion(decay: NDArray[np.inexact], push: NDArray[np.inexact]) -> NDArray[np.inexact]:
    """States x (N, C) with x[0] = push[0] and x[n] = decay[n - 1] x[n - 1] + push[n]; decay (N - 1,)."""
    bands = np.ones((2, len(push)), dtype=np.result_type(decay, push))
    bands[1, :-1] = -decay
    bands[1, -1] = 0.0
    return solve_banded((1, 0), bands, push, check_finite=False)


def _lag_terms(ratio: NDArray[np.inexact]) -> tuple[NDArray[np.inexact], NDArray[np.inexact]]:
    """The decay over a step of `ratio` time constants, and its mean over the step."""
    decay = np.exp(-ratio)
    safe = np.where(np.abs(ratio) > 1e-9, ratio, 1.0)
    return decay, np.where(np.abs(ratio) > 1e-9, (1 - decay) / safe, 1.0)


def lagged(step_s: Floats, load: Floats, tau_s: complex) -> NDArray[np.inexact]:
    """The lag x' = (load - x) / tau of loads (N, C) that run straight between the moments, from load[0] on."""
    decay, mean = _lag_terms(step_s / tau_s)
    push = (mean - decay)[:, None] * load[:-1] + (1 - mean)[:, None] * load[1:]
    return recursion(decay, np.concatenate([load[:1].astype(push.dtype), push]))


def lagged_each(step_s: Floats, load: Floats, tau_s: float) -> Floats:
    """As `lagged`, with a clock of its own for each chamber: step_s (N - 1, C)."""
    columns = [lagged(step_s[:, c], load[:, c : c + 1], tau_s)[:, 0].real for c in range(load.shape[1])]
    return np.column_stack(columns)


def confined(lower: Floats, upper: Floats) -> Floats:
    """States (N, ...) that move only when a bound pushes them: the least motion between lower and upper."""
    states = np.empty_like(lower)
    state = np.clip(0.0, lower[0], upper[0])
    for n in range(len(lower)):
        state = np.minimum(np.maximum(state, lower[n]), upper[n])
        states[n] = state
    return states


def stopped(load: Floats, width: Floats) -> Floats:
    """The stop operators (N, J, C) of a load (N, C), each between -width and width (J,), from zero on."""
    centre, half = load[:, None, :], width[None, :, None]
    return centre - confined(centre - half, centre + half)


def chosen(random: np.random.Generator, count: int, share: float) -> Floats:
    """A mask (count,) of ones and zeros: about this share of the chambers, one at least."""
    many = max(1, round(share * count))
    mask = np.zeros(count)
    mask[random.permutation(count)[:many]] = 1.0
    return mask


class Body:
    """The markers of a rig as points in space."""

    def __init__(self, rig: Rig) -> None:
        rest = rig.rest_mm if rig.rest_mm is not None else np.zeros((1, 3))
        self.rest = np.asarray(rest, dtype=float)
        self.zero = rig.at_rest
        self.column = np.array([k for k, seen in enumerate(rig.observables) if seen.marker >= 0], dtype=int)
        self.marker = np.array([rig.observables[k].marker for k in self.column], dtype=int)
        self.axis = np.array([rig.observables[k].axis for k in self.column], dtype=int)
        self.centre = self.rest.mean(axis=0)
        self.size = float(np.sqrt(((self.rest - self.centre) ** 2).sum(axis=1).mean())) or 1.0
        _, self.spread, self.principal = np.linalg.svd(self.rest - self.centre, full_matrices=True)

    def moved(self, values: Floats) -> Floats:
        """How far each marker is from where it rests, (T, M, 3)."""
        away = np.zeros((len(values), len(self.rest), 3))
        away[:, self.marker, self.axis] = values[:, self.column] - self.zero[self.column]
        return away

    def points(self, values: Floats) -> Floats:
        """Where the markers are, (T, M, 3)."""
        return self.rest + self.moved(values)

    def shifted(self, values: Floats, shift: Floats) -> Floats:
        """The observables after each marker moved by `shift`, (T, M, 3) or what broadcasts to it."""
        shift = np.broadcast_to(shift, (len(values), len(self.rest), 3))
        after = values.copy()
        after[:, self.column] += shift[:, self.marker, self.axis]
        return after

    @property
    def clamp(self) -> Floats:
        """Where the body is held, (3,): the end nearest the origin if it is long, otherwise its middle."""
        if len(self.spread) > 1 and self.spread[0] < 1.8 * self.spread[1]:
            return self.centre
        reach = (self.rest - self.centre) @ self.principal[0]
        ends = [self.centre + end * self.principal[0] for end in (reach.min(), reach.max())]
        return min(ends, key=lambda end: float(np.linalg.norm(end)))

    @property
    def lever(self) -> Floats:
        """How far each marker is from the clamp, (M,), the farthest 1."""
        away = np.linalg.norm(self.rest - self.clamp, axis=1)
        return away / (away.max() or 1.0)


def turn(vector: Floats) -> Floats:
    """The rotation matrix (3, 3) of a rotation vector (3,) in radians."""
    angle = float(np.linalg.norm(vector))
    x, y, z = vector
    cross = np.array([[0.0, -z, y], [z, 0.0, -x], [-y, x, 0.0]])
    half = np.sinc(angle / 2 / np.pi) ** 2 / 2
    return np.eye(3) + np.sinc(angle / np.pi) * cross + half * cross @ cross


def unit(random: np.random.Generator) -> Floats:
    """A direction (3,) by chance."""
    direction = random.standard_normal(3)
    return direction / np.linalg.norm(direction)


def scale(setting: Setting) -> float:
    """How far the observables usually move in the campaign, root mean square over the rows, in their unit."""
    rig, path = setting.rig, setting.path
    away = rig.settled(path.kpa[path.row]) - rig.at_rest
    return float(np.sqrt((away**2).mean())) or rig.noise


def pattern(setting: Setting) -> Floats:
    """A smooth change of all observables by chance, (K,), root mean square 1: a shift, a gradient, a little chance."""
    rig, random = setting.rig, setting.random
    rough = 0.3 * random.standard_normal(len(rig.observables))
    body = Body(rig)
    if rig.rest_mm is not None and len(body.column):
        place = (body.rest - body.centre) / body.size
        field = random.standard_normal(3) + place @ random.standard_normal((3, 3))
        rough[body.column] += field[body.marker, body.axis]
    else:
        rough += random.standard_normal()
    return rough / np.sqrt((rough**2).mean())


def seats(rig: Rig) -> Floats:
    """Where each chamber acts, (C, 3) in sizes of the body: the middle of what it moves, or its number."""
    count = len(rig.chambers)
    line = np.zeros((count, 3))
    line[:, 0] = np.linspace(-1, 1, count) if count > 1 else 0.0
    body = Body(rig)
    if rig.rest_mm is None or not len(body.column):
        return line
    away = np.linalg.norm(body.moved(rig.shape(np.eye(count))), axis=2) ** 2
    weight = away / np.maximum(away.sum(axis=1, keepdims=True), 1e-12)
    found = (weight @ body.rest - body.centre) / body.size
    return found if np.ptp(found, axis=0).max() > 1e-6 else line
