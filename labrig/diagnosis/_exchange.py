"""Exchanges among effects that have come in: for another name, another form, or a simpler one that does as well."""

from dataclasses import replace

import numpy as np

from labrig.diagnosis._candidates import Fit, Forms, draw_signs, explore, fit, lay_out, stays_plausible
from labrig.diagnosis._gate import Ground, similarity
from labrig.diagnosis._moving import left_by

SAME_SHARE = 0.015
SAME_SHAPE = 0.95
SAME_FIELD = 0.99
SAME_OF_FLOOR = 0.1
SAME_SE = 1.5
SIMPLER = 3.0
MUCH_SIMPLER = 8.0
NATURAL_SE = 1.5


def options_of(chosen: Fit | None, found: Forms, leave: int | None = None) -> list[Fit]:
    parts = list(chosen.parts) if chosen else []
    if leave is not None:
        parts = parts[:leave] + parts[leave + 1 :]
    taken = {p.effect.name for p in parts}
    return [fit([*parts, c]) for name, forms in found.items() if name not in taken for c in forms]


def other_forms(
    chosen: Fit,
    found: Forms,
    fixed: int,
    forms: Forms,
    leave: int | None = None,
) -> list[Fit]:
    """`options_of` where a fixed part takes another of its `forms`.

    For an addition (nothing is to `leave`) only forms that do worse without it: the fixed part had stood for what is
    now added. One that does better by itself would lend the addition its own gain.
    """
    best_forms = {name: own[:1] for name, own in found.items()}
    out = []
    for i, part in enumerate(chosen.parts[:fixed]):
        for form in forms.get(part.effect.name, ()):
            changed = fit([*chosen.parts[:i], form, *chosen.parts[i + 1 :]])
            if leave is not None or changed.score.gain < chosen.score.gain:
                out += options_of(changed, best_forms, leave)
    return out


def swap(chosen: Fit, found: Forms, fixed: int, only: int | None = None) -> Fit:
    """Exchange one effect (`only` the one of that number), or its form, as long as the joint score rises clearly."""
    for _ in range(4 if only is None else 1):
        better = chosen
        for i in range(fixed, len(chosen.parts)) if only is None else (only,):
            for option in options_of(chosen, found, leave=i):
                rises = option.score.gains - better.score.gains
                same = option.parts[-1].effect.name == chosen.parts[i].effect.name
                se = 0.0 if same else float(np.sqrt(len(rises)) * rises.std(ddof=1))
                if rises.sum() > se and stays_plausible(option, fixed):
                    better = option
        if better is chosen:
            return chosen
        chosen = better
    return chosen


def simplest(ground: Ground, chosen: Fit, found: Forms, fixed: int, forms: Forms) -> Fit:
    """Where other effects do as well with fewer coefficients, the one with the fewest takes the place."""
    for i in range(fixed, len(chosen.parts)):
        part = chosen.parts[i]
        rest = [p for j, p in enumerate(chosen.parts) if j != i]
        worth = chosen.score.gain - (fit(rest).score.gain if rest else 0.0)
        best = chosen
        others = other_forms(chosen, found, fixed, forms, leave=i)
        for option in [*options_of(chosen, found, leave=i), *others]:
            new, holder = option.parts[-1], part if best is chosen else best.parts[-1]
            if new.effect.name == part.effect.name or SIMPLER * new.freedom > holder.freedom:
                continue
            if _ties(ground, chosen, i, option, worth) and stays_plausible(option, fixed):
                best = option
        if best is not chosen:
            return best
    return chosen


def _ties(ground: Ground, chosen: Fit, i: int, option: Fit, worth: float) -> bool:
    """Whether the last part of `option` does as well as the i-th of `chosen`, which is `worth` so much gain there."""
    behind = chosen.score.gains - option.score.gains
    se = float(np.sqrt(len(behind)) * behind.std(ddof=1))
    if behind.sum() <= se:
        return True
    much_simpler = MUCH_SIMPLER * option.parts[-1].freedom
    free = chosen.parts[i].freedom >= min(ground.streams.residual.shape[1], much_simpler)
    like = similarity(chosen, i, option)
    # beside another the worth of each is small, and so is a share of it; the same field is the same
    if free and like > SAME_FIELD and behind.sum() <= SAME_SHARE * chosen.score.gain:
        return True
    if like <= SAME_SHAPE or behind.sum() > SAME_SHARE * worth or not (free or behind.sum() <= SAME_SE * se):
        return False
    return left_by(option) - left_by(chosen) <= SAME_OF_FLOOR * ground.gate.floor_square


def reform(chosen: Fit, forms: Forms, fixed: int) -> Fit:
    """The same effects, the fixed ones in the forms that do clearly best beside the others."""
    for i in range(fixed if len(chosen.parts) > fixed else 0):
        for form in forms.get(chosen.parts[i].effect.name, ()):
            option = fit([*chosen.parts[:i], form, *chosen.parts[i + 1 :]])
            rises = option.score.gains - chosen.score.gains
            if rises.sum() > np.sqrt(len(rises)) * rises.std(ddof=1) and stays_plausible(option):
                chosen = option
    return chosen


def in_best_forms(ground: Ground, chosen: Fit, fixed: int) -> Fit:
    """One exchange more, for any form of any effect: those kept did best alone, and another stands beside them now."""
    streams, best = ground.streams, chosen
    for i in range(fixed, len(chosen.parts)) if len(chosen.parts) > 1 else ():
        rest = fit([p for j, p in enumerate(chosen.parts) if j != i])
        left = replace(streams, residual=streams.residual - rest.columns.field(rest.score.beta))
        again, _ = explore(left, streams.context, ground.effects, draw_signs(streams.n_groups, draws=0))
        kept = [(forms[0].effect, [c.variant for c in forms]) for forms in again.values()]
        found = {effect.name: lay_out(streams, effect, variants) for effect, variants in kept}
        best = max(best, swap(chosen, found, fixed, only=i), key=lambda f: f.score.gain)
    return best


def natural(chosen: Fit, found: Forms, fixed: int) -> Fit:
    """Where two tie, the one that is of one piece: what lives in each chamber by itself is seldom alike in all."""
    for i in range(fixed, len(chosen.parts)):
        if not chosen.parts[i].alike_in_all:
            continue
        for option in options_of(chosen, found, leave=i):
            behind = chosen.score.gains - option.score.gains
            se = float(np.sqrt(len(behind)) * behind.std(ddof=1))
            near = behind.sum() <= min(NATURAL_SE * se, SAME_SHARE * chosen.score.gain)
            other = option.parts[-1]
            if not near or other.alike_in_all or other.freedom > chosen.parts[i].freedom:
                continue
            if similarity(chosen, i, option) > SAME_SHAPE and stays_plausible(option, fixed):
                return option
    return chosen
