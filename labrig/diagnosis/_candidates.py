"""Candidates: the forms that effects take, laid out and scored; and several of them fitted together."""

from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from functools import cached_property

import numpy as np

from labrig.diagnosis._columns import Columns, coefficients, columns_of, join, order_of
from labrig.diagnosis._score import Score, null_gains, score
from labrig.diagnosis._streams import Streams
from labrig.effects import Context, Effect, Term, Variant
from labrig.effects._fields import contribution, term_width
from labrig.effects._rows import Floats, Ints

BEST_FORMS = 4
KEPT_FORMS = 4
DRAWS = 299
CLEAR_SE = 1.0


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

    @property
    def alike_in_all(self) -> bool:
        """Whether what lives in each chamber by itself is taken as the same in several."""
        return any(
            term.kind == "pressure"
            and term.feature.shape[2] == 1
            and self.effect.parameter(term.parameter).per == "chamber"
            and np.abs(term.feature).any(axis=(0, 2)).sum() > 1
            for term in self.variant.terms
        )


Forms = Mapping[str, list[Candidate]]
"""The forms of some effects, best first, by the effect's name."""


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

    Returns the best few plausible forms of each effect and its narrowest, best first, and the largest relative
    gain that the whole search would have found in each draw of the null, (B,).
    """
    found: dict[str, list[Candidate]] = {}
    largest = np.zeros(len(signs))
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
        if kept:
            found[name] = _best_forms(kept)
    return found, largest


def _best_forms(scored: list[Candidate]) -> list[Candidate]:
    """The best few, the best of each of the few best kinds of form, and the narrowest; best first."""
    scored = sorted(scored, key=lambda c: -c.score.gain)
    of_kind: dict[str, Candidate] = {}
    for candidate in scored:
        of_kind.setdefault(candidate.variant.form, candidate)
    kept = [*scored[:BEST_FORMS], *list(of_kind.values())[:KEPT_FORMS], min(scored, key=lambda c: c.freedom)]
    return [c for c in scored if any(c is other for other in kept)]


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
        if parameter.least > 0 and not _as_large(columns, scored, own, parameter.least):
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


def _as_large(columns: Columns, scored: Score, own: slice, least: float) -> bool:
    """Whether the values, where they act, are at least so large, or within two standard errors of it."""
    weight = acting(columns, scored.beta, own)
    each = scored.fold_beta[:, own] @ weight
    n = len(each)
    sd = float(np.sqrt((n - 1) / n * np.sum((each - each.mean()) ** 2)))
    return float(scored.beta[own] @ weight) >= least - 2 * sd


def acting(columns: Columns, beta: Floats, own: slice | Ints) -> Floats:
    """Weights that sum to one: how much each of the `own` columns, times its coefficient, changes the observables."""
    weight = np.diag(columns.sums[0].sum(axis=0))[own] * beta[own] ** 2
    return weight / max(float(weight.sum()), 1e-300)


def _along(columns: Columns, beta: Floats, term: Term) -> bool:
    """Whether a free pattern points the way in which the base itself moves, chamber by chamber."""
    streams = columns.streams
    pattern = beta.reshape(-1, streams.n_patterns) @ streams.patterns
    reach = streams.context.jacobian.mean(axis=0).T
    if len(pattern) != len(reach) or not np.abs(reach).any():
        return True
    return bool((pattern * reach / streams.floor.row**2).sum() > 0)


def clear(gains: Floats, base: Floats) -> bool:
    """Whether gains are more than their standard error, as they are or each as a share of its block's square."""
    return clearly(gains, base, CLEAR_SE)


def clearly(gains: Floats, base: Floats, least: float) -> bool:
    """Whether gains are more than `least` standard errors, as they are or each as a share of its block's `base`."""
    n = len(gains)
    return any(
        each.sum() > least * np.sqrt(n / max(n - 1, 1) * np.sum((each - each.mean()) ** 2))
        for each in (gains, gains / np.maximum(base, 1e-300))
    )


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


def square_of(streams: Streams, left: Floats) -> float:
    """Mean square of what is left over the observables that errors are quoted for."""
    return float(np.nanmean(mean_square(streams, left)[streams.counted]))


def change_of(context: Context, chosen: Fit) -> Floats:
    """What the chosen effects, fitted to all rows, change in the prediction, (F, K)."""
    change = np.zeros_like(context.base)
    for i, part in enumerate(chosen.parts):
        change += contribution(context, part.variant, coefficients(part.columns, part.variant, chosen.own(i)))
    return change


def stays_plausible(joint: Fit, first: int = 0) -> bool:
    """Whether each part's values, from the part `first` on, stay within bounds when all are fitted together."""
    for i, part in list(enumerate(joint.parts))[first:]:
        own = order_of([p.columns for p in joint.parts])[i]
        s = joint.score
        sub = Score(s.gains, s.beta[own], s.fold_beta[:, own], s.covariance[np.ix_(own, own)], s.ridge)
        if not plausible(part.effect, part.variant, part.columns, sub):
            return False
    return True


def lay_out(streams: Streams, effect: Effect, variants: Sequence[Variant]) -> list[Candidate]:
    """Forms laid out on other streams, and scored there, best first."""
    made = []
    for variant in variants:
        columns = columns_of(streams, variant)
        if columns.width:
            made.append(Candidate(effect, variant, columns, score(columns)))
    return sorted(made, key=lambda c: -c.score.gain)
