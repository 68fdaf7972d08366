"""The verdict: what the probabilities of all explanations say, in one word."""

from collections.abc import Mapping, Sequence
from dataclasses import dataclass, field

import numpy as np

from labrig.diagnosis import _constants as k
from labrig.diagnosis._observations import Observations
from labrig.diagnosis._posterior import Explanation, Search, is_name, material, sizes

FORMS = ("?form", "?static", "?place")
"""Unnamed structure that is a function of the pressures alone: a base that is wrong in form, no missing memory."""


@dataclass(frozen=True)
class Considered:
    """One effect: its probability, and its size in the joint fit with its standard deviation, in floors."""

    effect: str
    probability: float
    size_floors: float = 0.0
    size_sd_floors: float = 0.0

    @property
    def call(self) -> str:
        """sure, possible, or not it."""
        if self.probability >= k.SURE:
            return "sure"
        return "possible" if self.probability >= k.POSSIBLE else "not it"


@dataclass(frozen=True)
class Verdict:
    """What is missing: `effects` that are sure, `rivals` of which one is, `considered` all of them, surest first."""

    verdict: str
    effects: tuple[str, ...]
    probability: float
    rivals: tuple[str, ...] = ()
    considered: tuple[Considered, ...] = ()
    carried_by: str = ""
    beside: Mapping[str, float] = field(default_factory=dict)
    """Unnamed structure beside the effects: how large, in floors, by what carries it."""
    warnings: tuple[str, ...] = ()


@dataclass(frozen=True)
class Answer:
    """One explanation as an answer: the effects that are worth a name, and what has none, each with its size."""

    probability: float
    names: dict[str, tuple[float, float]]
    unnamed: dict[str, float]

    @property
    def moving(self) -> bool:
        """Whether something without a name depends on more than the pressures."""
        return any(owner not in FORMS for owner in self.unnamed)

    @property
    def verdict(self) -> str:
        """The word for it alone."""
        if self.moving or (self.unnamed and not self.names):
            return "unknown"
        return ("nothing_missing", "identified")[bool(self.names)] if len(self.names) < 2 else "multiple"


def answers_of(search: Search, tolerance_floors: float = 0.0) -> list[Answer]:
    """The likeliest explanations as answers, their probabilities summing to one."""
    posterior = search.posterior()
    least = max(k.MATERIAL * search.T, k.SMALLEST_FLOORS, tolerance_floors)
    kept = [
        (e, p)
        for e, p in zip(posterior.explanations, posterior.probability, strict=True)
        if p >= k.NEGLIGIBLE
    ]
    total = sum(p for _, p in kept)
    out = []
    for e, p in kept:
        found = sizes(search, e)
        names = {o: s for o, s in found.items() if is_name(o) and o in e.owners and s[0] >= least}
        unnamed = _unnamed(search, e, least)
        out.append(Answer(float(p / total), names, unnamed))
    return out


def _unnamed(search: Search, e: Explanation, least: float) -> dict[str, float]:
    """What has no name in an explanation, and would be missed, by owner."""
    owners = [o for o in e.owners if o.startswith("?")]
    if not owners:
        return {}
    lost = material(search, e, owners)
    size = {o: search.T * float(np.sqrt(max(lost[o], 0.0))) for o in owners}
    return {o: s for o, s in size.items() if s >= least}


def decide(answers: Sequence[Answer], effects: Sequence[str], words: Mapping[str, str]) -> Verdict:
    """Read the verdict off the answers; `words` says what carries each unnamed owner."""
    considered = tuple(sorted((_considered(name, answers) for name in effects), key=lambda c: -c.probability))
    sure = tuple(c.effect for c in considered if c.call == "sure")
    possible = tuple(c.effect for c in considered if c.call == "possible")

    def share(test) -> float:
        return float(sum(a.probability for a in answers if test(a)))

    unknown, nothing = share(lambda a: a.verdict == "unknown"), share(lambda a: not a.names and not a.unnamed)
    beside: dict[str, float] = {}
    for a in answers:
        for owner, size in a.unnamed.items():
            beside[words[owner]] = beside.get(words[owner], 0.0) + a.probability * size
    carried = max(beside, key=lambda w: beside[w], default="")
    if nothing >= max(unknown, 0.5) or not (unknown or sure or possible):
        return Verdict("nothing_missing", (), nothing, (), considered, "", beside)
    if unknown >= 0.5:
        return Verdict("unknown", (), unknown, (), considered, carried, beside)
    more = share(lambda a: set(a.names) > set(sure))
    if sure and more < 0.5:
        word = "identified" if len(sure) == 1 else "multiple"
        exact = share(lambda a: set(a.names) == set(sure) and a.verdict != "unknown")
        notes = tuple(
            f"beside it {c.effect} is possible ({c.probability:.0%})"
            for c in considered
            if c.call == "possible"
        )
        return Verdict(word, sure, exact, (), considered, carried, beside, notes)
    if possible:
        some = share(lambda a: bool(set(a.names) & set(possible)) and a.verdict != "unknown")
        return Verdict("confounded", sure, some, possible, considered, carried, beside)
    return Verdict("unknown", (), unknown, (), considered, carried, beside)


def underpowered(
    observations: Observations, effects: Sequence[str], tolerance_floors: float, unit: str, floor: float
) -> Verdict | None:
    """The verdict where there are too few numbers to say anything, or too few for the tolerance asked; else None."""
    considered = tuple(Considered(name, 0.0) for name in effects)
    count = len(observations.values)
    if count < k.FEWEST_OBSERVATIONS:
        note = (
            f"{observations.n_captures} captures with {count} independent rows can't tell effects apart: measure at least "
            f"{k.FEWEST_OBSERVATIONS}, some set-points twice, from above and from below, some held for a minute"
        )
        return Verdict("underpowered", (), 1.0, (), considered, warnings=(note,))
    least = detectable_floors(observations)
    if tolerance_floors and least > tolerance_floors:
        note = (
            f"the smallest effect that these captures could show is {least * floor:.2g} {unit}, larger than the "
            f"tolerance of {tolerance_floors * floor:.2g} {unit}: measure more, or repeat set-points"
        )
        return Verdict("underpowered", (), k.SURE, (), considered, warnings=(note,))
    return None


def detectable_floors(observations: Observations) -> float:
    """The smallest effect, in floors, whose evidence would outweigh its prior and its freedom (Schwarz 1978)."""
    numbers = min(float(observations.values.size), float(k.INDEPENDENT))
    needed = 2 * np.log(1 / k.P_EFFECT) + k.FREEDOM * np.log1p(numbers / k.FREEDOM)
    return float(max(np.sqrt(needed / numbers), k.SMALLEST_FLOORS))


def _considered(name: str, answers: Sequence[Answer]) -> Considered:
    own = [(a.probability, *a.names[name]) for a in answers if name in a.names]
    if not own:
        return Considered(name, 0.0)
    p, size, sd = np.array(own).T
    mean = float((p * size).sum() / p.sum())
    spread = float((p * (sd**2 + (size - mean) ** 2)).sum() / p.sum())
    return Considered(name, float(min(p.sum(), 1.0)), mean, float(np.sqrt(spread)))
