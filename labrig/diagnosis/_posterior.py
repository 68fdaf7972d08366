"""The posterior: every set of up to three effects, beside what has no name, with its probability."""

from collections import Counter
from collections.abc import Iterator, Mapping, Sequence
from functools import cached_property
from itertools import chain, combinations

import numpy as np

from labrig.arrays import Floats
from labrig.diagnosis import _constants as k
from labrig.diagnosis._design import DECLARED, SLOW, Design
from labrig.diagnosis._evidence import (
    Beside,
    RaisedState,
    State,
    Sums,
    beside_free,
    free_variances,
)
from labrig.diagnosis._explanation import OF_BASE, Explanation, Form, Posterior, Raised, is_name, split
from labrig.diagnosis._freed import taken
from labrig.diagnosis._ripple import RIPPLE, RIPPLE_FLOORS
from labrig.diagnosis._signs import gains_alone, log_gain, log_gain_together

DECLARED_FLOORS = 300.0
"""What a base calls its own may have any size; of a static map, far more floors than any rig moves. Numerical."""
ALWAYS_FLOORS = {DECLARED: DECLARED_FLOORS, RIPPLE.key: RIPPLE_FLOORS}
"""Free patterns that are there in every explanation, and how large."""
_FAR = 10.0
"""By how many nats a form may be worse than the best one to be asked for its signs; numerical."""
_AT_ONCE = 4096
"""How many forms are asked for their signs at a time; numerical."""
_WIDE, _NARROW = 6, 2
"""How many singles are gone on with: without a background, and beside free patterns; numerical."""
_WORSE = 4.0
"""By how many nats larger sets may be worse than the best one for still larger ones to be looked at; numerical."""
_PAIRED = 4
"""Of how many of the likeliest free patterns two are looked at together; numerical."""
HOPELESS = 30.0
"""By how many nats a form may be worse than the best one to be counted; numerical: it is a part in 10^13."""


class Search:
    """Looks at sets of effects within each background of free patterns, and keeps all forms that it has looked at.

    `to_explain`: what there is to explain, floors. `sizes` and `traces`: prior sds, floors, of a part that is there and
    of a trace of one; `spike`: that of an owner that is absent. `blocks` are the numbers of each owner's blocks, `ways`
    the only way in which a block can act, by its number. `found` are the forms by the owners that are there in them;
    `signed` those whose score counts what acts one way only.
    """

    def __init__(self, design: Design) -> None:
        self.design = design
        self.to_explain = design.observations.to_explain
        self.sums = Sums.of(design, design.observations.worth)
        self.blocks: dict[str, list[int]] = {}
        for i, block in enumerate(design.blocks):
            self.blocks.setdefault(block.owner, []).append(i)
        self.ways = {i: block.way for i, block in enumerate(design.blocks) if block.way is not None}
        self.slow_at = design.blocks[self.blocks[SLOW][0]].at
        self.owners = [o for o in self.blocks if o not in (SLOW, DECLARED)]
        self.free = [f.owner for f in design.free if f.owner not in ALWAYS_FLOORS]
        self.free_shares = {f.owner: 1.0 / max(f.space.scanned, 1) for f in design.free}
        absent = max(len(self.owners) + len(self.free), 1)
        self.spike = float(k.SMALL * np.hypot(1.0, self.to_explain) / np.sqrt(absent))
        self.sizes = sorted({max(level * self.to_explain, k.LEAST_FLOORS) for level in k.LEVELS})
        self.traces = tuple(sorted({max(share * self.to_explain, k.SMALL) for share in k.TRACE_SHARES}))
        self.found: dict[frozenset[str], list[Form]] = {}
        self.seen: set[tuple[Raised, float]] = set()
        self.signed: set[tuple[Raised, float]] = set()
        self._states: dict[tuple[Raised, float], State] = {}
        self._log_priors: dict[tuple[str, int, float], float] = {}

    def state(self, background: Raised, slow: float) -> State:
        """The posterior where only a background of free patterns acts, and slow noise; worked out once for each."""
        key = (background, slow)
        if key not in self._states:
            least = min(k.SLOW_FLOORS)
            if background:
                small = free_variances(self.design, self.free_sizes(()))
                larger = free_variances(self.design, self.free_sizes(background))
                self._states[key] = self.state((), slow).beside(taken(self.sums, small, larger), self.small)
            elif slow > least:
                self._states[key] = self.state((), least).raised([self.slow_at], [slow]).whole
            else:
                self._states[key] = State.of(self.small, small_sizes(self.design, self.spike, slow))
        return self._states[key]

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
            if part not in self._log_priors:  # asked for tens of thousands of times
                self._log_priors[part] = self._prior_of(*part)
        return sum(self._log_priors[part] for part in raised)

    def _prior_of(self, owner: str, block: int, size: float) -> float:
        """Log prior probability of one part of a form; what has no name is rarer, as a trace too."""
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
        """The sd of slow noise, floors, that has the most evidence beside a form."""
        least, *larger = sorted(k.SLOW_FLOORS)
        background, raised = split(whole)
        begun = self.raise_blocks(background, least, raised)
        quads, logdets = begun.further(
            [self.slow_at], np.array(larger)
        )  # slow noise is a block that is raised
        evidence = -0.5 * np.array([begun.quad + begun.logdet, *(quads + logdets)[0]])
        return (least, *larger)[int(np.argmax(evidence))]

    def raise_blocks(self, background: Raised, slow: float, raised: Raised) -> RaisedState:
        """The state of a background with the blocks of a set raised."""
        ats = [self.design.blocks[b].at for _, b, _ in raised]
        return self.state(background, slow).raised(ats, [s for _, _, s in raised])

    def keep(self, whole: Raised, slow: float, score: float) -> float:
        """Remember a form of a set by its score."""
        if (form := (whole, slow)) not in self.seen:
            self.seen.add(form)
            owners = frozenset([o for o, _, size in whole if size not in self.traces])
            self.found.setdefault(owners, []).append(Form(score, whole, slow))
        return score

    def extend(self, background: Raised, slow: float, start: Raised) -> list[tuple[float, Raised]]:
        """The best form of each further owner beside a set, with its score, as a part of its own and as a trace; and of
        a second space of an owner that is there.
        """
        there = {owner: block for owner, block, size in start if size not in self.traces}
        parts = Counter(owner for owner, _, _ in start)
        further = {
            owner: blocks
            for owner in self.owners
            if parts[owner] <= (owner in there)
            and (blocks := [b for b in self.blocks[owner] if b != there.get(owner)])
        }
        levels = [list(self.traces)] if len(there) >= k.MOST_EFFECTS else [list(self.traces), self.sizes]
        asked = [b for blocks in further.values() for b in blocks]
        begun, already = self.raise_blocks(background, slow, start), self.prior((*background, *start))
        sign = self.sign(begun, start)
        quads, logdets = begun.further([self.design.blocks[b].at for b in asked], np.concatenate(levels))
        every = already - 0.5 * (quads + logdets) + self._priors[asked, : quads.shape[1]]
        best_of_each = []
        for owner, blocks, sizes, unsigned in _parted(further, levels, every):
            signed = unsigned + sign + self._signs_beside(begun, blocks, np.array(sizes), unsigned)
            best = signed.max()
            for i, j in np.argwhere(signed > best - HOPELESS).tolist():
                raised = tuple(sorted((*start, (owner, blocks[i], sizes[j]))))
                whole = tuple(sorted((*background, *raised))) if background else raised
                self.keep(whole, slow, float(unsigned[i, j]))
                if signed[i, j] == best:
                    best_of_each.append((float(best), raised))
        return best_of_each

    def sign(self, fitted: RaisedState, raised: Raised) -> float:
        """By how many nats those parts of a set that act one way only gain together."""
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

    def _signs_of(self, forms: Sequence[Form]) -> Floats:
        """By how many nats the parts of each form that act one way only gain together, (n,)."""
        gained = np.zeros(len(forms))
        alike: dict[tuple[Raised, float, int], list[int]] = {}  # as many such parts, of one state
        for i, form in enumerate(forms):
            background, raised = split(form.raised)
            alike.setdefault((background, form.slow, self._one_way(raised)), []).append(i)
        for (background, slow, _), own in alike.items():
            sets = [
                [(self.design.blocks[b].at, sd, b) for _, b, sd in split(forms[i].raised)[1]] for i in own
            ]
            gained[own] = gains_alone(self.state(background, slow), sets, self.ways)
        return gained

    def _one_way(self, raised: Raised) -> int:
        """How many parts of a form act one way only."""
        return sum(block in self.ways for _, block, _ in raised)

    def _signs_beside(
        self, begun: RaisedState, blocks: Sequence[int], sizes: Floats, unsigned: Floats
    ) -> Floats:
        """By how many nats each of these blocks gains at each of these sizes beside what has begun, (B, n), if it acts
        one way only; their scores are `unsigned` without. The likeliest first, while any may be the likeliest.
        """
        gained, best = np.zeros_like(unsigned), -np.inf
        for i in np.argsort(-unsigned.max(axis=1)) if any(b in self.ways for b in blocks) else ():
            if unsigned[i].max() + np.log(2.0) < best:
                break
            if (b := blocks[i]) in self.ways:
                gained[i] = log_gain(*begun.further_along(self.design.blocks[b].at, sizes, self.ways[b]))
            best = max(best, (unsigned[i] + gained[i]).max())
        return gained

    def settle(self, owners: frozenset[str] | None = None) -> None:
        """Add to the score of each form what its signs gain it in its joint fit, the likeliest first, as long as any
        may count: of all sets, or of the forms of one.
        """
        sets = self.found.values() if owners is None else [self.found.get(owners, [])]
        places = [(forms, i) for forms in sets for i in range(len(forms))] if self.ways else []
        scores, best = np.array([forms[i].score for forms, i in places]), -np.inf
        most_gained = np.log(2.0) * max((len(forms[i].raised) for forms, i in places), default=0)
        order = np.argsort(-scores, kind="stable")
        for batch in np.split(order, range(_AT_ONCE, len(order), _AT_ONCE)):
            if not len(batch) or scores[batch[0]] + most_gained < best - _FAR:
                return
            own = [places[j] for j in batch]
            asked = [(forms, i) for forms, i in own if self._gains_by_signs(forms[i], best - _FAR)]
            gained = self._signs_of([forms[i] for forms, i in asked])
            for (forms, i), gain in zip(asked, gained.tolist(), strict=True):
                score, raised, slow = forms[i]
                forms[i] = Form(score + gain, raised, slow)
                self.signed.add((raised, slow))
            best = max(best, *(forms[i].score for forms, i in own))

    def _gains_by_signs(self, form: Form, least: float) -> bool:
        """Whether signs may bring a form to the `least` score, and are not counted in it yet."""
        signs = self._one_way(form.raised)
        return (
            signs > 0
            and (form.raised, form.slow) not in self.signed
            and form.score + signs * np.log(2.0) >= least
        )

    @cached_property
    def _priors(self) -> Floats:
        """Log prior probability (B, n) of each block as each of the `traces`, then at each of the `sizes`."""
        sizes = [*self.traces, *self.sizes]
        owners = [block.owner for block in self.design.blocks]
        return np.array([[self.prior(((o, b, size),)) for size in sizes] for b, o in enumerate(owners)])

    def explore(self, background: Raised, slow: float, wide: int) -> float:
        """Look at sets of up to three owners on a background: all singles, pairs of the `wide` best of these, triples
        of half as many pairs; the best score.
        """
        best = self.score(background, slow, ())
        frontier: list[tuple[float, Raised]] = [(best, ())]
        for depth in range(k.MOST_EFFECTS + 2):  # two more: traces, and second spaces
            grown: dict[tuple, tuple[float, Raised]] = {}
            for score, raised in chain.from_iterable(
                self.extend(background, slow, start) for _, start in frontier
            ):
                kind = tuple((owner, size in self.traces) for owner, _, size in raised)
                if kind not in grown or score > grown[kind][0]:
                    grown[kind] = (score, raised)
            frontier = sorted(grown.values(), reverse=True)[: wide if depth == 0 else max(wide // 2, 2)]
            if not frontier or (depth and frontier[0][0] < best - _WORSE):
                break
            best = max(best, frontier[0][0])
        return best

    def run(self) -> "Search":
        """Look at sets of effects without any background, then beside each free pattern, then beside two of these."""
        slow = self.slow_beside(())
        self.explore((), slow, _WIDE)
        self.settle()
        again = self.slow_beside(self.best().raised)
        if again != slow:
            slow = again
            self.explore((), slow, _WIDE)
        self.settle()
        named = self._best_named()
        scores: dict[tuple[str, int, float], float] = {}
        for owner in self.free:
            for size in (self.traces[0], max(self.to_explain, k.LEAST_FLOORS)):
                pattern = (owner, -1, size)
                scores[pattern] = self.explore((pattern,), slow, _NARROW)
                if scores[pattern] - self.prior((pattern,)) < named:
                    break  # what a trace of it makes worse, more of it does as well
        ranked = sorted(scores, key=lambda pattern: -scores[pattern])
        for one, two in combinations(ranked[:_PAIRED], 2):
            if one[0] != two[0] and min(scores[one], scores[two]) > named:
                self.explore(tuple(sorted([one, two])), slow, _NARROW)
        self.settle()
        return self

    def forms(self) -> Iterator[Form]:
        """All forms that were looked at, set by set."""
        return chain(*self.found.values())

    def best(self) -> Form:
        """The likeliest form."""
        return max(self.forms(), key=lambda form: form.score)

    def _best_named(self) -> float:
        """The best score of a form in which all that is there has a name."""
        named = (forms for owners, forms in self.found.items() if not any(o.startswith("?") for o in owners))
        return max(form.score for form in chain(*named))

    def posterior(self) -> Posterior:
        """The sets that were looked at, as explanations, with their probabilities."""
        explanations = []
        for owners, forms in self.found.items():
            likeliest = max(forms, key=lambda form: form.score)
            score = float(np.logaddexp.reduce([form.score for form in forms]))
            explanations.append(Explanation(owners, likeliest.raised, score, likeliest.slow))
        explanations.sort(key=lambda e: -e.score)
        score = np.array([e.score for e in explanations])
        p = np.exp(score - score.max())
        return Posterior(explanations, p / p.sum())


def _parted(
    blocks: Mapping[str, list[int]], levels: Sequence[list[float]], scores: Floats
) -> Iterator[tuple[str, list[int], list[float], Floats]]:
    """The scores (B, n) of all owners' blocks at all sizes, owner by owner, level by level: the owner, its blocks, the
    sizes of the level, the scores.
    """
    row = 0
    for owner, own in blocks.items():
        column = 0
        for sizes in levels:
            yield owner, own, sizes, scores[row : row + len(own), column : column + len(sizes)]
            column += len(sizes)
        row += len(own)


def small_sizes(design: Design, spike: float, slow: float) -> Floats:
    """The prior sd (P,) of each column where nothing acts: that of all columns of an owner together is the `spike`."""
    blocks_of, square = Counter(b.owner for b in design.blocks), np.zeros(design.W.width)
    fixed = {SLOW: slow, DECLARED: DECLARED_FLOORS}
    for block in design.blocks:
        sd = fixed[block.owner] if block.owner in fixed else spike / np.sqrt(blocks_of[block.owner])
        square[block.at] += sd**2  # owners of the same space have the same columns
    return np.sqrt(square)
