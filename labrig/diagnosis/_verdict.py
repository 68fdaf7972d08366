"""The verdict: what the probabilities of all explanations say, in one word."""

from collections.abc import Callable, Collection, Mapping, Sequence
from dataclasses import dataclass, field, replace
from functools import cached_property
from typing import NamedTuple

import numpy as np
from scipy.special import ndtr

from labrig._text import counted
from labrig.diagnosis import _constants as k
from labrig.diagnosis._amount import amount
from labrig.diagnosis._calibration import shipped
from labrig.diagnosis._observations import Observations
from labrig.diagnosis._parts import missed, sizes
from labrig.diagnosis._posterior import CURVE, OF_BASE, REST, STATIC, Explanation, Search, is_name


@dataclass(frozen=True)
class Considered:
    """One effect: its probability, and its size in the joint fit with its standard deviation, in floors."""

    effect: str
    probability: float
    size_floors: float = 0.0
    size_sd_floors: float = 0.0
    by_evidence: float = 0.0
    """The probability by the evidence alone, which takes for granted that the law is of one of the families."""
    share: float = 0.0
    """How much would be missed without it, root mean square, of what there is to explain."""
    gone: float = 0.5
    """How probable it is, by evidence, that what it explains is gone where it was ruled out; a half where it was not,
    or where these captures can't tell."""
    seen: bool = True
    """Whether these runs could show it: else nobody knows whether it is there."""

    @property
    def call(self) -> str:
        """sure, possible, or not it."""
        if self.probability >= k.SURE:
            return "sure"
        return "possible" if self.probability >= k.POSSIBLE else "not it"


@dataclass(frozen=True)
class Verdict:
    """What is missing: `effects` that are sure, `rivals` that are possible, `considered` all of them, surest first.

    Of the rivals one is there, or, of those that are `together`, all of them.
    """

    verdict: str
    effects: tuple[str, ...]
    probability: float
    rivals: tuple[str, ...] = ()
    considered: tuple[Considered, ...] = ()
    carried_by: str = ""
    beside: Mapping[str, float] = field(default_factory=dict)
    """Unnamed structure beside the effects: how large, in floors, by what carries it."""
    warnings: tuple[str, ...] = ()
    within: Mapping[str, float] = field(default_factory=dict)
    """Effects that are there beside something larger without a name, where that is the verdict: their sizes, floors."""
    together: tuple[str, ...] = ()
    """Of the effects and rivals those that the likeliest explanation has together: partners, and no rivals."""

    @property
    def added(self) -> tuple[str, ...]:
        """What is fitted for the model: what is sure, and of the rivals those that act together, else the likeliest."""
        partners = tuple(name for name in self.rivals if name in self.together)
        return (*self.effects, *(partners or self.rivals[:1]))

    @property
    def found(self) -> tuple[str, ...]:
        """What is sure, or the only name that is left."""
        return self.effects or (self.rivals if len(self.rivals) == 1 else ())


class Size(NamedTuple):
    """How large an effect is in a joint fit, the sd of that, and what would be missed without it, in floors."""

    floors: float
    sd: float
    missed: float


@dataclass(frozen=True)
class Answer:
    """One explanation as an answer: effects, each with its size, and what has no name, with its size (no more than
    would be missed).
    """

    probability: float
    sizes: dict[str, Size]
    unnamed: dict[str, float]
    least: float
    """The size, in floors, from which a part is worth a name."""
    remembering: frozenset[str] = frozenset()
    """Effects that are no curve of the set-points, whatever else is."""
    shared: frozenset[str] = frozenset()
    """Those of them of which too little is seen that no such curve makes: it may be the curve as well as the effect."""
    whole: float = 1.0
    """What there is to explain, root mean square, in floors."""

    def limit(self, name: str) -> float:
        """The size, in floors, from which an effect is worth a name: beside what has none, a larger one.

        What the base is wrong in outvotes no name; nor does a curve of the set-points one of what is no such curve.
        """
        apart = OF_BASE | {STATIC} if name in self.remembering else OF_BASE
        return max(self.least, float(np.linalg.norm([v for o, v in self.unnamed.items() if o not in apart])))

    @cached_property
    def names(self) -> tuple[str, ...]:
        """The effects that are worth a name."""
        return tuple(o for o in self.sizes if self.counts(o) >= self.limit(o))

    def counts(self, name: str) -> float:
        """By how many floors an effect counts: its size, but no more than would be missed without it."""
        size = self.sizes.get(name)
        return min(size.floors, size.missed) if size else 0.0

    def worth(self, name: str) -> float:
        """Probability that a part of this size is an effect of its own, not the misfit of another's law."""
        own = float(ndtr(np.log(max(self.counts(name), 1e-12) / self.limit(name)) / k.MATERIAL_SPREAD))
        return own / 2 if name in self.shared else own

    @property
    def verdict(self) -> str:
        """The word for it alone."""
        if self.unnamed and not self.names:
            return "unknown"
        return ("nothing_missing", "identified")[bool(self.names)] if len(self.names) < 2 else "multiple"


def answers_of(
    search: Search, tolerance_floors: float = 0.0, remembering: Collection[str] = ()
) -> list[Answer]:
    """The likeliest explanations as answers, their probabilities summing to one.

    Effects that are `remembering` show in what no curve of the set-points makes of them: where that alone would not be
    found among so many numbers, or is no more than any law is off its family (`INEXACT`), they share their probability
    with such a curve.
    """
    posterior = search.posterior()
    least = max(k.MATERIAL * search.T, k.LEAST_FLOORS, tolerance_floors)
    observations = search.design.observations
    shows = np.hypot(_found_among(observations.values.size), k.INEXACT * search.T)
    doubt = np.sqrt(
        np.expm1(2 * k.FLOOR_SPREAD)
    )  # what is left when the noise is larger by one sd, about a floor
    kept = [
        (e, p)
        for e, p in zip(posterior.explanations, posterior.probability, strict=True)
        if p >= k.NEGLIGIBLE
    ]
    total = sum(p for _, p in kept)
    out = []
    for e, p in kept:
        joint = sizes(search, e)
        for share, lost in missed(search, e, least):
            if share * p / total < k.NEGLIGIBLE:
                continue
            found = joint | _without_the_rest(search, e, {o for o, size in lost.items() if size >= least})
            parts = {o: Size(size, sd, lost[o]) for o, (size, sd, _) in found.items() if is_name(o)}
            beyond = {o: found[o][2] for o in parts if o in remembering}
            shared = frozenset(o for o, size in beyond.items() if size < shows)
            curved = [min(parts[o].floors, lost[o]) for o in shared]
            unnamed = {o: min(found[o][0], size) for o, size in lost.items() if o.startswith("?")}
            unnamed = {o: size for o, size in unnamed.items() if size >= least}
            if (size := float(np.linalg.norm(curved))) >= least:
                unnamed[CURVE] = size
            if found[REST][0] >= doubt:
                unnamed[REST] = found[REST][0]
            out.append(
                Answer(
                    share * float(p / total), parts, unnamed, least, frozenset(remembering), shared, search.T
                )
            )
    return out


def _without_the_rest(
    search: Search, e: Explanation, stay: set[str]
) -> dict[str, tuple[float, float, float]]:
    """The sizes of the parts that stay, where others were let go: what these were is theirs, too."""
    raised = tuple(part for part in e.raised if part[0] in stay)
    if not raised or len(raised) == len(e.raised):
        return {}
    fitted = sizes(search, replace(e, owners=frozenset(stay), raised=raised))
    return {o: size for o, size in fitted.items() if o in stay}


def in_one_part(search: Search) -> str:
    """The chamber, or session, that the largest part of what is missing is in alone, whatever it is; empty where none
    is, surely.
    """
    posterior, blocks = search.posterior(), search.design.blocks
    total: dict[str, float] = {}
    for e, p in zip(posterior.explanations, posterior.probability, strict=True):
        _, block, _ = max(e.raised, key=lambda part: part[2], default=("", -1, 0.0))
        if block >= 0 and (part := blocks[block].space.alone_in):
            total[part] = total.get(part, 0.0) + float(p)
    most = max(total, key=lambda part: total[part], default="")
    return most if most and stated(total[most]) >= k.SURE else ""


def decide(
    answers: Sequence[Answer],
    effects: Sequence[str],
    words: Mapping[str, str],
    gone: Mapping[str, float] | None = None,
) -> Verdict:
    """Read the verdict off the answers; `words` says what carries each unnamed owner, `gone` how probable it is that
    what effects explain is gone where they were ruled out.
    """
    each = (_considered(name, answers, (gone or {}).get(name, 0.5)) for name in effects)
    considered = tuple(sorted(each, key=lambda c: -c.probability))
    word, sure, probability, possible = _read(considered)

    def share(test: Callable[[Answer], bool]) -> float:
        return float(sum(a.probability for a in answers if test(a)))

    unknown, nothing = share(lambda a: a.verdict == "unknown"), share(lambda a: not a.names and not a.unnamed)
    named = share(lambda a: bool(a.names))
    beside: dict[str, float] = {}
    for a in answers:
        for owner, size in a.unnamed.items():
            beside[words[owner]] = beside.get(words[owner], 0.0) + a.probability * size
    carried = max(beside, key=lambda w: beside[w], default="")
    stays = [c for c in considered if c.by_evidence * (1 - c.gone) >= 0.5]
    if nothing >= max(unknown, named):
        return Verdict("nothing_missing", (), stated(nothing), (), considered, "", beside)
    if unknown >= 0.5:
        there = {n: share(lambda a, n=n: a.counts(n) >= a.least) for n in effects}
        within = {
            n: sum(a.probability * a.counts(n) for a in answers)
            for n, p in there.items()
            if stated(p) >= k.SURE
        }
        return Verdict("unknown", (), stated(unknown), (), considered, carried, beside, within=within)
    if word == "unknown" and stays:
        carried = f"what acts as {stays[0].effect} does, and stays where that was ruled out"
    partners = _together(answers, (*sure, *possible))
    return Verdict(word, sure, probability, possible, considered, carried, beside, together=partners)


def _read(considered: Sequence[Considered]) -> tuple[str, tuple[str, ...], float, tuple[str, ...]]:
    """The word for what is said of each effect, those that are sure, how probable that is, and what is possible where
    one more is more probable than none.
    """
    sure = tuple(c.effect for c in considered if c.call == "sure")
    possible = tuple(c.effect for c in considered if c.call == "possible")
    some = 1 - float(np.prod([1 - c.probability for c in considered if c.effect in possible]))
    if some >= 0.5:
        return "confounded", sure, some, possible
    if not sure:
        return "unknown", (), 1 - some, ()
    return "identified" if len(sure) == 1 else "multiple", sure, _exactly(sure, considered), ()


def taken_back(verdict: Verdict, names: Mapping[str, str]) -> Verdict:
    """The same where these effects are not there, and what their words say carries what is missing instead: unknown,
    where no other name is left that is probable enough, and no more probable than that something was there.
    """
    considered = tuple(replace(c, probability=0.0) if c.effect in names else c for c in verdict.considered)
    considered = tuple(sorted(considered, key=lambda c: -c.probability))
    word, sure, probability, possible = _read(considered)
    return replace(
        verdict,
        verdict=word,
        effects=sure,
        probability=min(probability, verdict.probability) if word == "unknown" else probability,
        rivals=possible,
        considered=considered,
        carried_by=next(iter(names.values())),
        together=tuple(name for name in verdict.together if name in (*sure, *possible)),
    )


def less_sure(verdict: Verdict, names: Collection[str]) -> Verdict:
    """The same where of these names one cannot be sure: each is as likely as not, at most."""
    capped = (
        replace(c, probability=min(c.probability, 0.5)) if c.effect in names else c
        for c in verdict.considered
    )
    considered = tuple(sorted(capped, key=lambda c: -c.probability))
    word, sure, probability, possible = _read(considered)
    return replace(
        verdict, verdict=word, effects=sure, rivals=possible, probability=probability, considered=considered
    )


def not_told_apart(verdict: Verdict, alike: Collection[str]) -> Verdict:
    """The same where these names do the same to what was measured: where one is named, each has at least an even share
    of what they have together, and none is more probable than not.
    """
    seen = {c.effect: c.probability for c in verdict.considered if c.effect in alike and c.seen}
    if not seen.keys() & {*verdict.effects, *verdict.rivals}:
        return verdict
    even = min(sum(seen.values()), 1.0) / len(seen)
    shared = (
        replace(c, probability=max(c.probability, even)) if c.effect in seen else c
        for c in verdict.considered
    )
    return less_sure(replace(verdict, considered=tuple(shared)), seen)


def with_unseen(verdict: Verdict, owners: Collection[str]) -> Verdict:
    """The same, where only these `owners` have anything that they could be seen by."""
    return replace(verdict, considered=tuple(replace(c, seen=c.effect in owners) for c in verdict.considered))


def where_it_acts(verdict: Verdict, share: Mapping[str, float]) -> Verdict:
    """The same, with the sizes of effects that could act in a `share` of what was measured as they are there."""
    there = (
        replace(c, size_floors=c.size_floors / scale, size_sd_floors=c.size_sd_floors / scale)
        if (scale := float(np.sqrt(share.get(c.effect, 1.0)))) < 1
        else c
        for c in verdict.considered
    )
    return replace(verdict, considered=tuple(there))


def _together(answers: Sequence[Answer], names: Sequence[str]) -> tuple[str, ...]:
    """Those of these names, several, that evidence has together, more probably than not; else none."""
    total: dict[frozenset[str], float] = {}
    for a in answers:
        own = frozenset(a.names) & frozenset(names)
        total[own] = total.get(own, 0.0) + a.probability
    likeliest = max(total, key=lambda own: total[own], default=frozenset[str]())
    several = len(likeliest) > 1 and total[likeliest] >= 0.5  # even odds
    return tuple(name for name in names if name in likeliest) if several else ()


def _exactly(sure: Sequence[str], considered: Sequence[Considered]) -> float:
    """Probability that these effects are there, and no other beside them."""
    each = [c.probability if c.effect in sure else 1 - c.probability for c in considered]
    return float(np.prod(each))


def underpowered(
    observations: Observations, effects: Sequence[str], tolerance_floors: float, unit: str, floor: float
) -> Verdict | None:
    """The verdict where there are too few numbers to say anything, or too few for the tolerance asked; else None."""
    considered = tuple(Considered(name, 0.0) for name in effects)
    count = len(observations.values)
    if count < k.FEWEST_OBSERVATIONS:
        note = (
            f"{counted(observations.n_captures, 'capture')} with {count} independent rows can't tell effects apart: "
            f"measure at least {k.FEWEST_OBSERVATIONS}, some set-points twice, from above and from below, some for a "
            "minute"
        )
        return Verdict("underpowered", (), 1.0, (), considered, warnings=(note,))
    least = detectable_floors(observations)
    if tolerance_floors and least > tolerance_floors:
        note = (
            f"the smallest effect that these captures could show is {amount(least * floor, unit)}, larger than the "
            f"tolerance of {amount(tolerance_floors * floor, unit)}: measure more, or repeat set-points"
        )
        return Verdict("underpowered", (), k.SURE, (), considered, warnings=(note,))
    return None


def detectable_floors(observations: Observations) -> float:
    """The smallest effect, in floors, whose evidence would outweigh its prior and its freedom (Schwarz 1978)."""
    numbers = min(observations.values.size, k.INDEPENDENT, k.PER_CONDITION * observations.conditions)
    return max(_found_among(numbers), k.LEAST_FLOORS)


def _found_among(numbers: float) -> float:
    """The root mean square, in units of the noise, from which an effect is found among so many independent numbers."""
    needed = 2 * np.log(1 / k.P_EFFECT) + k.FREEDOM * np.log1p(numbers / k.FREEDOM)
    return float(np.sqrt(needed / numbers))


def stated(probability: float) -> float:
    """A probability, by evidence, of what is no name, as it is stated."""
    return shipped().stated(probability)


def _considered(name: str, answers: Sequence[Answer], gone: float) -> Considered:
    own = [
        (a.probability * a.worth(name), *a.sizes[name][:2], a.counts(name) / max(a.whole, k.LEAST_FLOORS))
        for a in answers
        if name in a.sizes
    ]
    if sum(p for p, *_ in own) < k.NEGLIGIBLE:
        return Considered(name, 0.0)
    p, size, sd, share = np.array(own).T
    by_evidence, mean, part = float(p.sum()), float(p @ size / p.sum()), float(p @ share / p.sum())
    spread = float((p * (sd**2 + (size - mean) ** 2)).sum() / p.sum())
    probability = shipped().of_name(name, by_evidence, part, gone)
    return Considered(name, probability, mean, float(np.sqrt(spread)), by_evidence, part, gone)
