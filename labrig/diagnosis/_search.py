"""Which effects earn a place: one added at a time, on the held-out score, then swapped and pruned.

Two grounds, in turn. What depends on history, on time in hold or in session is sought beside a smooth static
map of the pressures, so that a base of wrong form can neither hide it nor be taken for it. What is static is
then sought in what that leaves, and must explain most of what any static map could.
"""

from collections.abc import Mapping
from dataclasses import dataclass, replace

import numpy as np

from labrig.diagnosis._candidates import (
    Candidate,
    Fit,
    change_of,
    clear,
    draw_signs,
    explore,
    fit,
    lay_out,
    square_of,
    stays_plausible,
)
from labrig.diagnosis._ceiling import ceiling
from labrig.diagnosis._gate import (
    SIGNIFICANT,
    SMALLEST_OF_FLOOR,
    SMALLEST_SHARE,
    Gate,
    Ground,
    clear_locally,
    earns,
    everywhere,
    fall,
    p_of_addition,
    p_of_best,
    p_of_search,
    rules_the_hold,
    similarity,
)
from labrig.diagnosis._streams import Streams
from labrig.effects import Effect
from labrig.effects._rows import Floats

MAX_EFFECTS = 3
TIE_SHARE = 0.03
SAME_SHARE = 0.015
SAME_SHAPE = 0.95
SAME_OF_FLOOR = 0.1
SAME_SE = 1.5
SIMPLER = 3.0
GOOD_FORM = 0.97
SMALLEST_BESIDE = 0.2
STATIC_SHARE_FIRST = 0.3
STATIC_SHARE_NEXT = 0.6
STATIC = "pressure"


@dataclass(frozen=True)
class Search:
    """What the search found.

    `found` are the forms of every effect on the whole problem, for the ranking; `chosen` the effects that
    earned a place, `moving` the first of them that were chosen beside a static map, on their own ground.
    """

    found: dict[str, list[Candidate]]
    chosen: Fit | None
    moving: Fit | None
    moving_ground: Ground
    static_ground: Ground


def search(streams: Streams, effects: Mapping[str, Effect], gate: Gate) -> Search:
    """Explore all effects and select those that earn a place."""
    context = streams.context
    beside = streams.beside_static()
    own_ground = {n: e for n, e in effects.items() if beside is not None and _moves(e, streams)}
    others = {n: e for n, e in effects.items() if n not in own_ground}
    ground = beside if beside is not None else streams
    signs = draw_signs(streams.n_groups)
    found, null = explore(ground, context, own_ground, signs)
    base_square = square_of(ground, ground.residual - ground.nothing)
    own_gate = replace(gate, base_square=base_square, of_floor=SMALLEST_BESIDE)
    moving_ground = Ground(ground, own_ground, found, null, own_gate)
    moving = _forward(moving_ground, None, signs)

    standing = {name: own_ground[name] for name in found}
    whole, _ = explore(streams, context, standing, signs[:0])
    start = _large_enough(_on_whole(streams, moving, whole), moving_ground.gate) if moving else None
    if start is None:
        moving = None
    static_found, static_null = explore(streams, context, others, signs)
    static_ground = Ground(streams, others, static_found, static_null, gate)
    chosen = _forward(static_ground, start, signs)
    if moving is None:
        better = _better_moving(chosen, whole, moving_ground)
        if better is not None:
            moving, chosen = better[0], _forward(static_ground, better[1], signs)
    return Search({**whole, **static_found}, chosen, moving, moving_ground, static_ground)


def _better_moving(
    static: Fit | None, whole: Mapping[str, list[Candidate]], ground: Ground
) -> tuple[Fit, Fit] | None:
    """A moving effect that does clearly better on the whole problem than the static ones chosen there.

    One that is nearly static itself (a warm-up that is soon over) shows little beside a static map, but what
    it shows must still be clear. Returned on its own ground and on the whole problem.
    """
    if static is None:
        return None
    best = max((c for forms in whole.values() for c in forms), key=lambda c: c.score.gain, default=None)
    if best is None or _large_enough(fit([best]), ground.gate) is None:
        return None
    ahead = best.score.gains - static.score.gains
    alone = ground.found[best.effect.name][0]
    clearly = ahead.sum() > TIE_SHARE * static.score.gain and clear(ahead, ground.streams.base_squares)
    if not clearly or not clear(alone.score.gains, ground.streams.base_squares):
        return None
    return fit([alone]), fit([best])


def _moves(effect: Effect, streams: Streams) -> bool:
    """Whether an effect must show beside a static map on this campaign."""
    return effect.beyond_static == "always" or (
        effect.beyond_static == "if reversed" and streams.context.reverses
    )


def _on_whole(streams: Streams, moving: Fit, whole: Mapping[str, list[Candidate]]) -> Fit:
    """The same effects on the whole problem, in the forms that do best there together."""
    forms = [[*lay_out(streams, p.effect, [p.variant]), *whole.get(p.effect.name, ())] for p in moving.parts]
    chosen = fit([own[0] for own in forms])
    for _ in range(2):
        for i, own in enumerate(forms):
            options = [fit([*chosen.parts[:i], c, *chosen.parts[i + 1 :]]) for c in own]
            good = [f for f in options if stays_plausible(f)] or options
            top = max(f.score.gain for f in good)
            least = top - (1 - GOOD_FORM) * abs(top)
            chosen = min((f for f in good if f.score.gain >= least), key=_left)
    return chosen


def _left(chosen: Fit) -> float:
    """Held-out mean square that a fit leaves, in the units of the observables."""
    streams = chosen.columns.streams
    return square_of(streams, streams.residual - chosen.heldout)


def _large_enough(chosen: Fit, gate: Gate) -> Fit | None:
    """Leave out what, static part included, is too small to matter beside what a static map leaves."""
    gate = replace(gate, of_floor=SMALLEST_OF_FLOOR)
    kept = []
    for i, part in enumerate(chosen.parts):
        streams = part.columns.streams
        size = square_of(streams, part.columns.field(chosen.own(i)))
        if size >= gate.smallest(SMALLEST_SHARE) or (size >= gate.smallest(0.0) and rules_the_hold(part)):
            kept.append(part)
    return fit(kept) if kept else None


def _forward(ground: Ground, start: Fit | None, signs: Floats) -> Fit | None:
    """Forward selection on one ground; the parts of `start` stay, swap and prune touch only the others."""
    chosen = start
    fixed = len(start.parts) if start else 0
    found = dict(ground.found)
    while chosen is None or len(chosen.parts) < MAX_EFFECTS:
        if chosen is not None:
            found |= _look_again(ground.streams, chosen, found)
        best = _best_addition(chosen, found, fixed)
        if best is None or not earns(ground, chosen, best):
            break
        if chosen is not None:
            p = p_of_addition(ground.streams, chosen, found, best, signs)
        else:
            p = p_of_search(found, ground)
            p = p if p <= SIGNIFICANT else p_of_best(ground, best, signs)
        if p > SIGNIFICANT and not clear_locally(ground, chosen, best) and not everywhere(chosen, best):
            break
        if not _fits_form(ground.streams, chosen, best):
            break
        chosen = _simplest(ground, _swap(best, found, fixed), found, fixed)
    return None if chosen is None else _prune(ground, chosen, fixed)


def _fits_form(streams: Streams, before: Fit | None, after: Fit) -> bool:
    """Whether a static effect explains most of what any static map of the pressures could.

    If it does not, it is no more than a part of a base of wrong form, and its name would mislead.
    """
    if streams.as_features or after.parts[-1].effect.beyond_static != "no":
        return True
    left = streams.residual - (before.heldout if before else streams.nothing)
    learnt = ceiling(streams, streams.context, left, only=STATIC)
    if not learnt:
        return True
    possible = square_of(streams, left) - square_of(streams, left - learnt[STATIC].heldout)
    needed = STATIC_SHARE_FIRST if before is None else STATIC_SHARE_NEXT
    return fall(streams, before, after) >= needed * possible


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
        forms = lay_out(streams, effect, list(effect.variants(left)))
        if forms:
            out[effect.name] = forms
    return out


def _options(chosen: Fit | None, found: Mapping[str, list[Candidate]], leave: int | None = None) -> list[Fit]:
    parts = list(chosen.parts) if chosen else []
    if leave is not None:
        parts = parts[:leave] + parts[leave + 1 :]
    taken = {p.effect.name for p in parts}
    return [fit([*parts, c]) for name, forms in found.items() if name not in taken for c in forms]


def _best_addition(chosen: Fit | None, found: Mapping[str, list[Candidate]], fixed: int) -> Fit | None:
    """The best of all plausible additions; how far the `fixed` parts went had been settled on their own ground."""
    options = [f for f in _options(chosen, found) if stays_plausible(f, fixed)]
    return max(options, key=lambda f: f.score.gain, default=None)


def _simplest(ground: Ground, chosen: Fit, found: Mapping[str, list[Candidate]], fixed: int) -> Fit:
    """Where other effects do as well with fewer coefficients, the one with the fewest takes the place."""
    for i in range(fixed, len(chosen.parts)):
        part = chosen.parts[i]
        rest = [p for j, p in enumerate(chosen.parts) if j != i]
        worth = chosen.score.gain - (fit(rest).score.gain if rest else 0.0)
        best = chosen
        for option in _options(chosen, found, leave=i):
            behind = chosen.score.gains - option.score.gains
            se = float(np.sqrt(len(behind)) * behind.std(ddof=1))
            worse = _left(option) - _left(chosen)
            free = part.freedom >= ground.streams.residual.shape[1]
            same = worse <= SAME_OF_FLOOR * ground.gate.floor_square and behind.sum() <= SAME_SHARE * worth
            same = same and (free or behind.sum() <= SAME_SE * se)
            tied = behind.sum() <= se or (same and similarity(part, option.parts[-1]) > SAME_SHAPE)
            holder = part if best is chosen else best.parts[-1]
            simpler = SIMPLER * option.parts[-1].freedom <= holder.freedom
            if (
                tied
                and simpler
                and option.parts[-1].effect.name != part.effect.name
                and stays_plausible(option, fixed)
            ):
                best = option
        if best is not chosen:
            return best
    return chosen


def _swap(chosen: Fit, found: Mapping[str, list[Candidate]], fixed: int) -> Fit:
    """Exchange one effect, or its form, for another as long as the joint score rises clearly."""
    for _ in range(4):
        better = chosen
        for i in range(fixed, len(chosen.parts)):
            for option in _options(chosen, found, leave=i):
                rises = option.score.gains - better.score.gains
                same = option.parts[-1].effect.name == chosen.parts[i].effect.name
                se = 0.0 if same else float(np.sqrt(len(rises)) * rises.std(ddof=1))
                if rises.sum() > se and stays_plausible(option, fixed):
                    better = option
        if better is chosen:
            return chosen
        chosen = better
    return chosen


def _prune(ground: Ground, chosen: Fit, fixed: int) -> Fit:
    """Drop what the others do as well without; of the fixed parts only what has become nothing beside them."""
    while len(chosen.parts) > 1:
        rest = [fit([p for j, p in enumerate(chosen.parts) if j != i]) for i in range(len(chosen.parts))]
        lost = [fall(ground.streams, f, chosen) for f in rest[:fixed]]
        if (
            lost
            and min(lost) < ground.gate.smallest(0.0)
            and not rules_the_hold(chosen.parts[lost.index(min(lost))])
        ):
            chosen, fixed = rest[lost.index(min(lost))], fixed - 1
            continue
        weakest = max(rest[fixed:], key=lambda f: f.score.gain, default=None)
        if weakest is None or earns(ground, weakest, chosen):
            return chosen
        chosen = weakest
    return chosen
