"""Which effects earn a place: every form of every effect, scored out of sample, one added at a time."""

from collections.abc import Mapping, Sequence
from dataclasses import dataclass, replace
from functools import cached_property

import numpy as np

from labrig.diagnosis._columns import Columns, coefficients, columns_of, join, order_of
from labrig.diagnosis._score import Score, null_gains, score
from labrig.diagnosis._streams import Streams
from labrig.effects import Context, Effect, Term, Variant
from labrig.effects._fields import contribution, term_width
from labrig.effects._rows import Floats

MAX_EFFECTS = 3
KEPT_FORMS = 4
DRAWS = 299
SIGNIFICANT = 0.02
CLEAR_SE = 1.0
LOCAL_Z = 2.0
LOCAL_OF_FLOOR = 0.55
TIE_SHARE = 0.05
SAME_SHARE = 0.015
OWN_SHARE = 0.05
SMALLEST_OF_FLOOR = 0.33
SMALLEST_SHARE = 0.06


@dataclass(frozen=True)
class Candidate:
    """One form of one effect, laid out and scored on its own."""

    effect: Effect
    variant: Variant
    columns: Columns
    score: Score

    @property
    def freedom(self) -> int:
        """How many coefficients the form has; a free pattern has one for each observable."""
        return sum(term_width(t, self.columns.streams.residual.shape[1]) for t in self.variant.terms)


@dataclass(frozen=True)
class Fit:
    """Several effects fitted together."""

    parts: tuple[Candidate, ...]
    columns: Columns
    score: Score

    @property
    def names(self) -> tuple[str, ...]:
        """The effects, in the order in which they came in."""
        return tuple(p.effect.name for p in self.parts)

    def own(self, i: int) -> Floats:
        """Coefficients of the i-th effect, in the order of its own columns."""
        return self.score.beta[order_of([p.columns for p in self.parts])[i]]

    @cached_property
    def heldout(self) -> Floats:
        """Prediction of each stream row by the fit that did not see its block, (S, K)."""
        streams = self.columns.streams
        out = np.zeros_like(streams.residual)
        for g, own in enumerate(streams.blocks):
            out[own] = self.columns.field(self.score.fold_beta[g])[own]
        return out + streams.nothing


def fit(parts: Sequence[Candidate]) -> Fit:
    """Fit effects together and score them out of sample."""
    columns = join([p.columns for p in parts])
    return Fit(tuple(parts), columns, score(columns))


def explore(
    streams: Streams, context: Context, effects: Mapping[str, Effect], signs: Floats
) -> tuple[dict[str, list[Candidate]], Floats]:
    """Score every form of every effect alone.

    Returns the best few plausible forms of each effect, best first, and the largest relative gain that the
    whole search would have found in each draw of the null, (B,).
    """
    found: dict[str, list[Candidate]] = {}
    largest = np.zeros(len(signs))
    beside = streams.beside_static()
    for name, effect in effects.items():
        kept: list[Candidate] = []
        for variant in effect.variants(context):
            columns = columns_of(streams, variant)
            if columns.width == 0:
                continue
            scored = score(columns)
            largest = np.maximum(largest, null_gains(columns, signs, scored.ridge, streams.base_squares))
            if not plausible(effect, variant, columns, scored):
                continue
            kept.append(Candidate(effect, variant, columns, scored))
            kept.sort(key=lambda c: -c.score.gain)
            del kept[KEPT_FORMS:]
        kept = [c for c in kept if stands_alone(c, beside)]
        if kept:
            found[name] = kept
    return found, largest


def plausible(effect: Effect, variant: Variant, columns: Columns, scored: Score) -> bool:
    """Whether the fitted values lie within their physical bounds, or within two standard errors of them.

    Of a parameter with one value per chamber the mean counts, weighted by what each says.
    """
    q = columns.X.shape[2]
    at_x, at_e = 0, q
    n_patterns = columns.streams.n_patterns
    for term in variant.terms:
        r = (
            6
            if term.kind == "frame"
            else term.feature.shape[-1] * (n_patterns if term.kind == "pattern" else 1)
        )
        in_fields = term.kind == "field" or q == 0
        start = at_e if in_fields else at_x
        own = slice(start, start + r)
        at_e, at_x = (at_e + r, at_x) if in_fields else (at_e, at_x + r)
        parameter = effect.parameter(term.parameter)
        if term.kind == "pattern" and parameter.low >= 0 and not _along(columns, scored.beta[own], term):
            return False
        if term.kind in {"pattern", "frame"}:
            continue
        variance = np.diag(scored.covariance)[own]
        live = variance > 0
        if not live.any():
            continue
        weight = np.where(live, 1 / np.where(live, variance, 1.0), 0.0)
        jack = scored.fold_beta[:, own]
        value = float(np.sum(weight * scored.beta[own]) / weight.sum())
        each = jack @ weight / weight.sum()
        n = len(each)
        sd = float(np.sqrt((n - 1) / n * np.sum((each - each.mean()) ** 2)))
        if value < parameter.low - 2 * sd or value > parameter.high + 2 * sd:
            return False
    return True


def _along(columns: Columns, beta: Floats, term: Term) -> bool:
    """Whether a free pattern points the way in which the base itself moves, chamber by chamber."""
    streams = columns.streams
    pattern = beta.reshape(-1, streams.n_patterns) @ streams.patterns
    reach = streams.context.jacobian.mean(axis=0).T
    if len(pattern) != len(reach) or not np.abs(reach).any():
        return True
    return bool((pattern * reach / streams.floor.row**2).sum() > 0)


def stands_alone(candidate: Candidate, beside: Streams | None) -> bool:
    """Whether the effect explains something that a static map of the pressures does not."""
    needed = candidate.effect.beyond_static
    reversed_ = candidate.columns.streams.context.reverses
    if beside is None or needed == "no" or (needed == "if reversed" and not reversed_):
        return True
    scored = score(columns_of(beside, candidate.variant))
    return clear(scored.gains, beside.base_squares) and scored.gain > OWN_SHARE * candidate.score.gain


def clear(gains: Floats, base: Floats) -> bool:
    """Whether gains are more than their standard error, as they are or each as a share of its block's square."""
    for each in (gains, gains / np.maximum(base, 1e-300)):
        n = len(each)
        if each.sum() > CLEAR_SE * np.sqrt(n / max(n - 1, 1) * np.sum((each - each.mean()) ** 2)):
            return True
    return False


def relative(gains: Floats, base: Floats) -> float:
    """Gains as shares of what each block had, summed: no single block can carry it."""
    return float((gains / np.maximum(base, 1e-300)).sum())


def draw_signs(n_groups: int, seed: int = 0, draws: int = DRAWS) -> Floats:
    """Random signs of whole blocks, (B, G), the same for every run of the same shape."""
    rng = np.random.default_rng(seed)
    return rng.choice([-1.0, 1.0], size=(draws, n_groups))


def mean_square(streams: Streams, left: Floats) -> Floats:
    """Mean square of what is left (S, K), per observable (K,), captures counting alike; NaN if never seen."""
    seen = streams.weight > 0
    n_means = int(streams.index.max()) + 1 if streams.use_means else 0
    total = np.zeros(left.shape[1])
    for rows in (slice(0, n_means), slice(n_means, len(left))):
        each = seen[rows]
        if len(each):
            square = np.where(each, left[rows] ** 2, 0.0).sum(axis=0)
            total += square / np.maximum(each.sum(axis=0), 1)
    return np.where(seen.any(axis=0), total, np.nan)


@dataclass(frozen=True)
class Gate:
    """What an effect must pass to come in."""

    floor_square: float
    base_square: float
    tolerance: float | None

    def smallest(self, share: float) -> float:
        """The least fall of the mean square that matters."""
        least = (SMALLEST_OF_FLOOR**2) * self.floor_square
        least = max(least, share * max(self.base_square - self.floor_square, 0.0))
        return max(least, self.tolerance**2) if self.tolerance else least


def square_of(streams: Streams, left: Floats) -> float:
    """Mean square of what is left over the observables that errors are quoted for."""
    return float(np.nanmean(mean_square(streams, left)[streams.counted]))


def select(streams: Streams, found: Mapping[str, list[Candidate]], p_first: float, gate: Gate) -> Fit | None:
    """Forward selection of up to three effects, then swap and prune, all on the held-out score."""
    signs = draw_signs(streams.n_groups, seed=1)
    chosen: Fit | None = None
    while chosen is None or len(chosen.parts) < MAX_EFFECTS:
        if chosen is not None:
            found = {**found, **_look_again(streams, chosen, found)}
        best = _best_addition(chosen, found)
        if best is None or not _earns(streams, chosen, best, gate):
            break
        p = p_first if chosen is None else _p_of_addition(streams, chosen, found, best, signs)
        if p > SIGNIFICANT and not _clear_locally(streams, chosen, best, gate):
            break
        chosen = _simplest(_swap(best, found), found)
    return None if chosen is None else _prune(streams, chosen, gate)


def _look_again(
    streams: Streams, chosen: Fit, found: Mapping[str, list[Candidate]]
) -> dict[str, list[Candidate]]:
    """New forms of the effects that are found by scanning the residuals, now that `chosen` explains some."""
    scanning = [
        forms[0].effect for name, forms in found.items() if forms[0].effect.scans and name not in chosen.names
    ]
    if not scanning:
        return {}
    context = streams.context
    change = change_of(context, chosen)
    left = replace(context, base=context.base + change, _memo={})
    out = {}
    for effect in scanning:
        columns = [(v, columns_of(streams, v)) for v in effect.variants(left)]
        forms = [Candidate(effect, v, c, score(c)) for v, c in columns if c.width]
        if forms:
            out[effect.name] = forms
    return out


def change_of(context: Context, chosen: Fit) -> Floats:
    """What the chosen effects, fitted to all rows, change in the prediction, (F, K)."""
    change = np.zeros_like(context.base)
    for i, part in enumerate(chosen.parts):
        change += contribution(context, part.variant, coefficients(part.columns, part.variant, chosen.own(i)))
    return change


def _options(chosen: Fit | None, found: Mapping[str, list[Candidate]], leave: int | None = None) -> list[Fit]:
    parts = list(chosen.parts) if chosen else []
    if leave is not None:
        parts = parts[:leave] + parts[leave + 1 :]
    taken = {p.effect.name for p in parts}
    return [fit([*parts, c]) for name, forms in found.items() if name not in taken for c in forms]


def _best_addition(chosen: Fit | None, found: Mapping[str, list[Candidate]]) -> Fit | None:
    options = [f for f in _options(chosen, found) if _stays_plausible(f)]
    return max(options, key=lambda f: f.score.gain, default=None)


def _stays_plausible(joint: Fit) -> bool:
    """Whether each part's values stay within bounds when all are fitted together."""
    order = order_of([p.columns for p in joint.parts])
    for part, own in zip(joint.parts, order, strict=True):
        s = joint.score
        sub = Score(s.gains, s.beta[own], s.fold_beta[:, own], s.covariance[np.ix_(own, own)], s.ridge)
        if not plausible(part.effect, part.variant, part.columns, sub):
            return False
    return True


def _earns(streams: Streams, before: Fit | None, after: Fit, gate: Gate) -> bool:
    """Better than its standard error, and large enough beside what is explained already."""
    more = after.score.gains - (before.score.gains if before else 0.0)
    if more.sum() <= 0 or not clear(more, streams.base_squares):
        return False
    return _fall(streams, before, after) >= gate.smallest(0.0 if before is None else SMALLEST_SHARE)


def _fall(streams: Streams, before: Fit | None, after: Fit) -> float:
    """By how much the held-out mean square falls."""
    left = square_of(streams, streams.residual - (before.heldout if before else streams.nothing))
    return left - square_of(streams, streams.residual - after.heldout)


def _clear_locally(streams: Streams, before: Fit | None, after: Fit, gate: Gate) -> bool:
    """Whether single captures say so clearly, and it is large.

    Signs of m blocks can give no p-value below 2^(1 - m), so what happens in a few blocks only (a slip, a
    limit that is rarely reached) needs another way in: a fall that is larger than all that slow noise of
    half a floor could give, and clear by capture.
    """
    old = streams.residual - (before.heldout if before else streams.nothing)
    each = streams.square(old) - streams.square(streams.residual - after.heldout)
    gains = np.bincount(streams.source, weights=each)
    z = gains.sum() / max(np.sqrt(len(gains)) * gains.std(ddof=1), 1e-300) if len(gains) > 2 else 0.0
    return bool(z > LOCAL_Z and _fall(streams, before, after) > LOCAL_OF_FLOOR**2 * gate.floor_square)


def _simplest(chosen: Fit, found: Mapping[str, list[Candidate]]) -> Fit:
    """Where other effects do as well with fewer coefficients, the one with the fewest takes the place."""
    for i, part in enumerate(chosen.parts):
        rest = [p for j, p in enumerate(chosen.parts) if j != i]
        worth = chosen.score.gain - (fit(rest).score.gain if rest else 0.0)
        best = chosen
        for option in _options(chosen, found, leave=i):
            behind = chosen.score.gains - option.score.gains
            se = float(np.sqrt(len(behind)) * behind.std(ddof=1))
            tied = behind.sum() <= min(max(se, SAME_SHARE * worth), TIE_SHARE * worth)
            holder = part if best is chosen else best.parts[-1]
            simpler = 1.5 * option.parts[-1].freedom <= holder.freedom
            if (
                tied
                and simpler
                and option.parts[-1].effect.name != part.effect.name
                and _stays_plausible(option)
            ):
                best = option
        if best is not chosen:
            return best
    return chosen


def _p_of_addition(
    streams: Streams, chosen: Fit, found: Mapping[str, list[Candidate]], best: Fit, signs: Floats
) -> float:
    """How often the whole search would find as much in what `chosen` leaves, by flipped blocks."""
    left = replace(streams, residual=streams.residual - chosen.columns.field(chosen.score.beta))
    largest = np.zeros(len(signs))
    observed = 0.0
    for name, forms in found.items():
        for c in forms:
            columns = replace(c.columns, streams=left)
            scored = score(columns)
            largest = np.maximum(largest, null_gains(columns, signs, scored.ridge, streams.base_squares))
            if name == best.names[-1]:
                observed = max(observed, relative(scored.gains, streams.base_squares))
    return float((1 + (largest >= observed).sum()) / (1 + len(signs)))


def _swap(chosen: Fit, found: Mapping[str, list[Candidate]]) -> Fit:
    """Exchange one effect, or its form, for another as long as the joint score rises clearly."""
    for _ in range(4):
        better = chosen
        for i in range(len(chosen.parts)):
            for option in _options(chosen, found, leave=i):
                rises = option.score.gains - better.score.gains
                same = option.parts[-1].effect.name == chosen.parts[i].effect.name
                se = 0.0 if same else float(np.sqrt(len(rises)) * rises.std(ddof=1))
                if rises.sum() > se and _stays_plausible(option):
                    better = option
        if better is chosen:
            return chosen
        chosen = better
    return chosen


def _prune(streams: Streams, chosen: Fit, gate: Gate) -> Fit:
    """Drop what the others do as well without."""
    while len(chosen.parts) > 1:
        rest = [fit([p for j, p in enumerate(chosen.parts) if j != i]) for i in range(len(chosen.parts))]
        weakest = max(rest, key=lambda f: f.score.gain)
        if _earns(streams, weakest, chosen, gate):
            return chosen
        chosen = weakest
    return chosen
