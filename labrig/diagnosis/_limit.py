"""A limit beside a law of the chambers' own pressures.

A curve for every chamber can follow a law and a limit together, and what the limit adds to it looks like a misfit of
form. But a limit that is met is met hard: beyond it a chamber loses much of its motion, while the kinks that a misfit
asks for lose some hundredths. So an effect whose parameter is at least so large wherever it acts may come in beside a
law, or with another law in the place of the one that followed both, however little more the two explain.
"""

from dataclasses import replace

import numpy as np

from labrig.diagnosis._candidates import Candidate, Fit, Forms, acting, clearly, fit, lay_out, stays_plausible
from labrig.diagnosis._columns import order_of
from labrig.diagnosis._exchange import SIMPLER
from labrig.diagnosis._gate import MAX_EFFECTS, Ground
from labrig.diagnosis._score import score

LEAST_SHARE = 0.008
CLEARLY_SE = 2.0
BETTER_BLOCKS = 0.66
LAWS = 3
LIMITS = 5


def limit_beside(ground: Ground, chosen: Fit, found: Forms, fixed: int) -> Fit:
    """The best law and limit in the place of the laws after the `fixed` parts, if any earn it."""
    kept, laws = list(chosen.parts[:fixed]), list(chosen.parts[fixed:])
    taken = {part.effect.name for part in kept}
    if not laws or len(kept) + 2 > MAX_EFFECTS or not all(is_law(part) for part in laws):
        return chosen
    for name, forms in found.items():
        if name not in taken and is_law(forms[0]):
            laws += [*forms[:LAWS], min(forms, key=lambda c: c.freedom)]
    limits = [
        limit
        for name, effect in ground.effects.items()
        if name not in taken and any(parameter.least > 0 for parameter in effect.parameters)
        for limit in lay_out(ground.streams, effect, list(effect.variants(ground.streams.context)))
    ]
    best = chosen
    for one in laws:
        for limit in _best_in_rest(fit([*kept, one]), limits):
            option = fit([*kept, one, limit])
            if option.score.gain > best.score.gain and _earns(ground, chosen, option, fixed):
                best = option
    return best


def _best_in_rest(before: Fit, limits: list[Candidate]) -> list[Candidate]:
    """The few that do best in what `before` leaves; another effect than its law."""
    streams = before.columns.streams
    left = replace(streams, residual=streams.residual - before.columns.field(before.score.beta))
    others = [limit for limit in limits if limit.effect.name != before.names[-1]]
    return sorted(others, key=lambda c: -score(replace(c.columns, streams=left)).gain)[:LIMITS]


def is_law(part: Candidate) -> bool:
    """Whether a part is a law of each chamber's own pressure, whatever came before."""
    effect = part.effect
    return effect.shows_in == "own pressure" and effect.beyond_static == "no" and not effect.scans


def stands(before: Fit, after: Fit) -> bool:
    """Whether `after` has a hard limit more than `before`, clearly, and it explains more than some thousandths.

    The other way round a law may be no more than what a limit's own form misses: it has to earn its place as any does.
    """
    more = after.score.gains - before.score.gains
    streams = after.columns.streams
    hard = any(
        is_hard(after, i) for i, part in enumerate(after.parts) if part.effect.name not in before.names
    )
    large = more.sum() >= LEAST_SHARE * after.score.gain
    return (
        hard
        and large
        and clearly(more, streams.base_squares, CLEARLY_SE)
        and bool((more > 0).mean() >= BETTER_BLOCKS)
    )


def _earns(ground: Ground, chosen: Fit, option: Fit, fixed: int) -> bool:
    """Whether the two are clearly ahead, or no worse with far fewer coefficients, and the limit is hard."""
    ahead = option.score.gains - chosen.score.gains
    kept = fit(chosen.parts[:fixed]).score.gain if fixed else 0.0
    n = len(ahead)
    se = float(np.sqrt(n) * ahead.std(ddof=1))
    clear = clearly(ahead, ground.streams.base_squares, CLEARLY_SE) and (ahead > 0).mean() >= BETTER_BLOCKS
    clear = clear and ahead.sum() > LEAST_SHARE * (chosen.score.gain - kept)
    freedom = [sum(part.freedom for part in one.parts[fixed:]) for one in (option, chosen)]
    simpler = SIMPLER * freedom[0] <= freedom[1] and ahead.sum() > -se
    return (clear or simpler) and is_hard(option, fixed + 1) and stays_plausible(option, fixed)


def is_hard(chosen: Fit, i: int) -> bool:
    """Whether the i-th part is as large, where it acts, as it is at least wherever it acts at all."""
    part = chosen.parts[i]
    if len(part.variant.terms) != 1:
        return False
    least = part.effect.parameter(part.variant.terms[0].parameter).least
    own = order_of([part.columns for part in chosen.parts])[i]
    return least > 0 and float(acting(chosen.columns, chosen.score.beta, own) @ chosen.own(i)) >= least
