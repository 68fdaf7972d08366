"""Bases with memory: what they predict depends on the whole record of the input, not on the set-point alone.

Every kind is one function, `simulate(u, t)`, over one record; all that an effect asks of a base follows from it.
"""

from abc import ABC, abstractmethod
from dataclasses import dataclass

import numpy as np

from labrig._errors import LabrigError
from labrig._own_code import FAULTS
from labrig.arrays import Floats, Ints
from labrig.effects import Rows, ends
from labrig.model._deflection import GRID, Deflection

_STEP = 1e-3
"""Step of the finite differences, fraction of a chamber's range."""
_SETTLED = 0.01
_LONGEST = 2000
_HOLD = 200


@dataclass(frozen=True)
class Record:
    """One stretch without a break: the input `u` (n, C) from each time `t` (n,), s since it began, on.

    `rows` are the campaign's rows in it, and `at` where among the times each of them lies.
    """

    u: Floats
    t: Floats
    rows: Ints
    at: Ints


class MemoryModel(ABC):
    """A base that sees the record of the input; at the beginning of a record it is at rest."""

    kind: str
    _given = ""
    """What a function is given, in the words of a message, where that is not what its author may think."""

    def __init__(self, where: str, rows: Rows, max_step_s: float | None) -> None:
        self._where, self._rows, self._max_step_s = where, rows, max_step_s
        self._width = len(rows.observables)
        if not (np.isfinite(rows.event_time_s).all() and np.isfinite(rows.time_s).all()):
            raise LabrigError(
                f"{where}: a base with memory needs the times of the run, which it does not have"
            )
        records = records_of(rows, max_step_s)
        self._dt = float(
            np.median(np.concatenate([np.diff(r.t) for r in records if len(r.t) > 1] or [[1.0]]))
        )
        self._longest_s = max(float(r.t[-1]) for r in records)

    @abstractmethod
    def _simulate(self, u: Floats, t: Floats) -> object:
        """Predict a record: input (n, C) at rising times (n,) -> (n, K)."""

    def simulate(self, u: Floats, t: Floats) -> Floats:
        """Predict a record (n, K); raises `LabrigError` where that fails, or has another shape, or is not finite."""
        try:
            out = np.asarray(self._simulate(u.copy(), t.copy()), dtype=float)
        except LabrigError:
            raise
        except FAULTS as error:
            raise LabrigError(
                f"{self._where} failed{self._given}: {type(error).__name__}: {error}"
            ) from error
        if out.ndim == 1 and self._width == 1:
            out = out[:, None]
        if out.shape != (len(t), self._width):
            raise LabrigError(
                f"{self._where} returned shape {out.shape} for a record of {len(t)} times; "
                f"the run needs {(len(t), self._width)} (times, observables)"
            )
        if not np.isfinite(out).all():
            raise LabrigError(f"{self._where} returned NaN or infinite values")
        return out

    def predict_rows(self, rows: Rows, shift: Floats | float = 0.0) -> Floats:
        """The rows of a campaign (F, K), with all of its input moved by `shift` (C,)."""
        out = np.zeros((len(rows.time_s), self._width))
        for record in records_of(rows, self._max_step_s):
            out[record.rows] = self.simulate(record.u + shift, record.t)[record.at]
        return out

    def slope(self, rows: Rows) -> Floats:
        """Change of the prediction by a change of a chamber's whole history, per unit of actuation, (F, K, C).

        So an effect that changes slowly beside the base's own memory acts through it. Central differences; a row at a
        limit, where many bases clip, has the difference on the inner side.
        """
        base = self.predict_rows(rows)
        steps = _STEP * (rows.high - rows.low)
        out = np.zeros((*base.shape, len(steps)))
        for c, step in enumerate(steps):
            shift = np.zeros(len(steps))
            shift[c] = step
            up, down = self.predict_rows(rows, shift), self.predict_rows(rows, -shift)
            u = rows.actuation[:, c, None]
            inner = np.where(u + step > rows.high[c], (base - down) / step, (up - base) / step)
            central = (u + step <= rows.high[c]) & (u - step >= rows.low[c])
            out[..., c] = np.where(central, (up - down) / (2 * step), inner)
        return out

    def predict(self, actuation: Floats) -> Floats:
        """What the base settles at, (F, C) -> (F, K), each set-point held for as long as it needs."""
        unique, inverse = np.unique(actuation, axis=0, return_inverse=True)
        n = self._settling()
        t = self._clock(n)
        held = [self.simulate(np.tile(u, (n, 1)), t)[-1] for u in unique]
        return np.array(held)[inverse.reshape(-1)]

    def deflection(self, low: Floats, high: Floats) -> Deflection:
        """Take each chamber alone slowly over its range and see how far the observables go."""
        vented, (origin, span) = np.clip(0.0, low, high), ends(low, high)
        n = min(self._settling(), _HOLD)
        rest = self.predict(vented[None])[0]
        curves = np.zeros((GRID, len(low)))
        reach = []
        for c in range(len(low)):
            grid = np.linspace(origin[c], origin[c] + span[c], GRID)
            first = max(self._settling() // n, 1) * n
            u = np.tile(vented, (first + GRID * n, 1))
            u[:first, c] = grid[0]
            u[first:, c] = np.repeat(grid, n)
            slow = self.simulate(u, self._clock(len(u)))[first + n - 1 :: n]
            moved = np.sqrt(((slow - rest) ** 2).mean(axis=1)) * np.sign((grid - vented[c]) / span[c])
            full = np.abs(moved).max()
            curves[:, c] = moved / full if full > 0 else np.linspace(0, 1, GRID)
            reach.append(np.abs(np.diff(slow, axis=0)).sum(axis=0) / (high[c] - low[c]))
        return Deflection(origin, span, curves, np.stack(reach, axis=1))

    def declared(self, actuation: Floats) -> Floats | None:
        """None: it has no parameters that labrig fits."""
        return None

    def _clock(self, n: int) -> Floats:
        return np.arange(n).astype(np.float64) * self._dt

    def _settling(self) -> int:
        """How many steps a response to all chambers at once takes to come to rest; as many as the run has, at most."""
        known = getattr(self, "_steps", None)
        if known is not None:
            return known
        n = int(np.clip(self._longest_s / self._dt, 20, _LONGEST))
        u = np.tile(self._rows.origin + self._rows.span, (n, 1))
        out = self.simulate(u, self._clock(n))
        far = np.abs(out - out[-1]).max(axis=1)
        late = np.flatnonzero(far > _SETTLED * max(float(far.max()), 1e-300))
        self._steps = n if len(late) and late[-1] > 0.9 * n else max(int(late[-1]) + 2 if len(late) else 3, 3)
        return self._steps


def records_of(rows: Rows, max_step_s: float | None = None) -> list[Record]:
    """The records of a campaign: one for each session, or one in all where the pressures were held in between.

    An actuation acts until the next. `max_step_s` puts times in between where they are farther apart.
    """
    out = []
    together = rows.between_sessions == "held"
    for s in [None] if together else range(len(rows.sessions)):
        events = np.arange(len(rows.event_time_s)) if s is None else np.flatnonzero(rows.event_session == s)
        own = np.arange(len(rows.time_s)) if s is None else np.flatnonzero(rows.session == s)
        if not len(own):
            continue
        moments, at_rows = rows.event_time_s[events], rows.time_s[own]
        order = np.argsort(moments, kind="stable")
        events, moments = events[order], moments[order]
        t = np.unique(np.concatenate([moments, at_rows]))
        if max_step_s is not None:
            gaps = np.diff(t)
            many = np.ceil(gaps / max_step_s).astype(int)
            fill = [a + np.arange(1, k) * (g / k) for a, g, k in zip(t, gaps, many, strict=False) if k > 1]
            t = np.unique(np.concatenate([t, *fill]))
        held = np.searchsorted(moments, t, side="right") - 1
        u = (
            rows.event_actuation[events[np.maximum(held, 0)]]
            if len(events)
            else np.zeros((len(t), len(rows.low)))
        )
        out.append(Record(u, t - t[0], own, np.searchsorted(t, at_rows)))
    return out
