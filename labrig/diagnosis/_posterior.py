"""The posterior: every set of up to three effects, beside what has no name, with its probability."""

from collections.abc import Iterable, Mapping
from dataclasses import dataclass, field
from itertools import combinations

import numpy as np

from labrig.diagnosis import _constants as k
from labrig.diagnosis._design import SLOW, Block, Design
from labrig.diagnosis._evidence import DECLARED_FLOORS, State, Sums, beside_free, free_variances, unexplained

Raised = tuple[tuple[str, int, float], ...]
"""What is raised in an explanation: owner, number of its block (-1: a free pattern), prior sd in floors; sorted."""


@dataclass(frozen=True)
class Explanation:
    """One set of owners that act, in its likeliest form: `raised`; `score` its log evidence, over all its forms."""

    owners: frozenset[str]
    raised: Raised
    score: float
    slow: float


@dataclass
class Posterior:
    """The explanations that were looked at, likeliest first, with their probabilities."""

    design: Design
    sums: Sums
    to_explain: float
    spike: float
    explanations: list[Explanation] = field(default_factory=list)
    probability: np.ndarray = field(default_factory=lambda: np.zeros(0))


def named(owners: Iterable[str]) -> list[str]:
    """Those owners that are effects."""
    return [o for o in owners if not o.startswith("?") and o != SLOW]


class Search:
    """Looks at sets of effects within each background of free patterns."""

    def __init__(self, design: Design) -> None:
        self.design = design
        observations = design.observations
        self.sums = Sums.of(design, min(1.0, k.INDEPENDENT / observations.values.size))
        self.T = observations.to_explain
        self.blocks: dict[str, list[int]] = {}
        for i, block in enumerate(design.blocks):
            self.blocks.setdefault(block.owner, []).append(i)
        self.slow_at = design.blocks[self.blocks[SLOW][0]].at
        self.free = [f.owner for f in design.free if f.owner != "declared"]
        items = [o for o in self.blocks if o != SLOW] + self.free
        self.spike = float(np.hypot(k.SPIKE_FLOORS, k.SPIKE_SHARE * self.T) / np.sqrt(max(len(items), 1)))
        self.owners = [o for o in self.blocks if o != SLOW]
        self.sizes = sorted({max(level * self.T, k.LEAST_FLOORS) for level in k.LEVELS})
        self.trace = max(k.TRACE_SHARE * self.T, k.SPIKE_FLOORS)
        self.states: dict = {}
        self.found: dict[frozenset[str], list[tuple[float, Raised, float]]] = {}
        self.seen: set = set()

    def log_evidence(self, parts: tuple[float, float]) -> float:
        quad, logdet = parts
        return -0.5 * (quad + logdet)

    def state(self, background: Raised, slow: float) -> State:
        key = (background, slow)
        if key not in self.states:
            sd = dict.fromkeys([*self.free, "declared"], self.spike) | {"declared": DECLARED_FLOORS}
            sd |= {owner: size for owner, _, size in background}
            beside = beside_free(self.sums, free_variances(self.design, sd))
            own = np.empty(self.design.W.shape[1])
            for block in self.design.blocks:
                several = len(self.blocks[block.owner])
                own[block.at] = slow if block.owner == SLOW else self.spike / np.sqrt(several)
            self.states[key] = State(beside, own)
        return self.states[key]

    def prior(self, raised: Raised) -> float:
        out = 0.0
        for owner, block, size in raised:
            if block >= 0:
                out += np.log(self.design.blocks[block].share)
            if size == self.trace:
                out += np.log(k.P_TRACE)
                continue
            out += np.log(k.P_UNNAMED if owner.startswith("?") else k.P_EFFECT)
            out -= np.log(len(self.sizes))
        return float(out)

    def score(self, background: Raised, slow: float, raised: Raised) -> float:
        """Log evidence and prior of one form of one set."""
        state = self.state(background, slow)
        whole = tuple(sorted([*background, *raised]))
        if raised:
            parts = state.raised([self.design.blocks[b].at for _, b, _ in raised], [s for _, _, s in raised])
        else:
            parts = state.parts()
        value = self.log_evidence(parts) + self.prior(whole)
        if (whole, slow) not in self.seen:
            self.seen.add((whole, slow))
            owners = frozenset(o for o, _, size in whole if size != self.trace)
            self.found.setdefault(owners, []).append((value, whole, slow))
        return value

    def forms(self, owner: str) -> Iterable[tuple[str, int, float]]:
        for block in self.blocks[owner]:
            for size in (self.trace, *self.sizes):
                yield owner, block, size

    def extend(self, background: Raised, slow: float, start: Raised) -> list[tuple[float, Raised]]:
        """The best form of each further owner beside a set, as a part of its own and as a trace."""
        out = []
        have = {o for o, _, _ in start}
        full = sum(size != self.trace for _, _, size in start) >= k.MOST_EFFECTS
        for owner in self.owners:
            if owner in have:
                continue
            best: dict[bool, tuple[float, Raised]] = {}
            for form in self.forms(owner):
                trace = form[2] == self.trace
                if full and not trace:
                    continue
                raised = tuple(sorted([*start, form]))
                value = self.score(background, slow, raised)
                if trace not in best or value > best[trace][0]:
                    best[trace] = (value, raised)
            out += best.values()
        return out

    def explore(self, background: Raised, slow: float, wide: int) -> float:
        """Sets of up to three owners on a background: all singles, pairs of the best, triples of the best of those."""
        best = self.score(background, slow, ())
        frontier: list[tuple[float, Raised]] = [(best, ())]
        for depth in range(k.MOST_EFFECTS + 2):
            grown: dict[frozenset, tuple[float, Raised]] = {}
            for _, start in frontier:
                for value, raised in self.extend(background, slow, start):
                    kind = frozenset((o, size == self.trace) for o, _, size in raised)
                    if kind not in grown or value > grown[kind][0]:
                        grown[kind] = (value, raised)
            frontier = sorted(grown.values(), reverse=True)[: wide if depth == 0 else max(wide // 2, 2)]
            if not frontier or (depth and frontier[0][0] < best - 4):
                break
            best = max(best, frontier[0][0])
        return best

    def run(self) -> Posterior:
        slow = max(k.SLOW_FLOORS, key=lambda s: self.score((), s, ()))
        self.explore((), slow, 6)
        top = self.best()
        again = max(k.SLOW_FLOORS, key=lambda s: self.score_of(top, s))
        if again != slow:
            slow = again
            self.explore((), slow, 6)
        size = max(self.T, k.LEAST_FLOORS)
        alone = {}
        floor = self.floor_score(slow)
        for owner in self.free:
            for sd in (self.trace, size):
                background = ((owner, -1, sd),)
                alone[owner, sd] = self.explore(background, slow, 2)
        ranked = sorted(alone, key=lambda o: -alone[o])
        for a, b in combinations(ranked[:4], 2):
            if a[0] != b[0] and min(alone[a], alone[b]) > floor:
                self.explore(tuple(sorted([(a[0], -1, a[1]), (b[0], -1, b[1])])), slow, 2)
        return self.posterior()

    def floor_score(self, slow: float) -> float:
        return max(v for owners, forms in self.found.items() for v, _, s in forms if not any(o.startswith("?") for o in owners))

    def best(self) -> Raised:
        return max((f for forms in self.found.values() for f in forms), key=lambda f: f[0])[1]

    def score_of(self, whole: Raised, slow: float) -> float:
        background = tuple(q for q in whole if q[1] < 0)
        return self.score(background, slow, tuple(q for q in whole if q[1] >= 0))

    def posterior(self) -> Posterior:
        out = []
        for owners, forms in self.found.items():
            values = np.array([v for v, _, _ in forms])
            i = int(np.argmax(values))
            out.append(Explanation(owners, forms[i][1], float(np.logaddexp.reduce(values)), forms[i][2]))
        out.sort(key=lambda e: -e.score)
        score = np.array([e.score for e in out])
        p = np.exp(score - score.max())
        return Posterior(self.design, self.sums, self.T, self.spike, out, p / p.sum())


def material(posterior: Posterior, e: Explanation) -> dict[str, float]:
    """Names of an explanation that are worth one: share of the square that is lost when one is dropped, all else refitted."""
    design = posterior.design
    declared = {f.owner: (DECLARED_FLOORS if f.owner == "declared" else 0.0) for f in design.free}

    def left(keep: Iterable[str]) -> float:
        chosen = [q for q in e.raised if q[0] in keep]
        sd = declared | {o: s for o, b, s in chosen if b < 0}
        beside = beside_free(posterior.sums, free_variances(design, sd))
        slow = next(b for b in design.blocks if b.owner == SLOW)
        at = [design.blocks[b].at for _, b, _ in chosen if b >= 0]
        return unexplained(beside, [*at, slow.at], [*[s for _, b, s in chosen if b >= 0], e.slow])

    everything = [o for o, _, _ in e.raised]
    nothing, whole = left(()), left(everything)
    total = max(nothing - whole, 1e-9)
    return {o: float((left([q for q in everything if q != o]) - whole) / total) for o in everything}


def sizes(search: "Search", e: Explanation) -> dict[str, float]:
    """How large each part of an explanation is in the joint fit, root mean square in floors, by owner."""
    background = tuple(q for q in e.raised if q[1] < 0)
    state = search.state(background, e.slow)
    raised = [q for q in e.raised if q[1] >= 0]
    blocks = [search.design.blocks[b] for _, b, _ in raised]
    mean = state.fitted([b.at for b in blocks], [s for _, _, s in raised]).mean if raised else state.mean
    out = {}
    for (owner, _, _), block in zip(raised, blocks, strict=True):
        w = mean[block.at]
        out[owner] = float(np.sqrt(max(w @ block.rms @ w, 0.0)))
    return out


def inclusion(posterior: Posterior) -> Mapping[str, float]:
    """Probability of each owner to be in the explanation."""
    out: dict[str, float] = {}
    for e, p in zip(posterior.explanations, posterior.probability, strict=True):
        for owner in e.owners:
            out[owner] = out.get(owner, 0.0) + float(p)
    return out
