"""The search for a programme: canonical probes first, then changes of those that were chosen."""

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np

from labrig.arrays import Floats
from labrig.experiment._plan import Limits, Point, Probe
from labrig.experiment._probes import moves
from labrig.experiment._score import Judge, Problem, Sums

MOST_VISITS, MOST_ALIKE = 2, 4
"""How often one probe is done, and how often it and those made from it by small changes: many different looks
are safer than one look many times, since nature keeps to no formula."""

A_VISIT = 0.12
LEAST_RATE = 0.3
"""What a further visit must be worth per minute, beside what all visits so far are worth per minute."""

STARTS_S = (0.0, 120.0, 360.0)
CHANGES = 2
_BETTER = 1.02


@dataclass(frozen=True)
class Choice:
    """Probes, how often each is done, and what that is worth."""

    probes: tuple[Probe, ...]
    times: tuple[int, ...]
    worth: float


def search_programme(
    problem: Problem, seeds: Sequence[Probe], budget_s: float, changes: int = CHANGES
) -> Choice | None:
    """The probes that separate the rivals of a problem best per minute; None where nothing tells them apart."""
    probes = [p for p in seeds if p.seconds(problem.limits) <= budget_s]
    chosen = _from(problem, probes, budget_s)
    if chosen is None:
        return None
    for _ in range(changes):
        kept = list(chosen.probes)
        tried = [m for p in kept for m in moves(p, problem.limits.rest)]
        probes = [*kept, *(p for p in tried if p.seconds(problem.limits) <= budget_s)]
        better = _from(problem, probes, budget_s)
        if better is None or _rate(better, problem.limits) <= _BETTER * _rate(chosen, problem.limits):
            break
        chosen = better
    return chosen


def _rate(choice: Choice, limits: Limits) -> float:
    took = sum(n * p.seconds(limits) for p, n in zip(choice.probes, choice.times, strict=True))
    return choice.worth / took


def _from(problem: Problem, probes: Sequence[Probe], budget_s: float) -> Choice | None:
    starts = STARTS_S if problem.keeps_time else STARTS_S[:1]
    layouts = [problem.lay_out([p.points for p in probes], idle_s=idle_s) for idle_s in starts]
    judge = Judge(layouts[-1], problem.rivals)
    if not judge.pairs:
        return None
    seconds = np.array([p.seconds(problem.limits) for p in probes])
    goals = np.array([judge.goal(m) for m, _ in judge.pairs])
    chosen = _Greedy(
        judge, goals, [layout.programmes for layout in layouts], seconds, [p.name for p in probes]
    )
    times = chosen.fill(budget_s)
    own = chosen.order
    if not own:
        return None
    return Choice(tuple(probes[i] for i in own), tuple(times[i] for i in own), chosen.worth)


class _Greedy:
    """Adds the probe that is worth most per minute, until all is told apart or the time is used.

    What a programme is worth grows with the share of its goal that each pair reaches, ever more slowly, and
    likely explanations count for more. One
    visit counts for a part of the goal at most, for one look is no proof, and no capture should decide alone.
    `sums[k]` are those of the probes when the session is `STARTS_S[k]` old.
    """

    def __init__(
        self, judge: Judge, goals: Floats, sums: list[list[Sums]], seconds: Floats, names: Sequence[str]
    ) -> None:
        self.judge, self.goals, self.sums, self.seconds, self.names = judge, goals, sums, seconds, names
        self.total: Sums | None = None
        self.seen = np.zeros_like(goals)
        self.worth = 0.0
        self.order: list[int] = []
        self._alone: dict[tuple[int, int], Floats] = {}

    def alone(self, phase: int, i: int) -> Floats:
        """What one visit of a probe tells of each pair, at most `A_VISIT` of the goal."""
        if (phase, i) not in self._alone:
            self._alone[phase, i] = np.minimum(self.judge.apart(self.sums[phase][i]), A_VISIT * self.goals)
        return self._alone[phase, i]

    def with_one(self, phase: int, i: int) -> tuple[Sums, Floats, Floats]:
        """Sums, what was seen, and the share of each goal, with one more visit of a probe."""
        seen = self.seen + self.alone(phase, i)
        if self.total is None:
            return self.sums[phase][i], seen, seen / self.goals
        total = self.total + self.sums[phase][i]
        return total, seen, np.minimum(self.judge.apart(total), seen) / self.goals

    def _worth(self, share: Floats) -> float:
        """What reaching these shares of the goals is worth, each pair by how much it matters."""
        return float(self.judge.matters @ np.log1p(share))

    def _allowed(self, times: Sequence[int], i: int) -> bool:
        alike = sum(n for n, name in zip(times, self.names, strict=True) if name == self.names[i])
        return times[i] < MOST_VISITS and alike < MOST_ALIKE

    def fill(self, budget_s: float) -> list[int]:
        """How often to do each probe."""
        times = [0] * len(self.seconds)
        used, phase = 0.0, -1
        ahead = np.full(len(self.seconds), np.inf)
        while True:
            before, phase = phase, int(np.searchsorted(STARTS_S[: len(self.sums)], used, side="right")) - 1
            if phase != before:
                ahead[:] = np.inf
            gains = np.full(len(self.seconds), -np.inf)
            # what a probe adds mostly falls as others are added, so that old values are bounds (Minoux 1978)
            for i in np.argsort(-ahead):
                if used + self.seconds[i] > budget_s or not self._allowed(times, int(i)):
                    continue
                if ahead[i] <= gains.max():
                    break
                share = self.with_one(phase, int(i))[2]
                gains[i] = ahead[i] = (self._worth(share) - self.worth) / self.seconds[i]
            best = int(np.argmax(gains))
            if not gains[best] > max(1e-9, LEAST_RATE * self.worth / max(used, 1.0)):
                return times
            self.total, self.seen, share = self.with_one(phase, best)
            self.worth = self._worth(share)
            if best not in self.order:
                self.order.append(best)
            times[best] += 1
            used += self.seconds[best]
            if (share >= 1.0 - 1e-9).all():
                return times


def in_rounds(choice: Choice) -> list[int]:
    """The order of the probes: round after round, so that each is done early and late."""
    left = list(choice.times)
    order = []
    while any(left):
        for i, n in enumerate(left):
            if n:
                order.append(i)
                left[i] -= 1
    return order


def points_of(choice: Choice) -> tuple[list[Point], list[int]]:
    """All points in order, and which probe each belongs to."""
    points: list[Point] = []
    owner: list[int] = []
    for i in in_rounds(choice):
        points += choice.probes[i].points
        owner += [i] * len(choice.probes[i].points)
    return points, owner
