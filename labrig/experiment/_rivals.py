"""The explanations that are still open, each with the forms in which the diagnosis finds it likely."""

from collections.abc import Mapping, Sequence
from dataclasses import dataclass, field

import numpy as np

from labrig.arrays import Floats
from labrig.contents import Summary
from labrig.diagnosis import Explained, Explanation
from labrig.effects import Effect

FORMS = 6
"""Forms of an explanation, likeliest first: what a programme says against one form, another one may hold."""
MOST_OTHERS = 4
LEAST_LIKELY = 0.1
"""What an explanation that is open counts for at least: as much as is called possible."""

NEXT_TO_IT = 0.04
"""Probability from which an effect that is not possible is told apart from the only one that is sure or possible."""


@dataclass(frozen=True)
class Rival:
    """One explanation: the names in it, its forms, best first, how the run weighs them (sum 1), its probability."""

    names: tuple[str, ...]
    forms: tuple[Explanation, ...]
    weight: Floats = field(repr=False)
    probability: float = 1.0

    @property
    def title(self) -> str:
        """The names, joined."""
        return " + ".join(self.names) or "no effect"


def open_sets(effects: Mapping[str, Effect], summary: Summary) -> list[tuple[tuple[str, ...], float]]:
    """Sets of effects, each with its probability: what is sure alone, and with each one that is possible beside it.

    Partners, which the likeliest explanation has together, are one set, and without each of them another. Where there
    is only one name, sure or possible, the likeliest other one in its place; a name that is only possible has at least
    no effect at all against it.
    """
    sure = tuple(str(n) for n in summary["effects"] if n in effects)
    considered = {str(c["effect"]): c for c in summary.get("effects_considered") or ()}
    chance = {n: float(c["probability"]) for n, c in considered.items() if n in effects}
    names = [str(n) for n in summary["rivals"]] or [n for n in chance if considered[n]["call"] == "possible"]
    possible = {n: chance.get(n, 1.0 / len(names)) for n in names if n in effects and n not in sure}
    likeliest = sorted(possible, key=lambda n: -possible[n])[:MOST_OTHERS]
    partners = [n for n in likeliest if n in summary.get("together", ())]
    if len(partners) > 1:
        return _with_and_without(sure, {n: possible[n] for n in partners})
    sets: list[tuple[tuple[str, ...], float]] = []
    sets += [((*sure, n), max(possible[n], LEAST_LIKELY)) for n in likeliest]
    rest = max(1.0 - sum(p for _, p in sets), LEAST_LIKELY)
    if sure and sets:
        sets.append((sure, rest))
    elif len([*sure, *likeliest]) == 1:
        only = (*sure, *likeliest)
        following = max((n for n in chance if n not in only), key=lambda n: chance[n], default="")
        if chance.get(following, 0.0) >= NEXT_TO_IT:
            return [
                (only, rest if sure else sets[0][1]),
                ((following,), max(chance[following], LEAST_LIKELY)),
            ]
        return [] if sure else [*sets, ((), rest)]
    return sets


def _with_and_without(
    sure: tuple[str, ...], partners: Mapping[str, float]
) -> list[tuple[tuple[str, ...], float]]:
    """All partners, each with its probability, beside what is sure, and all but each of them in turn."""
    whole = float(np.prod(list(partners.values())))
    sets = [((*sure, *partners), max(whole, LEAST_LIKELY))]
    for name, p in partners.items():
        others = tuple(n for n in partners if n != name)
        sets.append(((*sure, *others), max(whole / p * (1 - p), LEAST_LIKELY)))
    return sets


def open_rivals(explained: Explained, sets: Sequence[tuple[tuple[str, ...], float]]) -> list[Rival]:
    """Sets of effects, each with its probability, as explanations to tell apart; an empty list where fewer than two can
    act.
    """
    found = [(names, p, explained.forms(names, FORMS)) for names, p in sets]
    able = [(names, p, forms) for names, p, forms in found if forms]
    total = sum(p for _, p, _ in able)
    return [_rival(names, p / total, forms) for names, p, forms in able] if len(able) > 1 else []


def _rival(names: tuple[str, ...], probability: float, forms: Sequence[Explanation]) -> Rival:
    score = np.array([form.score for form in forms])
    weight = np.exp(score - score.max())
    return Rival(names, tuple(forms), weight / weight.sum(), probability)
