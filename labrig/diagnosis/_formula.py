"""The formula after the name: the plainest forms of the named effects that fit well enough, fitted together."""

from collections.abc import Callable, Mapping, Sequence
from functools import partial
from typing import TypeVar

import numpy as np

from labrig._errors import LabrigError
from labrig.diagnosis._candidates import Candidate, Fit, error_of, fit, plausible, quoted
from labrig.diagnosis._design_matrix import columns_of
from labrig.diagnosis._parameters import off_grid, refined
from labrig.diagnosis._regression import Regression
from labrig.diagnosis._score import score, standard_error
from labrig.diagnosis._weights import family_forms
from labrig.effects import Context, Effect, forms_on, is_family, may_act, only_where

_Fitted = TypeVar("_Fitted", Candidate, Fit)

_ROUNDS = 2
"""How often each effect's form is looked for again beside the others; numerical."""
_KEPT = 12
"""Forms of each effect, the best ones, that are tried beside the others; numerical."""
_GOOD_ENOUGH = 0.07
"""A plainer form is good enough if it errs more than the best by no more than this share of the best's held-out error,
and of what the best takes off the error; or only by chance."""
_QUOTED = 0.25
"""And the error that is quoted may be larger by no more than this: the score forgives a share of what is explained."""


def fit_named(
    regression: Regression,
    context: Context,
    effects: Sequence[Effect],
    *,
    forms: Callable[[Effect], list[Candidate]] | None = None,
    start: Mapping[str, Candidate] | None = None,
) -> Fit:
    """Forms of these effects, found in turn and then moved off the grid together.

    `forms` gives those of an effect where they are known already. With a `start` (forms by effect) these stay as they
    are, only those of the other effects are looked for, and none is moved: quick, and nearly the same.

    Raises `LabrigError` when one of them has no form that can act on this run.
    """
    known = forms or partial(forms_of, regression, context)
    forms_of_each = [known(effect)[:_KEPT] for effect in effects]
    for effect, own in zip(effects, forms_of_each, strict=True):
        if not own:
            raise LabrigError(
                f"effect {effect.name!r} can't act on this run; see: labrig effects show {effect.name}"
            )
    if start is not None:
        own_of = zip(effects, forms_of_each, strict=True)
        forms_of_each = [[start[e.name]] if e.name in start else own for e, own in own_of]
    chosen = fit([f[0] for f in forms_of_each])
    rounds = 0 if len(effects) == 1 else _ROUNDS if start is None else 1
    for each in range(rounds + 1 if rounds else 0):
        best = chosen
        for i, own in enumerate(forms_of_each):
            if len(own) > 1:
                options = [fit([*chosen.parts[:i], c, *chosen.parts[i + 1 :]]) for c in own]
                last = each == rounds
                chosen = _plainest(options, own, best) if last else max(options, key=_gain)
    for i, effect in enumerate(effects):
        if start is None and not effect.scans:
            chosen = refined(regression, context, chosen, i)
    return chosen


def forms_of(regression: Regression, context: Context, effect: Effect) -> list[Candidate]:
    """The forms of one effect, best first: the plainest that is good enough, then by what they explain of left-out
    blocks; those within their physical bounds before the others. The plainest, and the best of those that are plainer
    than a family or a chain, are moved off the search's grid first: these fill the gaps of a grid that one lag falls
    into.
    """
    found = []
    if not may_act(context.rows, effect.name).any():
        return []
    for variant in (
        *forms_on(effect, context),
        *only_where(context.rows, effect.name, family_forms(effect, context)),
    ):
        columns = columns_of(regression, variant)
        if columns.width:
            scored = score(columns)
            candidate = Candidate(effect, variant, columns, scored)
            found.append((plausible(effect, variant, columns, scored), candidate))
    found.sort(key=lambda f: (not f[0], -f[1].score.gain))
    formula = next((c for _, c in found if not is_family(c.variant.form)), None)
    if formula is not None:  # a family has to be better by what is quoted, too
        least = min(_quoted(formula), error_of(regression, regression.base_left))
        found = [f for f in found if not is_family(f[1].variant.form) or _quoted(f[1]) < least]
    if not found:
        return []
    bounded, best = found[0]
    forms = [c for _, c in found]
    alike = [c for ok, c in found if ok == bounded]
    plain = _plainest(alike, alike, best)
    any_width = is_family(plain.variant.form)
    formulas = [c for c in alike if not is_family(c.variant.form)]
    narrower = [c for c in formulas if any_width or c.columns.width < plain.columns.width]
    if narrower:  # off the search's grid a plainer one may be good enough
        plainest, likeliest = min(narrower, key=lambda c: c.columns.width), narrower[0]
        for one in [plainest] if plainest is likeliest else [plainest, likeliest]:
            moved = off_grid(one)
            if good_enough(moved, best):
                return [moved, *forms]
    return [plain, *(c for c in forms if c is not plain)]


def _plainest(options: Sequence[_Fitted], own: Sequence[Candidate], best: _Fitted) -> _Fitted:
    """The narrowest of those that are good enough beside `best`, of equally narrow ones the best.

    `own` are the forms in which the options differ. A family's weights say less than any formula, however few they are:
    they come last, and of several families the best.
    """
    pairs = list(zip(options, own, strict=True))
    formulas = [one for one, form in pairs if not is_family(form.variant.form)]
    families = [one for one, form in pairs if is_family(form.variant.form)]
    plain = sorted(formulas, key=lambda f: (f.columns.width, -f.score.gain))
    for one in (*plain, *sorted(families, key=_gain, reverse=True)):
        if one is best or good_enough(one, best):
            return one
    return best


def _gain(one: Candidate | Fit) -> float:
    return one.score.gain


def good_enough(plain: Candidate | Fit, best: Candidate | Fit) -> bool:
    """Whether a fit errs hardly more than the best one, or no more than by chance: by one standard error.

    The rule of L. Breiman et al., Classification and Regression Trees, 1984, here from the blocks' differences.
    """
    total = float(best.columns.regression.base_squares.sum())
    lost = best.score.gains - plain.score.gains
    chance = standard_error(lost) if len(lost) > 1 else 0.0
    base, least, error = np.sqrt(np.maximum([total, total - best.score.gain, total - plain.score.gain], 0))
    hardly = error - least <= _GOOD_ENOUGH * min(least, max(base - least, 0.0))
    return bool(hardly or lost.sum() <= chance) and _quoted(plain) <= (1 + _QUOTED) * _quoted(best)


def _quoted(chosen: Candidate | Fit) -> float:
    """The held-out error as it is quoted."""
    return quoted(chosen if isinstance(chosen, Fit) else chosen.alone)
