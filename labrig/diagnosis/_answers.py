"""Answers: what each explanation says is there, and how large it is."""

from collections.abc import Collection, Mapping
from dataclasses import dataclass, replace
from functools import cached_property
from typing import NamedTuple

import numpy as np
from scipy.special import ndtr

from labrig.diagnosis import _constants as k
from labrig.diagnosis._explanation import CURVE, OF_BASE, REST, STATIC, Explanation, is_name
from labrig.diagnosis._parts import PartSize, missed, sizes
from labrig.diagnosis._posterior import Search


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
    """Those of them that such a curve explains nearly as well: it may be there in place of the effect."""
    whole: float = 1.0
    """What there is to explain, root mean square, in floors."""

    def limit(self, name: str) -> float:
        """The size, in floors, from which an effect is worth a name: `least`, or that of all that has no name.

        Parts that stand for errors of the base do not count there; for an effect that remembers, curves of the
        set-points do not either.
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
    least = max(k.MATERIAL * search.to_explain, k.LEAST_FLOORS, tolerance_floors)
    kept = [
        (e, p)
        for e, p in zip(posterior.explanations, posterior.probability, strict=True)
        if p >= k.NEGLIGIBLE
    ]
    total = sum(p for _, p in kept)
    answers = []
    for e, p in kept:
        joint = sizes(search, e)
        for share, lost in missed(search, e, least):
            if share * p / total >= k.NEGLIGIBLE:
                stay = {o for o, size in lost.items() if size >= least}
                found = joint | _without_the_rest(search, e, stay)
                probability = share * float(p / total)
                answers.append(_answer(search, probability, found, lost, least, frozenset(remembering)))
    return answers


def _answer(
    search: Search,
    probability: float,
    found: Mapping[str, PartSize],
    lost: Mapping[str, float],
    least: float,
    remembering: frozenset[str],
) -> Answer:
    """An explanation as an answer: how large its parts were `found` to be, and what would be `lost` without them, by
    owner, in floors; see `answers_of`.
    """
    shows = np.hypot(found_among(search.design.observations.values.size), k.INEXACT * search.to_explain)
    doubt = np.sqrt(
        np.expm1(2 * k.FLOOR_SPREAD)
    )  # what is left where the noise is larger by one sd: about a floor
    parts = {o: Size(size.floors, size.sd, lost[o]) for o, size in found.items() if is_name(o)}
    shared = frozenset(o for o in parts if o in remembering and found[o].beyond_curves < shows)
    unnamed = {o: min(found[o].floors, size) for o, size in lost.items() if o.startswith("?")}
    unnamed = {o: size for o, size in unnamed.items() if size >= least}
    curved = float(np.linalg.norm([min(parts[o].floors, lost[o]) for o in shared]))
    if curved >= least:
        unnamed[CURVE] = curved
    if found[REST].floors >= doubt:
        unnamed[REST] = found[REST].floors
    return Answer(probability, parts, unnamed, least, remembering, shared, search.to_explain)


def _without_the_rest(search: Search, e: Explanation, stay: set[str]) -> dict[str, PartSize]:
    """The sizes of the parts that stay, fitted again without the others; empty where all stay, or none."""
    raised = tuple(part for part in e.raised if part[0] in stay)
    if not raised or len(raised) == len(e.raised):
        return {}
    fitted = sizes(search, replace(e, owners=frozenset(stay), raised=raised))
    return {o: size for o, size in fitted.items() if o in stay}


def found_among(numbers: float) -> float:
    """The root mean square, in units of the noise, from which an effect is found among so many independent numbers."""
    needed = 2 * np.log(1 / k.P_EFFECT) + k.FREEDOM * np.log1p(numbers / k.FREEDOM)
    return float(np.sqrt(needed / numbers))
