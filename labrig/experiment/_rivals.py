"""The explanations that are still open, each with the forms in which the run allows it."""

from collections.abc import Mapping, Sequence
from dataclasses import dataclass, field, replace

import numpy as np

from labrig._errors import LabrigError
from labrig.arrays import Floats
from labrig.contents import Summary
from labrig.diagnosis import Candidate, Fit, Regression, fit, forms_of
from labrig.effects import Context, Effect, Rows, Term, Variant, frame_modes, is_family, join_rows

FORMS = 4
MOST_OTHERS = 4
LEAST_LIKELY = 0.1
"""What an explanation that is open counts for at least: as much as is called possible."""

NEXT_TO_IT = 0.01
"""Probability from which an effect that is not possible is told apart from the only one that is sure or possible."""

_NOT_PLANNED = {"as measured", "spectrum"}
"""Forms that wait for other data, or follow so much that they say little of what to expect; families too."""


def _planned(form: str) -> bool:
    return form not in _NOT_PLANNED and not is_family(form)


@dataclass(frozen=True)
class Form:
    """One form of one explanation: the parts that act together."""

    parts: tuple[Candidate, ...]

    def features(self, context: Context) -> list[Term] | None:
        """The terms of all parts on another context; None where one of them can't act there."""
        out: list[Term] = []
        for part in self.parts:
            variant = same_form(context, part.effect, part.variant)
            if variant is None:
                return None
            out += variant.terms
        return out


@dataclass(frozen=True)
class Rival:
    """One explanation: the names in it, its forms, best first, how the run weighs them (sum 1), its probability."""

    names: tuple[str, ...]
    forms: tuple[Form, ...]
    weight: Floats = field(repr=False)
    probability: float = 1.0

    @property
    def title(self) -> str:
        """The names, joined."""
        return " + ".join(self.names) or "no effect"


def same_form(context: Context, effect: Effect, variant: Variant) -> Variant | None:
    """The same form of an effect with the same values of what is not linear in it, on another context."""
    for other in effect.variants(context.pin(variant.shape)):
        if other.form == variant.form and other.shape == variant.shape:
            return other
    return None


def open_rivals(
    regression: Regression, context: Context, effects: Mapping[str, Effect], summary: Summary
) -> list[Rival]:
    """What a diagnosis leaves open, as explanations to tell apart; an empty list where nothing is open."""
    sets = _open_sets(effects, summary)
    found = {
        n: [c for c in forms_of(regression, context, effects[n]) if _planned(c.variant.form)][:FORMS]
        for n in {name for names, _ in sets for name in names}
    }
    able = [(names, p) for names, p in sets if all(found[n] for n in names)]
    total = sum(p for _, p in able)
    return [_rival([found[n] for n in names], p / total) for names, p in able] if len(able) > 1 else []


def _open_sets(effects: Mapping[str, Effect], summary: Summary) -> list[tuple[tuple[str, ...], float]]:
    """Sets of effects, each with its probability: what is sure alone, and with each one that is possible beside it.

    Where there is only one name, sure or possible, the likeliest other one in its place; a name that is only possible
    has at least no effect at all against it.
    """
    sure = tuple(str(n) for n in summary["effects"] if n in effects)
    considered = {str(c["effect"]): c for c in summary.get("effects_considered") or ()}
    chance = {n: float(c["probability"]) for n, c in considered.items() if n in effects}
    names = [str(n) for n in summary["rivals"]] or [n for n in chance if considered[n]["call"] == "possible"]
    possible = {n: chance.get(n, 1.0 / len(names)) for n in names if n in effects and n not in sure}
    likeliest = sorted(possible, key=lambda n: -possible[n])[:MOST_OTHERS]
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


def _best(options: Sequence[Sequence[Candidate]]) -> list[Fit]:
    """The joint fits of one form of each effect that do best, at most `FORMS` of them, best first.

    Forms are exchanged one place at a time, starting from the best of each.
    """
    start = fit([forms[0] for forms in options])
    tried = {tuple(p.variant.key for p in start.parts): start}
    for i, forms in enumerate(options):
        for form in forms:
            parts = [*start.parts[:i], form, *start.parts[i + 1 :]]
            key = tuple(p.variant.key for p in parts)
            if key not in tried:
                tried[key] = fit(parts)
    return sorted(tried.values(), key=lambda f: -f.score.gain)[:FORMS]


def _rival(options: Sequence[Sequence[Candidate]], probability: float) -> Rival:
    """Weigh the forms by how far their held-out gains are apart, in standard errors."""
    if not options:
        return Rival((), (Form(()),), np.ones(1), probability)
    fits = _best(options)
    best = fits[0].score.gains
    behind = []
    for each in fits:
        gap = best - each.score.gains
        n = len(gap)
        se = float(np.sqrt(n) * gap.std(ddof=1)) if n > 1 else 1.0
        behind.append(max(float(gap.sum()), 0.0) / max(se, 1e-9 * abs(best.sum()), 1e-300))
    weight = np.exp(-np.minimum(np.array(behind), 50.0))
    return Rival(fits[0].names, tuple(Form(f.parts) for f in fits), weight / weight.sum(), probability)


def join_contexts(run: Context, planned: Context) -> Context:
    """The run and what is planned as one campaign, as a diagnosis of both together will see them."""
    rows = join_rows([run.rows, _as_the_run(planned.rows, run.rows)])
    rows = replace(rows, between_sessions=_between(run.rows))
    both = {
        name: np.concatenate([getattr(run, name), getattr(planned, name)])
        for name in ("base", "jacobian", "deflection", "event_deflection", "deflection_slope")
    }
    inside = {
        name: np.concatenate([change, planned.inside[name]])
        for name, change in run.inside.items()
        if name in planned.inside
    }
    displaced = np.concatenate([run.displacement, planned.displacement])
    return replace(run, rows=rows, inside=inside, displaced=displaced, _memo={}, **both)


def _as_the_run(planned: Rows, run: Rows) -> Rows:
    if planned.chambers != run.chambers:
        raise LabrigError("the programme's chambers are not those of the run")
    return planned


def _between(rows: Rows) -> str:
    return rows.between_sessions if rows.between_sessions == "held" else "vented"


def fields_of_terms(context: Context, terms: Sequence[Term], patterns: Floats, rows: slice) -> Floats:
    """What one unit of each coefficient changes in the observables, for some rows, (F, K, q)."""
    jacobian = context.jacobian[rows]
    F, K = jacobian.shape[:2]
    out: list[Floats] = []
    for term in terms:
        feature = term.feature[rows]
        if term.kind == "pressure":
            out.append(np.einsum("fkc,fcq->fkq", jacobian, feature, optimize=True))
        elif term.kind == "pattern":
            each = feature[:, None, :, None] * patterns.T[None, :, None, :]
            out.append(each.reshape(F, K, -1))
        elif term.kind == "frame":
            out.append(frame_modes(context)[rows] * feature[:, None, None])
        else:
            out.append(feature)
    return np.concatenate(out, axis=2)
