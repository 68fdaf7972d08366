"""Canonical probes: what the laboratory's experience says shows one effect and not another."""

from collections.abc import Iterator, Mapping, Sequence
from itertools import combinations

import numpy as np

from labrig.arrays import Floats
from labrig.contents import ByHand
from labrig.effects import Context, Effect
from labrig.effects.coupling import overlap
from labrig.experiment._plan import Point, Probe

HIGHEST = 0.9
"""Of a chamber's range: what is off may overshoot, and a rig vents above its limit."""

_SHORT_S, _REST_S = 4.0, 4.0
_HOLDS_S = (30.0, 100.0, 300.0)
_WAITS_S = (60.0, 180.0)
_LEVELS = (0.4, HIGHEST)
_STEPS = (0.15, 0.3, 0.45, 0.6, 0.75, HIGHEST)
_MOST_PAIRS = 4
_COARSE, _FEW_SCATTERED = 0.3, 2
_RANDOM_PROBES, _RANDOM_POINTS = 4, 4


def by_hand(names: Sequence[str], effects: Mapping[str, Effect]) -> list[ByHand]:
    """What a person could do besides, for the effects among `names` that it would show.

    `points`: whether set-points are measured after it.
    """
    return [
        {"effect": n, "what": effects[n].by_hand, "points": effects[n].then_measured}
        for n in names
        if n in effects and effects[n].by_hand
    ]


def canonical(context: Context, rest: tuple[float, ...], seed: int = 0) -> list[Probe]:
    """Every canonical probe for the chambers of a run: all together, each alone, and the pairs that overlap."""
    C = len(rest)
    out: list[Probe] = []
    for name, chosen in _groups(context, C):
        maker = _Maker(rest, chosen, name)
        out += maker.short()
        if len(chosen) in (1, C):
            out += maker.long()
    out += list(_together(context, rest))
    out += list(_scattered(rest, np.random.default_rng([seed, C])))
    return out


def _groups(context: Context, C: int) -> Iterator[tuple[str, tuple[int, ...]]]:
    names = context.rows.chambers
    if C > 1:
        yield "all chambers", tuple(range(C))
    for c in range(C):
        yield names[c], (c,)


class _Maker:
    """Makes the probes of one group of chambers; every one starts and ends at rest."""

    def __init__(self, rest: tuple[float, ...], chosen: Sequence[int], name: str) -> None:
        self.rest, self.chosen, self.name = rest, list(chosen), name

    def at(self, level: float, hold_s: float = _SHORT_S) -> Point:
        """The group at a level, the other chambers vented."""
        share = np.array(self.rest)
        share[self.chosen] = level
        return Point(tuple(share.tolist()), hold_s)

    def release(self, hold_s: float = _REST_S) -> Point:
        """Vented, and looked at."""
        return Point(self.rest, hold_s)

    def short(self) -> list[Probe]:
        """Probes of a few seconds a point."""
        strokes = [0.5, HIGHEST, 0.5, 0.1, 0.5, 0.65, 0.5]
        up_down = [*_STEPS, *_STEPS[-2::-1]]
        return [
            self._probe("from above and below", "history", [self.at(v) for v in strokes]),
            self._probe("steps up and down", "the curve of the response", [self.at(v) for v in up_down]),
            self._probe(
                "one large step", "lag, creep, recovery", [self.at(HIGHEST, 10.0), self.release(10.0)]
            ),
        ]

    def long(self) -> list[Probe]:
        """Long holds, and the same early and late."""
        out = []
        for hold_s in _HOLDS_S:
            for level in _LEVELS:
                points = [self.at(level, hold_s), self.release(min(hold_s, 60.0))]
                out.append(self._probe("hold and recovery", "creep, drift, leak", points))
        for wait_s in _WAITS_S:
            points = [self.at(0.6), self.release(), self.release(wait_s), self.at(0.6)]
            out.append(self._probe("early and late", "drift", points))
        return out

    def _probe(self, what: str, separates: str, points: list[Point]) -> Probe:
        return Probe(f"{self.name}: {what}", separates, (*points, self.release()))


def _together(context: Context, rest: tuple[float, ...]) -> Iterator[Probe]:
    """Two chambers one at a time, then both."""
    C = len(rest)
    if C < 2:
        return
    near = overlap(context)
    pairs = sorted(combinations(range(C), 2), key=lambda p: -(near[p] + near[p[1], p[0]]))
    names = context.rows.chambers
    for i, j in pairs[:_MOST_PAIRS]:
        one, other, both = (_Maker(rest, chosen, "") for chosen in ((i,), (j,), (i, j)))
        points = (one.at(0.7), one.release(), other.at(0.7), one.release(), both.at(0.7), one.release())
        yield Probe(f"{names[i]} and {names[j]}: one at a time, then both", "coupling", points)


def _scattered(rest: tuple[float, ...], random: np.random.Generator) -> Iterator[Probe]:
    """A few set-points anywhere, and rest."""
    for number in range(_RANDOM_PROBES):
        shares: Floats = random.uniform(0.05, HIGHEST, (_RANDOM_POINTS, len(rest)))
        points = tuple(Point(tuple(np.round(s, 2).tolist()), _SHORT_S) for s in shares)
        yield Probe(f"scattered set-points {number + 1}", "static errors", (*points, Point(rest, _REST_S)))


def on_few_levels(probes: Sequence[Probe], rest: tuple[float, ...]) -> list[Probe]:
    """The same probes on three levels, few of them scattered: for a base that takes seconds for each set-point."""
    out = []
    for probe in probes:
        points: list[Point] = []
        for point in probe.points:
            share = tuple(
                round(r + _COARSE * round((s - r) / _COARSE), 4)
                for s, r in zip(point.share, rest, strict=True)
            )
            if not points or points[-1].share != share or point.hold_s > _SHORT_S:
                points.append(Point(share, point.hold_s, point.settle_s))
        out.append(Probe(probe.name, probe.separates, tuple(points)))
    scattered = [p for p in out if p.name.startswith("scattered")]
    return [p for p in out if p not in scattered[_FEW_SCATTERED:]]


def moves(probe: Probe, rest: tuple[float, ...]) -> list[Probe]:
    """Probes that differ a little from one: other levels, other lengths of its long holds, one point less."""
    out = [probe.scaled(levels=v, rest=rest) for v in (0.6, 0.8, 1.15)]
    if any(p.hold_s > 8.0 for p in probe.points):
        out += [probe.scaled(holds=v, rest=rest) for v in (0.4, 0.65, 1.5, 2.5)]
    if len(probe.points) > 3:
        out += [
            Probe(probe.name, probe.separates, probe.points[:i] + probe.points[i + 1 :])
            for i in range(0, len(probe.points) - 1, max(1, len(probe.points) // 4))
        ]
    capped = []
    for each in out:
        points = tuple(Point(_capped(p.share, rest), p.hold_s, p.settle_s) for p in each.points)
        capped.append(Probe(each.name, each.separates, points))
    return capped


def _capped(share: tuple[float, ...], rest: tuple[float, ...]) -> tuple[float, ...]:
    return tuple(min(s, max(HIGHEST, r)) for s, r in zip(share, rest, strict=True))
