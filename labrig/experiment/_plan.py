"""A pressure programme that could be measured next: its points, how long it takes, and the rows it would give."""

import hashlib
from collections.abc import Callable, Sequence
from dataclasses import dataclass, replace
from typing import Any

import numpy as np

from labrig._ranges import within
from labrig.arrays import Floats
from labrig.effects import TRANSIENT_S, Covariate, Rows, ends

WHOLE_WAY_S = 0.6
"""How long a chamber takes over its range where nobody states its rate, s, in whatever unit: 60 kPa at 100 kPa/s."""

SETTLE_S = 1.0
PAUSE_S = 600.0
"""From the run to the programme, s."""

START_S = 2.0
"""From the vent with which every run begins to its first actuation, s."""

_ROWS_SHORT, _ROWS_LONG = 3, 6
_LONG_S = 8.0
_NODES = 6
"""Moments of a hold for a mean over time: of what creeps, whatever its time constant, within 0.1 % in ten minutes."""
_DIGITS = 4


@dataclass(frozen=True)
class Limits:
    """What a rig allows, (C,): lowest and highest actuation, and how fast it may change, per second."""

    low: Floats
    high: Floats
    slew_per_s: Floats

    @classmethod
    def between(cls, low: Floats, high: Floats) -> "Limits":
        """Limits of which nobody states how fast a chamber may change, in any unit."""
        return cls(low, high, np.abs(high - low) / WHOLE_WAY_S)

    @classmethod
    def of(cls, rows: Rows) -> "Limits":
        """The limits that a run states; how fast is not stated.

        What is no pressure has no vent: it goes no farther down or up than it has been, since a table that states no
        limits has zero as one of them, and a stage may not be sent there.
        """
        low, high = rows.low, rows.high
        if not rows.by_pressure:
            went = rows.event_actuation
            low, high = np.maximum(low, went.min(axis=0)), np.minimum(high, went.max(axis=0))
            still = low >= high
            low, high = np.where(still, rows.low, low), np.where(still, rows.high, high)
        return cls.between(low, high)

    def up_to(self, highest: float) -> "Limits":
        """The same rig, which goes no farther than a share of the way from vented to either limit."""
        both = within(self.low, self.high, [[0.0], [1.0]], highest=highest)
        return replace(self, low=both.min(axis=0), high=both.max(axis=0))

    @property
    def rest(self) -> tuple[float, ...]:
        """A vented rig, as shares of each chamber's range."""
        origin, span = ends(self.low, self.high)
        share = (np.clip(0.0, self.low, self.high) - origin) / np.where(span == 0, 1.0, span)
        return tuple(share.tolist())

    def actuation(self, share: Sequence[float]) -> Floats:
        """Shares of the range (C,) as set-points, rounded to what a person would type: four digits of the range."""
        origin, span = ends(self.low, self.high)
        finest = np.abs(span)[span != 0].min(initial=np.inf)  # a chamber whose limits are one is never filled
        decimals = _DIGITS - 1 - int(np.floor(np.log10(finest))) if np.isfinite(finest) else 0
        return np.clip(np.round(origin + np.asarray(share) * span, decimals), self.low, self.high)

    def way_s(self, before: Sequence[float], after: Sequence[float]) -> float:
        """How long it takes to go from one set-point to another, s."""
        change = np.abs(self.actuation(after) - self.actuation(before))
        return float((change / self.slew_per_s).max())


@dataclass(frozen=True)
class Point:
    """One set-point, as shares of each chamber's range, held for `hold_s` after the way there."""

    share: tuple[float, ...]
    hold_s: float
    settle_s: float = SETTLE_S


@dataclass(frozen=True)
class Probe:
    """A few points that show one thing; each begins and ends with a vented rig."""

    name: str
    separates: str
    points: tuple[Point, ...]

    @property
    def title(self) -> str:
        """Its name, and how long its longest hold is, where that is long."""
        longest_s = max(point.hold_s for point in self.points)
        return f"{self.name}, {longest_s:g} s" if longest_s > _LONG_S else self.name

    def seconds(self, limits: Limits) -> float:
        """How long it takes, s: ways and holds."""
        before, total = limits.rest, 0.0
        for point in self.points:
            total += limits.way_s(before, point.share) + point.hold_s
            before = point.share
        return total

    def scaled(self, levels: float = 1.0, holds: float = 1.0, rest: tuple[float, ...] = ()) -> "Probe":
        """The same with other levels, and long holds longer or shorter (5 to 600 s); `rest` stays where it is."""
        points = []
        for point in self.points:
            vented = np.asarray(rest if rest else np.zeros(len(point.share)))
            share = np.clip(vented + levels * (np.asarray(point.share) - vented), 0.0, 1.0)
            hold_s = point.hold_s
            if hold_s > _LONG_S:
                hold_s = float(np.clip(holds * hold_s, 5.0, 600.0))
            points.append(replace(point, share=tuple(share.tolist()), hold_s=hold_s))
        return replace(self, points=tuple(points))


@dataclass(frozen=True)
class Planned:
    """Rows of programmes, each with a history of its own; `owner` (F,) is which programme a row belongs to,
    `point` (F,) which of its points."""

    rows: Rows
    owner: Any
    point: Any


def _moments(first: float, end: float) -> Floats:
    """The moments of a hold that say most of it, denser at its beginning."""
    count = _ROWS_LONG if end > _LONG_S else _ROWS_SHORT
    return np.geomspace(min(first + 0.1, 0.8 * end), end, count)


def planned_rows(
    template: Rows,
    programmes: Sequence[Sequence[Point]],
    limits: Limits,
    moments: Callable[[float, float], Floats] = _moments,
) -> Planned:
    """What the programmes would record, as rows without values, shaped like the run `template`.

    Each is a session of its own, which begins vented, `START_S` before it. Where the run measured its pressures, they
    are taken to be what is commanded. `moments` are those of a hold that are looked at, s, from when its first second
    is over to its end.
    """
    event_at: list[float] = []
    event_u: list[Floats] = []
    event_session: list[int] = []
    kept: dict[str, list[Any]] = {n: [] for n in ("u", "capture", "event", "hold", "time", "owner", "point")}
    capture = -1
    for number, points in enumerate(programmes):
        clock, before = START_S, limits.rest
        event_at.append(0.0)
        event_u.append(limits.actuation(before))
        event_session.append(number)
        for place, point in enumerate(points):
            way = limits.way_s(before, point.share)
            end = way + point.hold_s
            capture += 1
            event_at.append(clock)
            event_u.append(limits.actuation(point.share))
            event_session.append(number)
            for hold in moments(max(TRANSIENT_S, way), end):
                kept["u"].append(event_u[-1])
                kept["capture"].append(capture)
                kept["event"].append(len(event_at) - 1)
                kept["hold"].append(hold)
                kept["time"].append(clock + hold)
                kept["owner"].append(number)
                kept["point"].append(place)
            clock, before = clock + end, point.share
    n = len(kept["u"])
    actuation = np.array(kept["u"]).reshape(n, -1)
    owner = np.array(kept["owner"], dtype=np.int64)
    rows = replace(
        template,
        actuation=actuation,
        measured=actuation if np.isfinite(template.measured).all() else np.full(actuation.shape, np.nan),
        values=np.full((n, len(template.observables)), np.nan),
        capture=np.array(kept["capture"], dtype=np.int64),
        session=owner,
        event=np.array(kept["event"], dtype=np.int64),
        hold_s=np.array(kept["hold"], float),
        time_s=np.array(kept["time"], float),
        event_actuation=np.array(event_u),
        event_time_s=np.array(event_at, float),
        event_session=np.array(event_session, dtype=np.int64),
        sessions=tuple(f"planned {i + 1}" for i in range(len(programmes))),
        session_keys=(),
        repeat=tuple("" for _ in range(capture + 1)),
        ruled_out=(),
        start_s=template.start_s + float(np.nanmax(template.time_s, initial=0.0)) + PAUSE_S,
        covariates={name: _as_before(cov, n) for name, cov in template.covariates.items()},
        warnings=(),
        goes_on=(),
    )
    return Planned(rows, owner, np.array(kept["point"], dtype=np.int64))


def as_rows(template: Rows, actuation: Floats, hold_s: float) -> tuple[Rows, Floats]:
    """What set-points (n, C) would record, each held for `hold_s`, as rows without values, from a vented rig on.

    Each is reached at once. Beside them the share of each row in the mean over the time of its hold, the first second
    left out, (F,): by Gauss and Legendre's rule in the logarithm of time (Abramowitz and Stegun, Handbook of
    Mathematical Functions, 25.4.29).
    """
    low, high = (
        pick(np.vstack([limit, actuation]), axis=0)
        for pick, limit in ((np.min, template.low), (np.max, template.high))
    )
    origin, span = ends(low, high)
    limits = Limits(low, high, np.full(len(low), np.inf))
    points = [Point(tuple(((u - origin) / span).tolist()), hold_s) for u in actuation]
    node, weight = np.polynomial.legendre.leggauss(_NODES)
    hold = TRANSIENT_S * (hold_s / TRANSIENT_S) ** ((1 + node) / 2)
    rows = planned_rows(template, [points], limits, lambda *_: hold).rows
    exact = np.vstack([rows.event_actuation[:1], actuation])  # not as a person would type them
    own = actuation[rows.capture]
    measured = own if np.isfinite(rows.measured).all() else rows.measured
    share = np.tile(hold * weight / (hold @ weight), len(actuation))
    return replace(rows, actuation=own, event_actuation=exact, measured=measured), share


def _as_before(covariate: Covariate, n: int) -> Covariate:
    """What else was logged, taken to stay as it last was."""
    known = covariate.values[np.isfinite(covariate.values)]
    return Covariate(covariate.unit, np.full(n, known[-1] if len(known) else np.nan))


def repeat_labels(points: Sequence[Point], rest: tuple[float, ...]) -> list[str]:
    """Equal labels for points that repeat each other: the same set-point and hold after the same one before.

    The label says what it is the label of, so that those of several programmes do not collide.
    """
    keys, before = [], Point(rest, 0.0)
    for point in points:
        keys.append(f"{before.share} {before.hold_s:g} {point.share} {point.hold_s:g}")
        before = point
    return [f"s{hashlib.sha1(k.encode()).hexdigest()[:8]}" if keys.count(k) > 1 else "" for k in keys]
