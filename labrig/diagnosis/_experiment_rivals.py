"""The explanations that are still open, each with the forms in which the run allows it."""

from collections.abc import Mapping, Sequence
from dataclasses import dataclass, field, replace
from typing import Any

import numpy as np

from labrig._errors import LabrigError
from labrig.diagnosis._candidates import Candidate, Fit, explore, fit
from labrig.diagnosis._streams import Streams
from labrig.effects import Context, Effect, Rows, Term, Variant, join_rows
from labrig.effects._fields import frame_modes
from labrig.effects._rows import Floats

COMES_NEAR = 1.25
"""A runner-up's held-out error, as a multiple of the winner's, that is worth an experiment."""

FORMS = 4
MOST_OTHERS = 4
_NOT_PLANNED = {"as measured"}


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
    """One explanation: the names in it, its forms, best first, and how the run weighs them (sum 1)."""

    names: tuple[str, ...]
    forms: tuple[Form, ...]
    weight: Floats = field(repr=False)

    @property
    def title(self) -> str:
        """The names, joined."""
        return " + ".join(self.names)


def same_form(context: Context, effect: Effect, variant: Variant) -> Variant | None:
    """The same form of an effect with the same values of what is not linear in it, on another context."""
    for other in effect.variants(context.pin(variant.shape)):
        if other.form == variant.form and other.shape == variant.shape:
            return other
    return None


def open_rivals(
    streams: Streams, context: Context, effects: Mapping[str, Effect], summary: Mapping[str, Any]
) -> list[Rival]:
    """What the verdict leaves open, as explanations to tell apart.

    What was chosen, and the same with each rival in the place where it does best; where one effect was chosen,
    also any runner-up whose error alone comes near, for an experiment should not open a new doubt.
    """
    chosen = [str(n) for n in summary["effects"] if n in effects]
    others = [str(n) for n in summary["rivals"] if n in effects and n not in chosen]
    if len(chosen) == 1:
        others += [n for n in _near(summary, chosen, effects) if n not in others]
    others = others[:MOST_OTHERS]
    if not chosen or not others:
        return []
    wanted = {n: effects[n] for n in (*chosen, *others)}
    found, _ = explore(streams, context, wanted, np.zeros((0, streams.n_groups)))
    found = {n: [c for c in forms if c.variant.form not in _NOT_PLANNED] for n, forms in found.items()}
    if any(not found.get(n) for n in chosen):
        return []
    first = _best([found[n] for n in chosen])
    out = [_rival(first)]
    for name in others:
        if not found.get(name):
            continue
        options = [
            _best([*([c] for j, c in enumerate(first[0].parts) if j != i), found[name]])
            for i in range(len(chosen))
        ]
        out.append(_rival(max(options, key=lambda fits: fits[0].score.gain)))
    return out if len(out) > 1 else []


def _near(summary: Mapping[str, Any], chosen: Sequence[str], effects: Mapping[str, Effect]) -> list[str]:
    """Runners-up that come near the winner, by the ranking of effects alone."""
    errors = {str(r["effect"]): float(r["heldout_error"]) for r in summary["ranking"]}
    best = min((errors[n] for n in chosen if n in errors), default=None)
    if best is None:
        return []
    return [n for n, e in errors.items() if n not in chosen and n in effects and e <= COMES_NEAR * best][:3]


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


def _rival(fits: Sequence[Fit]) -> Rival:
    """Weigh the forms by how far their held-out gains are apart, in standard errors."""
    best = fits[0].score.gains
    behind = []
    for each in fits:
        gap = best - each.score.gains
        n = len(gap)
        se = float(np.sqrt(n) * gap.std(ddof=1)) if n > 1 else 1.0
        behind.append(max(float(gap.sum()), 0.0) / max(se, 1e-9 * abs(best.sum()), 1e-300))
    weight = np.exp(-np.minimum(np.array(behind), 50.0))
    return Rival(fits[0].names, tuple(Form(f.parts) for f in fits), weight / weight.sum())


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
    return replace(run, rows=rows, inside=inside, _memo={}, **both)


def _as_the_run(planned: Rows, run: Rows) -> Rows:
    if planned.chambers != run.chambers:
        raise LabrigError("the programme's chambers are not those of the run")
    return planned


def _between(rows: Rows) -> str:
    return rows.between_sessions if rows.between_sessions == "held" else "released"


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
