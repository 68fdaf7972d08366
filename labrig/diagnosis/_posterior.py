"""The posterior: every set of up to three effects, beside what has no name, with its probability."""

from collections import Counter
from collections.abc import Sequence
from dataclasses import dataclass
from functools import cached_property
from itertools import combinations

import numpy as np

from labrig.arrays import Floats
from labrig.diagnosis import _constants as k
from labrig.diagnosis._curves import MAP
from labrig.diagnosis._design import DECLARED, SLOW, Design
from labrig.diagnosis._evidence import (
    Beside,
    RaisedState,
    State,
    Sums,
    beside_free,
    free_variances,
)
from labrig.diagnosis._freed import taken
from labrig.diagnosis._motions import MOTION
from labrig.diagnosis._ripple import RIPPLE, RIPPLE_FLOORS
from labrig.diagnosis._signs import gains_alone, log_gain, log_gain_together
from labrig.diagnosis._unnamed import FORM, LEVER

Raised = tuple[tuple[str, int, float], ...]
"""What is raised in an explanation: owner, number of its block (-1: a free pattern), prior sd in floors; sorted.

An owner may have two blocks in it: a law that lies in two of its spaces.
"""


@dataclass(frozen=True)
class Explanation:
    """One set of owners that act, in its likeliest form: `raised`; `score` its log evidence, over all its forms."""

    owners: frozenset[str]
    raised: Raised
    score: float
    slow: float


@dataclass(frozen=True)
class Posterior:
    """The explanations that were looked at, likeliest first, with their probabilities."""

    explanations: list[Explanation]
    probability: Floats


STATIC = "?static"
"""What several pressures do together, by the set-point alone."""
CURVE = "?curve"
"""What goes by the set-point alone of a part whose name is that of what remembers, or goes on."""
OF_BASE = frozenset({"?" + FORM, "?" + LEVER, "?" + MOTION, "?" + MAP, CURVE})
"""The owners of the base's own error of form: it has no name, and is no mystery."""
REST = "?rest"
"""What is more than noise and that no space follows."""
DECLARED_FLOORS = 300.0
"""What a base calls its own may have any size; of a static map, far more floors than any rig moves. Numerical."""
ALWAYS_FLOORS = {DECLARED: DECLARED_FLOORS, RIPPLE.key: RIPPLE_FLOORS}
"""Free patterns that are there in every explanation, and how large."""
_FAR = 10.0
"""By how many nats a form may be worse than the best one to be asked for its signs; numerical."""
_AT_ONCE = 4096
"""How many forms are asked for their signs at a time; numerical."""
HOPELESS = 30.0
"""By how many nats a form may be worse than the best one to be counted; numerical: it is a part in 10^13."""


class Search:
    """Looks at sets of effects within each background of free patterns."""

    def __init__(self, design: Design) -> None:
        self.design = design
        self.T = design.observations.to_explain
        self.sums = Sums.of(design, design.observations.worth)
        self.blocks: dict[str, list[int]] = {}
        for i, block in enumerate(design.blocks):
            self.blocks.setdefault(block.owner, []).append(i)
        self.slow_at = design.blocks[self.blocks[SLOW][0]].at
        self.free = [f.owner for f in design.free if f.owner not in ALWAYS_FLOORS]
        self.free_shares = {f.owner: 1.0 / max(f.space.scanned, 1) for f in design.free}
        self.owners = [o for o in self.blocks if o not in (SLOW, DECLARED)]
        items = self.owners + self.free
        self.spike = float(k.SMALL * np.hypot(1.0, self.T) / np.sqrt(max(len(items), 1)))
        self.sizes = sorted({max(level * self.T, k.LEAST_FLOORS) for level in k.LEVELS})
        self.traces = tuple(sorted({max(share * self.T, k.SMALL) for share in k.TRACE_SHARES}))
        self.states: dict = {}
        self.priors: dict[tuple[str, int, float], float] = {}
        self.found: dict[frozenset[str], list[tuple[float, Raised, float]]] = {}
        self.seen: set = set()
        self.ways = {i: block.way for i, block in enumerate(design.blocks) if block.way is not None}
        self.signed: set = set()

    def state(self, background: Raised, slow: float) -> State:
        key = (background, slow)
        if key not in self.states:
            least = min(k.SLOW_FLOORS)
            if background:
                small = free_variances(self.design, self.free_sizes(()))
                larger = free_variances(self.design, self.free_sizes(background))
                self.states[key] = self.state((), slow).beside(taken(self.sums, small, larger), self.small)
            elif slow > least:
                self.states[key] = self.state((), least).raised([self.slow_at], [slow]).whole
            else:
                self.states[key] = State.of(self.small, small_sizes(self.design, self.spike, slow))
        return self.states[key]

    @cached_property
    def small(self) -> Beside:
        """The sums beside all free patterns at their small size."""
        return beside_free(self.sums, free_variances(self.design, self.free_sizes(())))

    def free_sizes(self, background: Raised) -> dict[str, float]:
        """The prior sd of each free pattern, floors, when those of a background are raised."""
        sd = dict.fromkeys(self.free, self.spike) | ALWAYS_FLOORS
        return sd | {owner: size for owner, _, size in background}

    def prior(self, raised: Raised) -> float:
        """Log prior probability of one form of a set."""
        for part in raised:
            if part not in self.priors:  # asked for tens of thousands of times
                self.priors[part] = self._prior_of(*part)
        return sum(self.priors[part] for part in raised)

    def _prior_of(self, owner: str, block: int, size: float) -> float:
        """That of one part of it; what has no name is rarer, as a trace too."""
        usual = k.P_EFFECT if is_name(owner) or owner in OF_BASE else k.P_UNNAMED
        share = self.design.blocks[block].share if block >= 0 else self.free_shares[owner]
        if size in self.traces:
            return float(np.log(share * k.P_TRACE * usual / k.P_EFFECT / len(self.traces)))
        return float(np.log(share * usual / len(self.sizes)))

    def score(self, background: Raised, slow: float, raised: Raised) -> float:
        """Log evidence and prior of one form of one set."""
        fitted = self.raise_blocks(background, slow, raised)
        whole = tuple(sorted([*background, *raised]))
        return self.keep(whole, slow, self.prior(whole) - 0.5 * (fitted.quad + fitted.logdet))

    def slow_beside(self, whole: Raised) -> float:
        """The size of slow noise that has the most evidence beside a form: each larger one is the least one raised."""
        least, *larger = sorted(k.SLOW_FLOORS)
        background, raised = split(whole)
        begun = self.raise_blocks(background, least, raised)
        quads, logdets = begun.further([self.slow_at], np.array(larger))
        evidence = -0.5 * np.array([begun.quad + begun.logdet, *(quads + logdets)[0]])
        return (least, *larger)[int(np.argmax(evidence))]

    def raise_blocks(self, background: Raised, slow: float, raised: Raised) -> RaisedState:
        """The state of a background with the blocks of a set raised."""
        ats = [self.design.blocks[b].at for _, b, _ in raised]
        return self.state(background, slow).raised(ats, [s for _, _, s in raised])

    def keep(self, whole: Raised, slow: float, value: float) -> float:
        """Remember a form of a set by its score."""
        if (form := (whole, slow)) not in self.seen:
            self.seen.add(form)
            owners = frozenset([o for o, _, size in whole if size not in self.traces])
            self.found.setdefault(owners, []).append((value, whole, slow))
        return value

    def extend(self, background: Raised, slow: float, start: Raised) -> list[tuple[float, Raised]]:
        """The best form of each further owner beside a set, as a part of its own and as a trace, and of a second space
        of an owner that is there.
        """
        out = []
        have = Counter(o for o, _, _ in start)
        first = {o: block for o, block, size in start if size not in self.traces}
        full = len(first) >= k.MOST_EFFECTS
        levels = [list(self.traces)] if full else [list(self.traces), self.sizes]
        asked = np.concatenate(levels)
        begun, already = self.raise_blocks(background, slow, start), self.prior((*background, *start))
        sign = self.sign(begun, start)
        free = {
            owner: [b for b in self.blocks[owner] if b != first.get(owner)]
            for owner in self.owners
            if have[owner] <= (owner in first)
        }
        every = [b for blocks in free.values() for b in blocks]
        quads, logdets = begun.further([self.design.blocks[b].at for b in every], asked)
        gained, done = already - 0.5 * (quads + logdets), 0
        for owner, blocks in free.items():
            if not blocks:
                continue
            evidence, at = gained[done : (done := done + len(blocks))], 0
            for some in levels:
                own = slice(at, at := at + len(some))
                unsigned = evidence[:, own] + self._priors[blocks, own]
                values = unsigned + sign + self._signs(begun, blocks, asked[own], unsigned)
                best = values.max()
                for i, j in np.argwhere(values > best - HOPELESS).tolist():
                    raised = tuple(sorted((*start, (owner, blocks[i], some[j]))))
                    whole = tuple(sorted((*background, *raised))) if background else raised
                    self.keep(whole, slow, float(unsigned[i, j]))
                    if values[i, j] == best:
                        out.append((float(best), raised))
        return out

    def sign(self, fitted: RaisedState, raised: Raised) -> float:
        """What those parts of a set gain together that act one way only."""
        parts = [b for _, b, _ in raised if b in self.ways]
        if not parts:
            return 0.0
        ways = np.zeros((len(parts), len(fitted.mean)))
        for row, b in zip(ways, parts, strict=True):
            row[self.design.blocks[b].at] = self.ways[b]
        own = np.flatnonzero(ways.any(axis=0))
        along = ways[:, own]
        covariance = along @ fitted.covariance(own) @ along.T
        return float(log_gain_together((along @ fitted.mean[own])[None], covariance[None])[0])

    def _signs_alone(self, forms: Sequence[tuple[Raised, float]]) -> Floats:
        """The same of each of some whole forms, with its slow noise, (n,)."""
        out, alike = np.zeros(len(forms)), {}
        for i, (whole, slow) in enumerate(forms):
            background, raised = split(whole)
            parts = [(self.design.blocks[b].at, sd, b) for _, b, sd in raised]
            own = alike.setdefault((background, slow, sum(b in self.ways for _, _, b in parts)), [])
            own.append((i, parts))
        for (background, slow, _), own in alike.items():
            at, sets = zip(*own, strict=True)
            out[list(at)] = gains_alone(self.state(background, slow), sets, self.ways)
        return out

    def _signs(self, begun: RaisedState, blocks: Sequence[int], sizes: Floats, values: Floats) -> Floats:
        """The same of each of these blocks at each of these sizes beside what has begun, (B, n), where they have these
        `values` without: of the likeliest first, while any may be the likeliest.
        """
        out, best = np.zeros_like(values), -np.inf
        for i in np.argsort(-values.max(axis=1)) if any(b in self.ways for b in blocks) else ():
            if values[i].max() + np.log(2.0) < best:
                break
            if (b := blocks[i]) in self.ways:
                out[i] = log_gain(*begun.further_along(self.design.blocks[b].at, sizes, self.ways[b]))
            best = max(best, (values[i] + out[i]).max())
        return out

    def settle(self, owners: frozenset[str] | None = None) -> None:
        """Give each form what its signs gain it in its joint fit, the likeliest first, as long as any may count: of all
        sets, or of the forms of one.
        """
        sets = self.found.values() if owners is None else [self.found.get(owners, [])]
        each = [(forms, i) for forms in sets for i in range(len(forms))] if self.ways else []
        values, best = np.array([forms[i][0] for forms, i in each]), -np.inf
        most_gained = np.log(2.0) * max((len(forms[i][1]) for forms, i in each), default=0)
        order = np.argsort(-values, kind="stable")
        for some in np.split(order, range(_AT_ONCE, len(order), _AT_ONCE)):
            if not len(some) or values[some[0]] + most_gained < best - _FAR:
                return
            asked = {}
            for j in some:
                forms, i = each[j]
                value, whole, slow = forms[i]
                signs = sum(block in self.ways for _, block, _ in whole)
                if signs and (whole, slow) not in self.signed and value + signs * np.log(2.0) >= best - _FAR:
                    asked[j] = whole, slow
            gained = dict(zip(asked, self._signs_alone(list(asked.values())), strict=True))
            for j in some:
                forms, i = each[j]
                value, whole, slow = forms[i]
                if j in gained:
                    value += float(gained[j])
                    self.signed.add((whole, slow))
                    forms[i] = (value, whole, slow)
                best = max(best, value)

    @cached_property
    def _priors(self) -> Floats:
        """Log prior probability (B, n) of each of the design's blocks as each trace, then at each size of what acts."""
        sizes = [*self.traces, *self.sizes]
        owners = [block.owner for block in self.design.blocks]
        return np.array([[self.prior(((o, b, size),)) for size in sizes] for b, o in enumerate(owners)])

    def explore(self, background: Raised, slow: float, wide: int) -> float:
        """Sets of up to three owners on a background: all singles, pairs of the best, triples of the best of those."""
        best = self.score(background, slow, ())
        frontier: list[tuple[float, Raised]] = [(best, ())]
        for depth in range(k.MOST_EFFECTS + 2):
            grown: dict[tuple, tuple[float, Raised]] = {}
            for _, start in frontier:
                for value, raised in self.extend(background, slow, start):
                    kind = tuple((o, size in self.traces) for o, _, size in raised)
                    if kind not in grown or value > grown[kind][0]:
                        grown[kind] = (value, raised)
            frontier = sorted(grown.values(), reverse=True)[: wide if depth == 0 else max(wide // 2, 2)]
            if not frontier or (depth and frontier[0][0] < best - 4):
                break
            best = max(best, frontier[0][0])
        return best

    def run(self) -> "Search":
        """Look at everything that is worth looking at."""
        slow = self.slow_beside(())
        self.explore((), slow, 6)
        self.settle()
        again = self.slow_beside(self.best())
        if again != slow:
            slow = again
            self.explore((), slow, 6)
        self.settle()
        size = max(self.T, k.LEAST_FLOORS)
        alone = {}
        floor = self.floor_score()
        for owner in self.free:
            for sd in (self.traces[0], size):
                background = ((owner, -1, sd),)
                alone[owner, sd] = self.explore(background, slow, 2)
                if alone[owner, sd] - self.prior(background) < floor:
                    break  # what a trace of it makes worse, more of it does as well
        ranked = sorted(alone, key=lambda o: -alone[o])
        for a, b in combinations(ranked[:4], 2):
            if a[0] != b[0] and min(alone[a], alone[b]) > floor:
                self.explore(tuple(sorted([(a[0], -1, a[1]), (b[0], -1, b[1])])), slow, 2)
        self.settle()
        return self

    def floor_score(self) -> float:
        return max(
            v
            for owners, forms in self.found.items()
            for v, _, s in forms
            if not any(o.startswith("?") for o in owners)
        )

    def best(self) -> Raised:
        return max((f for forms in self.found.values() for f in forms), key=lambda f: f[0])[1]

    def posterior(self) -> Posterior:
        out = []
        for owners, forms in self.found.items():
            values = np.array([v for v, _, _ in forms])
            i = int(np.argmax(values))
            out.append(Explanation(owners, forms[i][1], float(np.logaddexp.reduce(values)), forms[i][2]))
        out.sort(key=lambda e: -e.score)
        score = np.array([e.score for e in out])
        p = np.exp(score - score.max())
        return Posterior(out, p / p.sum())


def small_sizes(design: Design, spike: float, slow: float) -> Floats:
    """The prior sd (P,) of each column where nothing acts: that of all columns of an owner together is the `spike`."""
    several, square = Counter(b.owner for b in design.blocks), np.zeros(design.W.width)
    fixed = {SLOW: slow, DECLARED: DECLARED_FLOORS}
    for block in design.blocks:
        own = fixed[block.owner] if block.owner in fixed else spike / np.sqrt(several[block.owner])
        square[block.at] += own**2
    return np.sqrt(square)


def split(raised: Raised) -> tuple[Raised, Raised]:
    """The free patterns of a form, and its other parts."""
    return tuple(q for q in raised if q[1] < 0), tuple(q for q in raised if q[1] >= 0)


def is_name(owner: str) -> bool:
    """Whether an owner is an effect."""
    return not owner.startswith("?") and owner not in (SLOW, DECLARED)
