"""What an effect is given: the rows, the base model's prediction on them, and the history between them."""

from collections.abc import Callable, Sequence
from dataclasses import dataclass, field, replace
from functools import cached_property
from typing import Any, Protocol

import numpy as np
from scipy.linalg import solve_banded

from labrig._errors import LabrigError
from labrig.arrays import Floats, Ints
from labrig.effects._rows import Rows
from labrig.effects._speeds import LENGTHS, speeds

LINEAR = 0.03
FEW_OBSERVABLES = 8
"""So many may each follow an effect in a measure of its own; of more, each has little to say of its own."""
_DENSE = 100
"""Fewer moments than this are no record, but a table of set-points."""
_FORCES = {"N", "mN", "kN", "N*m", "N m", "Nm", "mN*m", "Pa", "kPa", "MPa", "bar"}
MOMENTS = "the moments of its actuations"


class Alone(Protocol):
    """How each chamber alone moves the observables over a range, (n, C) at an actuation; see `Context`."""

    @property
    def reach(self) -> Floats: ...
    def at(self, actuation: Floats) -> Floats: ...
    def slope(self, actuation: Floats) -> Floats: ...


@dataclass(frozen=True)
class Context:
    """A campaign as seen by a base model.

    Shapes, for F rows, K observables, C chambers: `base` (F, K) the prediction; `base_vented` (K,) the
    prediction with every chamber vented; `jacobian` (F, K, C), its change per unit of actuation;
    `deflection` (F, C) how far each chamber alone would move the observables (root mean square of its
    displacement), as a share of what it does at full range; `event_deflection` (E, C) the same at each
    event; `deflection_slope` (F, C) its derivative by the fraction of the range, 1 for a linear base; `inside`,
    for a simulator, the derivative (F, K) by each of its physical parameters. `reach` (K, C): the mean size of
    each observable's slope while a chamber alone goes over its range; `alone` works that and the deflections out
    for another range; `elsewhere` predicts at set-points (n, C) that were not
    measured; None for a base that needs a history or is fitted to the run.

    Where a model's saved effect is evaluated, `saved` is true, `centre` (3,) is the point that its rotations are
    about, `began_s` when the run began that its moments are counted from, and `yardsticks` are that run's (see
    `yardstick`), if they are known. `displaced` (F, K) is how far the base alone moves the observables, where `base`
    has the model's effects in it.
    """

    rows: Rows
    base: Floats
    base_vented: Floats
    jacobian: Floats
    deflection: Floats
    event_deflection: Floats
    deflection_slope: Floats
    base_kind: str = "python"
    learned: bool = False
    heldout_error: float | None = None
    inside: dict[str, Floats] = field(default_factory=dict, repr=False)
    pinned: dict[str, float] = field(default_factory=dict)
    displaced: Floats | None = None
    reach: Floats | None = None
    alone: Callable[[Floats, Floats], Alone] | None = field(default=None, repr=False, compare=False)
    elsewhere: Callable[[Floats], Floats] | None = field(default=None, repr=False, compare=False)
    saved: bool = False
    centre: Floats | None = None
    began_s: float = float("nan")
    yardsticks: dict[str, Floats] = field(default_factory=dict, repr=False, compare=False)
    _memo: dict[Any, Any] = field(default_factory=dict, repr=False, compare=False)

    def pin(self, shape: dict[str, float]) -> "Context":
        """The same context in which the named quantities take these values instead of a grid of them."""
        return replace(self, pinned=shape)

    @property
    def run_time_s(self) -> Floats:
        """When each row was, (F,), s since the run began that moments are counted from, if that is known."""
        late = self.rows.start_s - self.began_s
        return self.rows.time_s + (late if np.isfinite(late) else 0.0)

    def grid(self, name: str, values: Sequence[float]) -> Sequence[float]:
        """The values to try for what is not linear in an effect; a pinned value replaces them all."""
        return (self.pinned[name],) if name in self.pinned else values

    def yardstick(self, name: str, of_this_run: Callable[[], Floats]) -> Floats:
        """What functions are measured by that differs from run to run: how far it goes, the way that it goes most.

        Where a saved effect is evaluated, it is that of the run which the effect was fitted to, so that its weights
        mean the same on every run.
        """
        if not self.saved or name not in self.yardsticks:
            self.yardsticks[name] = np.asarray(of_this_run(), dtype=float)
        return self.yardsticks[name]

    def shows(self, seen: bool | np.bool_) -> bool:
        """Whether a form is worth yielding: this run shows it, or a saved effect has it, shown or not."""
        return bool(seen) or self.saved

    def within(self, low: Floats, high: Floats) -> "Context":
        """The same context where each chamber's range is `low` to `high`, (C,), whatever this run's is."""
        if np.array_equal(low, self.rows.low) and np.array_equal(high, self.rows.high):
            return self
        if self.alone is None:
            raise LabrigError("the effects were fitted with another range of the pressures than this run's")
        key = ("within", *low, *high)
        curves = self._memo[key] = self._memo.get(key) or self.alone(low, high)
        rows = replace(self.rows, low=low, high=high)
        return replace(
            self,
            rows=rows,
            deflection=curves.at(rows.actuation),
            event_deflection=curves.at(rows.event_actuation),
            deflection_slope=curves.slope(rows.actuation),
            reach=curves.reach,
            _memo={"motion": self.motion},
        )

    def thin(self, keep: Ints) -> "Context":
        """Keep some rows only; history and motion stay as the whole campaign had them."""
        motion = {name: (speed[keep], span) for name, (speed, span) in self.motion.items()}
        return replace(
            self,
            rows=self.rows.thin(keep),
            base=self.base[keep],
            displaced=None if self.displaced is None else self.displaced[keep],
            jacobian=self.jacobian[keep],
            deflection=self.deflection[keep],
            deflection_slope=self.deflection_slope[keep],
            inside={name: change[keep] for name, change in self.inside.items()},
            _memo={"motion": motion},
        )

    @property
    def span(self) -> Floats:
        """Range of each chamber's actuation, shape (C,); negative where it is filled by vacuum."""
        return self.rows.span

    @cached_property
    def residual(self) -> Floats:
        """Measured minus predicted, shape (F, K), NaN where not seen."""
        return self.rows.values - self.base

    @cached_property
    def displacement(self) -> Floats:
        """Predicted minus predicted when vented, shape (F, K), without what the model's effects change."""
        return self.base - self.base_vented if self.displaced is None else self.displaced

    @cached_property
    def travel(self) -> Floats:
        """Predicted distance from the vented position, per observable, (F, K).

        The three coordinates of a marker share their marker's distance.
        """
        square = self.displacement**2
        out = np.sqrt(square)
        for m in np.unique(self.rows.marker[self.rows.marker >= 0]):
            own = self.rows.marker == m
            out[:, own] = np.sqrt(square[:, own].sum(axis=1, keepdims=True))
        return out

    @cached_property
    def started(self) -> Ints:
        """Index of each event's predecessor in its history; -1 where the chambers were vented, shape (E,).

        A record that began at rest, at its first sample, has that before it.
        """
        session = self.rows.event_session
        before = np.arange(len(session)) - 1
        if self.rows.between_sessions != "held":
            first = np.flatnonzero(np.diff(session, prepend=-1))
            first = first[~np.isin(session[first], self.rows.goes_on)]
            before[first] = first if self.begins_at_rest else -1
        return before

    @property
    def begins_at_rest(self) -> bool:
        """Whether sessions began at rest where their first sample is, neither vented nor held."""
        return self.rows.between_sessions == "rest"

    @cached_property
    def previous(self) -> Floats:
        """What was commanded before each event, shape (E, C); zero where the chambers were vented."""
        before = self.started
        return np.where((before >= 0)[:, None], self.rows.event_actuation[before], self.vented)

    @property
    def vented(self) -> Floats:
        """The actuation of a vented chamber: zero, or the limit nearest to it, shape (C,)."""
        return np.clip(0.0, self.rows.low, self.rows.high)

    @cached_property
    def direction(self) -> Floats:
        """Sign of the last change of each chamber at each event, shape (E, C); 0 before the first change."""
        change = np.sign(self.rows.event_actuation - self.previous)
        out = np.zeros_like(change)
        for e, before in enumerate(self.started):
            out[e] = np.where(change[e] != 0, change[e], out[before] if before >= 0 else 0.0)
        return out

    @cached_property
    def elapsed_s(self) -> Floats:
        """Time since the actuation of each row, shape (F,); zero where nothing is known of it."""
        hold = self.rows.hold_s.copy()
        missing = ~np.isfinite(hold)
        hold[missing] = (self.rows.time_s - self.rows.event_time_s[self.rows.event])[missing]
        return np.maximum(np.nan_to_num(hold), 0.0)

    @cached_property
    def has_time(self) -> bool:
        """Whether the moments of the actuations are known."""
        return bool(np.isfinite(self.rows.event_time_s).all())

    @cached_property
    def has_holds(self) -> bool:
        """Whether some hold has more than one row, so that change within a hold can be seen."""
        return bool(np.bincount(self.rows.capture).max() > 1) and float(np.ptp(self.elapsed_s)) > 0

    @cached_property
    def moves(self) -> bool:
        """Whether the actuation changes at all during the campaign."""
        return bool((np.ptp(self.rows.event_actuation, axis=0) > 1e-9 * np.abs(self.span)).any())

    @cached_property
    def stretched(self) -> bool:
        """Whether a displacement is commanded and a force measured, so that what yields is seen as relaxation."""
        return self.rows.actuation_unit in LENGTHS and set(self.rows.unit) <= _FORCES

    @cached_property
    def linear(self) -> bool:
        """Whether every chamber's deflection follows its pressure, so closely that nothing can tell them apart."""
        return bool(np.abs(self.deflection - self.rows.fraction).max() <= LINEAR)

    def strained(self, tau_s: float) -> Floats:
        """First-order lag of the deflection, carried back to the actuation, (F, C): `relaxed` in the material.

        A share of it is what the pressures would have to change by for the surface to move so much more.
        """
        return self._lagged(tau_s, self.event_deflection) * self.span / self.deflection_slope

    def play(self, width: float) -> Floats:
        """Play (backlash) operator of each chamber, shape (F, C), units of the actuation.

        The state follows its input only once that has moved by `width` (a fraction of the chamber's
        range) from where it turned: the elementary hysteron of Krasnosel'skii and Pokrovskii, of which
        Prandtl-Ishlinskii models are weighted sums. Between two set-points the path is taken as straight.
        """
        key = ("play", width)
        if key not in self._memo:
            self._memo[key] = self.played(width * np.abs(self.span), self.rows.event_actuation, self.vented)
        return self._memo[key]

    def played(self, half: float | Floats, drive: Floats, rest: float | Floats = 0.0) -> Floats:
        """Play operator on any drive of the events, (E, ...) -> (F, ...): it is at `rest` where it began, and lets its
        drive go `half` a width to either side.
        """
        state = drive.copy()
        for e, before in enumerate(self.started):
            last = state[before] if before >= 0 else rest
            state[e] = np.maximum(drive[e] - half, np.minimum(drive[e] + half, last))
        return state[self.rows.event]

    def relaxed(self, tau_s: float) -> Floats:
        """First-order lag of the actuation with time constant `tau_s`, shape (F, C).

        The strain of a Kelvin-Voigt element under the whole history of set-points; needs `has_time`.
        """
        return self._lagged(tau_s, self.rows.event_actuation)

    def lagged(self, tau_s: float, u: Floats, rest: float | Floats = 0.0) -> Floats:
        """First-order lag of any drive of the events, (E, C) -> (F, C), which is at `rest` where it began."""
        before, event = self.started, self.rows.event
        gap_s = np.maximum(np.diff(self.rows.event_time_s, prepend=0.0), 0.0)
        decay = np.where(before == np.arange(len(u)) - 1, np.exp(-gap_s / tau_s), 0.0)
        decay[:1] = 0.0
        last = np.where((before < 0)[:, None], rest, u[before])
        # at_start[e] = decay[e] at_start[e - 1] + (1 - decay[e]) last[e], of all events at once
        bands = np.stack([np.ones(len(u)), np.append(-decay[1:], 0.0)])
        at_start = solve_banded((1, 0), bands, (1 - decay)[:, None] * last, check_finite=False)
        return u[event] + (at_start[event] - u[event]) * np.exp(-self.elapsed_s / tau_s)[:, None]

    def integrated(self) -> Floats:
        """The integral over time of the actuation beyond what is vented, s, since its history began, (F, C)."""
        excess, gap_s = self.rows.event_actuation - self.vented, np.diff(self.rows.event_time_s, prepend=0.0)
        goes_on = self.started == np.arange(len(excess)) - 1
        goes_on[:1] = False
        steps = np.where(goes_on, np.maximum(gap_s, 0.0), 0.0)[:, None] * excess[self.started]
        total = np.cumsum(steps, axis=0)
        began = np.maximum.accumulate(np.where(goes_on, 0, np.arange(len(excess))))
        at_start, event = total - total[began], self.rows.event
        return at_start[event] + self.elapsed_s[:, None] * excess[event]

    def earlier(self, dead_s: float) -> Floats:
        """The actuation of so many seconds ago, (F, C), vented before a session's first; needs `has_time`.

        Held from one set-point to the next, of a record without holds in a straight line from sample to sample.
        """
        rows, out = self.rows, np.tile(self.vented, (len(self.base), 1))
        then = rows.event_time_s[rows.event] + self.elapsed_s - dead_s
        for s in np.unique(rows.event_session):
            own = np.flatnonzero(rows.event_session == s)
            mine = np.flatnonzero(rows.event_session[rows.event] == s)
            at, when = rows.event_time_s[own], then[mine]
            began = self.started[own[0]]
            before = rows.event_actuation[began] if began >= 0 else self.vented
            last = np.searchsorted(at, when + 1e-9, side="right") - 1
            u = np.vstack([before, rows.event_actuation[own]])[last + 1]
            if self.sample_s:
                after = np.minimum(last + 1, len(own) - 1)
                share = (when - at[last]) / np.where(at[after] > at[last], at[after] - at[last], np.inf)
                line = u + share[:, None] * (rows.event_actuation[own[after]] - u)
                u = np.where((last >= 0)[:, None], line, u)
            out[mine] = u
        return out

    @cached_property
    def sample_s(self) -> float:
        """The time from one row to the next in a record without holds; 0 where captures are held."""
        if len(self.rows.event_session) < _DENSE or self.elapsed_s.any():
            return 0.0
        gaps = np.diff(self.rows.event_time_s)
        gaps = gaps[np.isfinite(gaps) & (gaps > 0)]
        return float(np.median(gaps)) if len(gaps) else 0.0

    @cached_property
    def input_speed(self) -> Floats:
        """How fast each chamber's actuation goes in a record without holds, (F, C), per s and whichever way; 0 where
        captures are held.
        """
        rows = self.rows
        speed = np.zeros_like(rows.event_actuation)
        for s in range(len(rows.sessions)) if self.sample_s else ():
            own = np.flatnonzero(rows.event_session == s)
            if len(own) > 1:
                step_s = np.gradient(rows.event_time_s[own])[:, None]
                moved = np.abs(np.gradient(rows.event_actuation[own], axis=0))
                speed[own] = np.divide(moved, step_s, out=np.zeros_like(moved), where=step_s > 0)
        return speed[rows.event]

    def gained(self, tau_s: float) -> Floats:
        """What a first-order lag of the actuation has gained since its actuation, (F, C): what seeps into a pocket."""
        left = np.exp(-self.elapsed_s / tau_s)[:, None]
        late = self.relaxed(tau_s) - self.rows.actuation  # (state - u) exp(-t / tau)
        return late - late / np.maximum(left, 1e-12)

    def _lagged(self, tau_s: float, u: Floats) -> Floats:
        key = ("lagged", tau_s, id(u))
        if key not in self._memo:
            self._memo[key] = self.lagged(tau_s, u, 0.0 if u is self.event_deflection else self.vented)
        return self._memo[key]

    @cached_property
    def measured_error(self) -> Floats | None:
        """Measured minus commanded pressure at the beginning of each hold, (F, C), which goes on while the set-point
        stays, since what holds a chamber need not fill it again; None if not measured."""
        rows = self.rows
        excess = rows.measured - rows.actuation
        if not np.isfinite(excess).all() or excess.shape[1] == 0:
            return None
        captures, first = np.unique(rows.capture, return_index=True)
        stays = (np.diff(rows.actuation[first], axis=0) == 0).all(axis=1) & (
            np.diff(rows.session[first]) == 0
        )
        begun = np.maximum.accumulate(np.where(np.append(False, stays), 0, np.arange(len(first))))
        return excess[first[begun]][np.searchsorted(captures, rows.capture)]

    @cached_property
    def measured_fall(self) -> Floats | None:
        """Change of the measured pressure since the beginning of each hold, (F, C); None if not measured."""
        begin = self.measured_error
        return None if begin is None else self.rows.measured - self.rows.actuation - begin

    @cached_property
    def session_time_s(self) -> Floats:
        """Time since the session began, shape (F,); zeros when the table has no time."""
        t = self.rows.time_s
        if not np.isfinite(t).all():
            return np.zeros(len(t))
        out = t.copy()
        for s in np.unique(self.rows.session):
            own = self.rows.session == s
            begin = np.nanmin(np.append(self.rows.event_time_s[self.rows.event_session == s], t[own].min()))
            out[own] -= begin
        return out

    @property
    def motion(self) -> dict[str, tuple[Floats, float]]:
        """Logged covariates that are a position: name -> (its speed per s (F,), its range)."""
        if "motion" not in self._memo:
            found = speeds(self.rows)
            self._memo["motion"] = {
                n: (v, span) for n, (v, span) in found.items() if self.shows(np.ptp(v) > 0)
            }
        return self._memo["motion"]
