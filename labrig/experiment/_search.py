"""The search for a programme: canonical probes first, then changes of those that were chosen."""

from collections.abc import Sequence
from dataclasses import dataclass
from functools import reduce

import numpy as np

from labrig.arrays import Floats
from labrig.diagnosis import Outlook
from labrig.experiment._plan import Limits, Point, Probe
from labrig.experiment._probes import moves
from labrig.experiment._problem import Problem

CHANGES = 2
LEAST_GAIN = 1e-3
"""What a further probe must say about the open explanations, nats."""
TIMES_OVER = 3
"""How often a programme is to settle what is open, each time by other probes: no law is quite of its family."""
_BETTER = 1.02


@dataclass(frozen=True)
class Choice:
    """Probes in their order, how often each is done, and what that is worth, nats."""

    probes: tuple[Probe, ...]
    times: tuple[int, ...]
    worth: float


@dataclass(frozen=True)
class Chosen(Choice):
    """Probes, each done once, with what the explanations expect of each of them and of all together."""

    outlooks: tuple[Outlook, ...]
    together: Outlook


def search_programme(
    problem: Problem, seeds: Sequence[Probe], budget_s: float, changes: int = CHANGES
) -> Chosen | None:
    """The probes that say most per minute about which explanation is true; None where none says anything."""
    chosen = _fill(problem, seeds, budget_s)
    for _ in range(changes):
        if chosen is None:
            return None
        better = _fill(
            problem,
            [*chosen.probes, *(m for p in chosen.probes for m in moves(p, problem.limits.rest))],
            budget_s,
        )
        if better is None or _rate(better, problem.limits) <= _BETTER * _rate(chosen, problem.limits):
            break
        chosen = better
    return chosen


def _rate(choice: Choice, limits: Limits) -> float:
    return choice.worth / sum(p.seconds(limits) for p in choice.probes)


def _fill(problem: Problem, candidates: Sequence[Probe], budget_s: float) -> Chosen | None:
    """Programmes one after the other, each of which would settle what is open, as long as there are probes and time."""
    able = [p for p in candidates if p.seconds(problem.limits) <= budget_s]
    probes = list({p.points: p for p in able}.values())
    if not probes:
        return None
    outlooks = problem.outlooks([p.points for p in probes])
    seconds = np.array([p.seconds(problem.limits) for p in probes])
    alone = np.array([problem.information(outlook) for outlook in outlooks])
    order: list[int] = []
    for _ in range(TIMES_OVER):
        order += _settling(problem, outlooks, alone, seconds, order, budget_s - seconds[order].sum())
    if not order:
        return None
    chosen = tuple(outlooks[i] for i in order)
    together = reduce(lambda a, b: a.beside(b).condensed(), chosen)
    worth = problem.information(together)
    return Chosen(tuple(probes[i] for i in order), (1,) * len(order), worth, chosen, together)


def _settling(
    problem: Problem,
    outlooks: Sequence[Outlook],
    alone: Floats,
    seconds: Floats,
    used: Sequence[int],
    budget_s: float,
) -> list[int]:
    """Add the probe that says most per minute beside those before, until all is told apart or nothing says more.

    `alone` is what each of them says by itself, nats.
    """
    together: Outlook | None = None
    order: list[int] = []
    worth = 0.0
    ahead = alone / seconds
    ahead[list(used)] = -np.inf
    while True:
        gains = np.full(len(outlooks), -np.inf)
        # what a probe adds mostly falls as others are added, so that old values are bounds (Minoux 1978)
        for i in np.argsort(-ahead):
            if i in order or seconds[i] > budget_s:
                continue
            if ahead[i] <= gains.max():
                break
            if together is not None:
                with_it = together.beside(outlooks[i], last=True)
                ahead[i] = (problem.information(with_it) - worth) / seconds[i]
            gains[i] = ahead[i]
        best = int(np.argmax(gains))
        if not gains[best] * seconds[best] > LEAST_GAIN:
            return order
        together = outlooks[best] if together is None else together.beside(outlooks[best]).condensed()
        worth = problem.information(together)
        budget_s -= float(seconds[best])
        order.append(best)
        if (problem.log_bayes(together) >= problem.goals).all():
            return order


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
