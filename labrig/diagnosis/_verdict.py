"""The verdict: what the probabilities of all explanations say, in one word."""

from collections.abc import Callable, Collection, Iterable, Mapping, Sequence
from dataclasses import dataclass, field, replace

import numpy as np

from labrig._text import counted
from labrig.diagnosis import _constants as k
from labrig.diagnosis._amount import amount
from labrig.diagnosis._answers import Answer, found_among
from labrig.diagnosis._calibration import shipped
from labrig.diagnosis._observations import Observations
from labrig.diagnosis._posterior import Search


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
    taken_back: tuple[str, ...] = ()
    """Effects that explain what is missing only turned round."""

    @property
    def added(self) -> tuple[str, ...]:
        """What is fitted for the model: what is sure, and of the rivals those that act together, else the likeliest."""
        partners = tuple(name for name in self.rivals if name in self.together)
        return (*self.effects, *(partners or self.rivals[:1]))

    @property
    def found(self) -> tuple[str, ...]:
        """What is sure, or the only name that is left."""
        return self.effects or (self.rivals if len(self.rivals) == 1 else ())


def in_one_part(search: Search) -> str:
    """The chamber or session that the largest part of what is missing surely is in alone; empty where there is none."""
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
    considered = _surest_first(_considered(name, answers, (gone or {}).get(name, 0.5)) for name in effects)
    word, sure, probability, possible = _read(considered)

    def share(test: Callable[[Answer], bool]) -> float:
        """The probability of the answers that pass a test."""
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


def _surest_first(considered: Iterable[Considered]) -> tuple[Considered, ...]:
    """The most probable effect first."""
    return tuple(sorted(considered, key=lambda c: -c.probability))


def _read(considered: Sequence[Considered]) -> tuple[str, tuple[str, ...], float, tuple[str, ...]]:
    """The verdict's word by each effect's probability, the sure effects, the probability of the verdict, and the
    possible effects; these only where it is more probable than not that one of them is there.
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
    """The verdict where these effects are not there, and what is missing is carried by what the first one's words say.

    It is unknown where no other effect is left that is probable enough, and then no surer than the verdict was.
    """
    considered = _surest_first(
        replace(c, probability=0.0) if c.effect in names else c for c in verdict.considered
    )
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
        taken_back=tuple(names),
    )


def in_its_place(verdict: Verdict, names: Collection[str], others: Collection[str]) -> Verdict:
    """The verdict where others, together, are as probable as not, and these names have the rest: each other may be
    there in their place.
    """
    if not others:
        return verdict
    even = 0.5 / len(others)
    shared = (
        replace(c, probability=max(c.probability, even))
        if c.effect in others
        else replace(c, probability=max(c.probability - 0.5, 0.0))
        if c.effect in names
        else c
        for c in verdict.considered
    )
    considered = _surest_first(shared)
    word, sure, probability, possible = _read(considered)
    return replace(
        verdict,
        verdict=word,
        effects=sure,
        rivals=possible,
        probability=probability,
        considered=considered,
        carried_by="",
    )


def less_sure(verdict: Verdict, names: Collection[str]) -> Verdict:
    """The verdict where these effects cannot be sure: each has a probability of a half, at most."""
    considered = _surest_first(
        replace(c, probability=min(c.probability, 0.5)) if c.effect in names else c
        for c in verdict.considered
    )
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
    """The verdict where only these `owners` could have been seen: only they have columns in the design."""
    return replace(verdict, considered=tuple(replace(c, seen=c.effect in owners) for c in verdict.considered))


def where_it_acts(verdict: Verdict, share: Mapping[str, float]) -> Verdict:
    """The verdict with the sizes of effects that could act only in a `share` of what was measured: sizes there."""
    there = (
        replace(c, size_floors=c.size_floors / scale, size_sd_floors=c.size_sd_floors / scale)
        if (scale := float(np.sqrt(share.get(c.effect, 1.0)))) < 1
        else c
        for c in verdict.considered
    )
    return replace(verdict, considered=tuple(there))


def _together(answers: Sequence[Answer], names: Sequence[str]) -> tuple[str, ...]:
    """Those of these effects, two or more, that are more probably there together than not; else none."""
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
    return max(found_among(numbers), k.LEAST_FLOORS)


def stated(probability: float) -> float:
    """The probability to state of anything but an effect, which has this one by evidence."""
    return shipped().stated(probability)


def _considered(name: str, answers: Sequence[Answer], gone: float) -> Considered:
    """What is said of one effect: means over the answers that have it, weighted by their probabilities."""
    each = [
        (a.probability * a.worth(name), *a.sizes[name][:2], a.counts(name) / max(a.whole, k.LEAST_FLOORS))
        for a in answers
        if name in a.sizes
    ]
    if sum(p for p, *_ in each) < k.NEGLIGIBLE:
        return Considered(name, 0.0)
    p, size, sd, share = np.array(each).T
    by_evidence, mean_size, mean_share = (
        float(v) for v in (p.sum(), p @ size / p.sum(), p @ share / p.sum())
    )
    variance = float((p * (sd**2 + (size - mean_size) ** 2)).sum() / p.sum())
    return Considered(
        effect=name,
        probability=shipped().of_name(name, by_evidence, mean_share, gone),
        size_floors=mean_size,
        size_sd_floors=float(np.sqrt(variance)),
        by_evidence=by_evidence,
        share=mean_share,
        gone=gone,
    )
