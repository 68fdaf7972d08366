"""The search for a programme: canonical probes first, then changes of those that were chosen."""

from collections.abc import Callable, Sequence
from dataclasses import dataclass

import numpy as np

from labrig.diagnosis._experiment_plan import Limits, Point, Probe
from labrig.diagnosis._experiment_probes import moves
from labrig.diagnosis._experiment_score import Judge, Problem, Sums
from labrig.effects._rows import Floats

FEWEST, MOST_VISITS = 3, 4
STARTS_S = (0.0, 120.0, 360.0)
_CHANGES = 2
_BETTER = 1.02


@dataclass(frozen=True)
class Choice:
    """Probes, how often each is done, and what that is worth."""

    probes: tuple[Probe, ...]
    times: tuple[int, ...]
    worth: float


def search_programme(problem: Problem, seeds: Sequence[Probe], budget_s: float) -> Choice | None:
    """The probes that separate the rivals of a problem best per minute; None where nothing tells them apart."""
    probes = [p for p in seeds if p.seconds(problem.limits) <= budget_s]
    chosen = _from(problem, probes, budget_s)
    if chosen is None:
        return None
    for _ in range(_CHANGES):
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
    judge = Judge(layouts[-1], [r.weight for r in problem.rivals])
    if not judge.pairs:
        return None
    seconds = np.array([p.seconds(problem.limits) for p in probes])
    goals = np.array([judge.goal(m) for m, _ in judge.pairs])

    def worth(planned: Sums) -> float:
        return float(np.log1p(judge.apart(planned) / goals).sum())

    def done(planned: Sums) -> bool:
        return bool((judge.apart(planned) >= goals).all())

    sums = [layout.programmes for layout in layouts]
    times, total = greedy(sums, starts, seconds, budget_s, worth, done)
    chosen = [i for i, n in enumerate(times) if n]
    if total is None:
        return None
    return Choice(tuple(probes[i] for i in chosen), tuple(times[i] for i in chosen), worth(total))


def greedy(
    sums: Sequence[Sequence[Sums]],
    starts_s: Sequence[float],
    seconds: Floats,
    budget_s: float,
    worth: Callable[[Sums], float],
    done: Callable[[Sums], bool],
) -> tuple[list[int], Sums | None]:
    """How often to do each probe: add what is worth most per minute until all is told apart or the time is used.

    `sums[k]` are those of the probes when the session is `starts_s[k]` old. Each is done at most `MOST_VISITS`
    times, and there are at least `FEWEST` visits where the time allows: one look is no proof.
    """
    times = [0] * len(seconds)
    total: Sums | None = None
    now, used, phase = 0.0, 0.0, -1
    ahead = np.full(len(seconds), np.inf)
    while True:
        before, phase = phase, int(np.searchsorted(starts_s, used, side="right")) - 1
        if phase != before:
            ahead[:] = np.inf
        gains = np.full(len(seconds), -np.inf)
        # what a probe adds only falls as others are added, so that old values are bounds (Minoux 1978)
        for i in np.argsort(-ahead):
            if used + seconds[i] > budget_s or times[i] >= MOST_VISITS:
                continue
            if ahead[i] <= gains.max():
                break
            own = sums[phase][i]
            gains[i] = ahead[i] = (worth(own if total is None else total + own) - now) / seconds[i]
        best = int(np.argmax(gains))
        if not gains[best] > 1e-9:
            return times, total
        times[best] += 1
        used += seconds[best]
        total = sums[phase][best] if total is None else total + sums[phase][best]
        now = worth(total)
        if done(total) and sum(times) >= FEWEST:
            return times, total


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
