"""Which effects earn a place: one added at a time, on the held-out score, then swapped and pruned.

Two grounds, in turn. What depends on history, on time in hold or in session is sought beside a smooth static
map of the pressures, so that a base of wrong form can neither hide it nor be taken for it. What is static is
then sought in what that leaves, and must explain most of what any static map could.
"""

from collections.abc import Mapping
from dataclasses import dataclass, replace

from labrig.diagnosis._base_form import (
    as_good,
    beside_form,
    is_nearly_all,
    is_wrong,
    large_beside,
    on,
    share_needed,
)
from labrig.diagnosis._candidates import (
    Candidate,
    Fit,
    Forms,
    change_of,
    draw_signs,
    explore,
    fit,
    lay_out,
    square_of,
    stays_plausible,
)
from labrig.diagnosis._exchange import in_best_forms, natural, options_of, other_forms, reform, simplest, swap
from labrig.diagnosis._gate import (
    MAX_EFFECTS,
    SIGNIFICANT,
    Gate,
    Ground,
    clear_locally,
    earns,
    everywhere,
    fall,
    fits_form,
    p_of_addition,
    p_of_best,
    p_of_search,
    rules_the_hold,
)
from labrig.diagnosis._limit import limit_beside, stands
from labrig.diagnosis._moving import better_moving, large_enough, moves, on_whole
from labrig.diagnosis._streams import Streams
from labrig.diagnosis._together import with_named
from labrig.diagnosis._two_kinds import two_kinds
from labrig.effects import Effect
from labrig.effects._rows import Floats

SMALLEST_BESIDE = 0.2


@dataclass(frozen=True)
class Search:
    """What the search found.

    `found` are the forms of every effect on the whole problem, for the ranking; `chosen` the effects that
    earned a place, `moving` the first of them that were chosen beside a static map, on their own ground. `judged` are
    the chosen on `static_ground`: another than the whole problem where the base is `wrong_form`, which is then the
    base's own to explain; several laws `could_be` that error of form, where they tie.
    """

    found: dict[str, list[Candidate]]
    chosen: Fit | None
    moving: Fit | None
    moving_ground: Ground
    static_ground: Ground
    judged: Fit | None
    wrong_form: bool = False
    could_be: tuple[str, ...] = ()

    @property
    def left(self) -> Floats:
        """What the judged effects, and the base's own form, leave out of sample, (S, K)."""
        streams = self.static_ground.streams
        return streams.residual - (self.judged.heldout if self.judged else streams.nothing)


def search(streams: Streams, effects: Mapping[str, Effect], gate: Gate) -> Search:
    """Explore all effects and select those that earn a place."""
    context = streams.context
    beside = streams.beside_static()
    own_ground = {n: e for n, e in effects.items() if beside is not None and moves(e, streams)}
    others = {n: e for n, e in effects.items() if n not in own_ground}
    ground = beside if beside is not None else streams
    signs = draw_signs(streams.n_groups)
    found, null = explore(ground, context, own_ground, signs)
    base_square = square_of(ground, ground.residual - ground.nothing)
    own_gate = replace(gate, base_square=base_square, of_floor=SMALLEST_BESIDE)
    moving_ground = Ground(ground, own_ground, found, null, own_gate)
    moving = _forward(moving_ground, None, signs, {})

    standing = {name: own_ground[name] for name in found}
    whole, _ = explore(streams, context, standing, signs[:0])
    start = large_enough(on_whole(streams, moving, whole), moving_ground.gate) if moving else None
    if start is None:
        moving = None
    forms = _forms_of(streams, moving, found, whole)
    static_found, static_null = explore(streams, context, others, signs)
    static_ground = Ground(streams, others, static_found, static_null, gate)
    chosen = _forward(static_ground, start, signs, forms)
    better = better_moving(chosen, moving, whole, moving_ground, static_ground)
    if better is not None:
        moving = better[0]
        chosen = _forward(static_ground, better[1], signs, _forms_of(streams, moving, found, whole))
    found = {**whole, **static_found}
    chosen, again = _beside_wrong_form(static_ground, chosen, moving, signs)
    if again is None:
        chosen = with_named(static_ground, chosen) if chosen else None
        return Search(found, chosen, moving, moving_ground, static_ground, chosen)
    static_ground, judged = again
    return Search(found, on(streams, judged), moving, moving_ground, static_ground, judged, wrong_form=True)


def _beside_wrong_form(
    ground: Ground, chosen: Fit | None, moving: Fit | None, signs: Floats
) -> tuple[Fit | None, tuple[Ground, Fit | None] | None]:
    """What is chosen; and where the base's own form is wrong, the ground beside that with what was chosen there.

    Two static names that leave no more than the error of form would go before it.
    """
    if chosen is None:
        return None, None
    names = moving.names if moving else ()
    kept = [part for part in chosen.parts if part.effect.name in names]
    beside, start = beside_form(ground.streams), fit(kept) if kept else None
    if beside is None or not is_wrong(chosen, start, beside, ground.gate):
        return chosen, None
    start = on(beside, start)
    if start is not None and len(kept) == len(chosen.parts):
        return chosen, (replace(ground, streams=beside, found={}), start)
    left = square_of(beside, beside.residual - (start.heldout if start else beside.nothing))
    found, null = explore(beside, beside.context, ground.effects, signs)
    gate = replace(ground.gate, base_square=left, of_floor=SMALLEST_BESIDE)
    new = Ground(beside, ground.effects, found, null, gate)
    judged = _forward(new, start, signs, {})
    if judged is None or not large_beside(judged, ground, kept):
        alone = start is None and is_nearly_all(chosen, left, ground.gate)
        judged = on(beside, chosen) if alone else start
    if len(chosen.parts) == len(kept) + 1:
        both = two_kinds(ground, chosen, ground.found, len(kept), 0.0)
        if both is not chosen and as_good(both, beside, judged):
            return _settle(ground, both, ground.found, len(kept), {}), None
    return chosen, (new, judged)


def _forms_of(
    streams: Streams,
    moving: Fit | None,
    found: Forms,
    whole: Forms,
) -> dict[str, list[Candidate]]:
    """The forms, on the whole problem, of the effects in `moving`: those that did best there or on their own ground."""
    out = {}
    for part in moving.parts if moving else ():
        standing = whole.get(part.effect.name, [])
        known = {form.variant.key for form in standing}
        others = [form.variant for form in found[part.effect.name] if form.variant.key not in known]
        out[part.effect.name] = [*standing, *lay_out(streams, part.effect, others)]
    return out


def _forward(
    ground: Ground,
    start: Fit | None,
    signs: Floats,
    forms: Forms,
    fixed: int | None = None,
) -> Fit | None:
    """Forward selection on one ground; the first `fixed` parts stay (left out: those of `start`).

    They may take other `forms` when something comes in beside them; swap and prune touch only the others. Where one
    of the fixed has become nothing beside the others, what it had kept out is sought again without it.
    """
    chosen = start
    fixed = len(start.parts) if fixed is None and start else fixed or 0
    found = dict(ground.found)
    while chosen is None or len(chosen.parts) < MAX_EFFECTS:
        if chosen is not None:
            found |= _look_again(ground.streams, chosen, found)
        best = _best_addition(chosen, found, fixed, forms)
        if best is None or not earns(ground, chosen, best):
            break
        if chosen is not None:
            p = p_of_addition(ground.streams, chosen, found, best, signs)
        else:
            p = p_of_search(found, ground)
            p = p if p <= SIGNIFICANT else p_of_best(ground, best, signs)
        if p > SIGNIFICANT and not clear_locally(ground, chosen, best) and not everywhere(chosen, best):
            break
        if not fits_form(ground.streams, chosen, best, share_needed(ground, chosen, best)):
            break
        chosen = simplest(ground, swap(best, found, fixed), found, fixed, forms)
    if chosen is None:
        return None
    chosen, still = _prune(ground, chosen, fixed)
    chosen = _settle(ground, chosen, found, still, forms)
    chosen, still = _prune(ground, chosen, still)
    return _forward(ground, chosen, signs, forms, still) if still < fixed else chosen


def _settle(ground: Ground, chosen: Fit, found: Forms, fixed: int, forms: Forms) -> Fit:
    """The same effects in better forms, two of different kinds for one that followed both, ties to the natural one."""
    reformed = reform(chosen, forms, fixed)
    if reformed is not chosen:
        chosen = simplest(ground, swap(reformed, found, fixed), found, fixed, forms)
    if len(chosen.parts) == fixed + 1 and len(chosen.parts) < MAX_EFFECTS:
        both = simplest(ground, two_kinds(ground, chosen, found, fixed), found, fixed, forms)
        # where two of one kind do as well, the second is a misfit of form
        kinds = {part.effect.shows_in for part in both.parts[fixed:]}
        chosen = both if len(kinds) == len(both.parts) - fixed else chosen
    limited = limit_beside(ground, chosen, found, fixed)
    if limited is not chosen:
        chosen = simplest(ground, limited, found, fixed, forms)
    exchanged = in_best_forms(ground, chosen, fixed)
    if exchanged is not chosen:
        chosen = simplest(ground, exchanged, found, fixed, forms)
    return natural(chosen, found, fixed)


def _look_again(streams: Streams, chosen: Fit, found: Forms) -> dict[str, list[Candidate]]:
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


def _best_addition(chosen: Fit | None, found: Forms, fixed: int, forms: Forms) -> Fit | None:
    """The best of all plausible additions; how far the `fixed` parts went had been settled on their own ground."""
    options = [f for f in options_of(chosen, found) if stays_plausible(f, fixed)]
    best = max(options, key=lambda f: f.score.gain, default=None)
    if chosen is None or best is None:
        return best
    for option in other_forms(chosen, found, fixed, forms):
        if option.score.gain > best.score.gain and stays_plausible(option):
            best = option
    return best


def _prune(ground: Ground, chosen: Fit, fixed: int) -> tuple[Fit, int]:
    """Drop what the others do as well without; of the fixed parts only what has become nothing beside them.

    Returned with how many of the fixed are left.
    """
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
        if weakest is None or earns(ground, weakest, chosen) or stands(weakest, chosen):
            break
        chosen = weakest
    return chosen, fixed
