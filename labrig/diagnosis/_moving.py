"""Effects that live in history or time: how far they go on the whole problem, and which had been overlooked."""

from collections.abc import Mapping
from dataclasses import replace
from typing import Literal

import numpy as np

from labrig.diagnosis._candidates import (
    Candidate,
    Fit,
    clear,
    clearly,
    fit,
    lay_out,
    square_of,
    stays_plausible,
)
from labrig.diagnosis._gate import (
    MAX_EFFECTS,
    SMALLEST_OF_FLOOR,
    SMALLEST_SHARE,
    Gate,
    Ground,
    earns,
    fall,
    rules_the_hold,
)
from labrig.diagnosis._streams import Streams
from labrig.effects import Effect

TIE_SHARE = 0.03
CLEARLY_SE = 2.0
GOOD_FORM = 0.97
AS_GOOD_SHARE = 0.05
BETTER_BLOCKS = 0.66
FEW_HOLDS = 6

Design = Literal["", "levels", "holds"]


def design_of(streams: Streams) -> Design:
    """Whether a campaign cannot tell some causes apart: two `levels` of pressure at most, or hardly any `holds`."""
    rows = streams.context.rows
    if len(np.unique(rows.event)) < FEW_HOLDS:
        return "holds"
    return "levels" if max(len(np.unique(np.round(x, 2))) for x in rows.fraction.T) <= 2 else ""


def moves(effect: Effect, streams: Streams) -> bool:
    """Whether an effect must show beside a static map on this campaign."""
    return effect.beyond_static == "always" or (
        effect.beyond_static == "if reversed" and streams.context.reverses
    )


def on_whole(streams: Streams, moving: Fit, whole: Mapping[str, list[Candidate]]) -> Fit:
    """The same effects on the whole problem, in the forms that do best there together."""
    forms = [[*lay_out(streams, p.effect, [p.variant]), *whole.get(p.effect.name, ())] for p in moving.parts]
    chosen = fit([own[0] for own in forms])
    for _ in range(2):
        for i, own in enumerate(forms):
            options = [fit([*chosen.parts[:i], c, *chosen.parts[i + 1 :]]) for c in own]
            good = [f for f in options if stays_plausible(f)] or options
            top = max(f.score.gain for f in good)
            least = top - (1 - GOOD_FORM) * abs(top)
            chosen = min((f for f in good if f.score.gain >= least), key=left_by)
    return chosen


def left_by(chosen: Fit) -> float:
    """Held-out mean square that a fit leaves, in the units of the observables."""
    streams = chosen.columns.streams
    return square_of(streams, streams.residual - chosen.heldout)


def large_enough(chosen: Fit, gate: Gate) -> Fit | None:
    """Leave out what, static part included, is too small to matter beside what a static map leaves."""
    gate = replace(gate, of_floor=SMALLEST_OF_FLOOR)
    kept = []
    for i, part in enumerate(chosen.parts):
        streams = part.columns.streams
        size = square_of(streams, part.columns.field(chosen.own(i)))
        if size >= gate.smallest(SMALLEST_SHARE) or (size >= gate.smallest(0.0) and rules_the_hold(part)):
            kept.append(part)
    return fit(kept) if kept else None


def better_moving(
    chosen: Fit | None, moving: Fit | None, whole: Mapping[str, list[Candidate]], own: Ground, ground: Ground
) -> tuple[Fit, Fit] | None:
    """A moving effect that had been overlooked: beside what was chosen, or in the place of what is static there.

    One that is nearly static itself (a warm-up that is soon over) shows little beside a static map, on its `own`
    ground, but what it shows there must still be clear; on the whole problem, on `ground`, it must do clearly
    better. Where it is quite clear on its own ground, which no static effect can explain, and the error there falls in
    its own units too, it need only do as well, with fewer coefficients. Returned with those that move already, on its
    own ground and on the whole problem.
    """
    if chosen is None:
        return None
    standing = [part for part in moving.parts if part.effect.name in chosen.names] if moving else []
    names = {part.effect.name for part in standing}
    fixed = [part for part in chosen.parts if part.effect.name in names]
    static = [part for part in chosen.parts if part.effect.name not in names]
    if not static:
        return None
    before = fit(standing).score.gains if standing else 0.0
    best: tuple[Fit, Fit, Candidate, bool] | None = None
    most, design = 0.0, design_of(ground.streams)
    for name, forms in whole.items():
        if name in chosen.names:
            continue
        there = max((fit([*standing, form]) for form in own.found[name]), key=lambda f: f.score.gain)
        alone = there.score.gains - before
        if not clear(alone, own.streams.base_squares):
            continue
        shown = (
            not design
            and clearly(alone, own.streams.base_squares, CLEARLY_SE)
            and (alone > 0).mean() >= BETTER_BLOCKS
            and fall(own.streams, fit(standing) if standing else None, there) > 0
        )
        for form in forms:
            for rest in [static, *([p for p in static if p is not one] for one in static), []]:
                option, added = fit([*fixed, form, *rest]), rest is static
                both = option.score.gain + alone.sum()
                if best is not None and both <= most:
                    continue
                as_well = shown and not added and _does_as_well(chosen, option, float(alone.sum()))
                if as_well or _does_better(ground, chosen, option, added):
                    best, most = (option, there, form, added), both
    if best is None or not stays_plausible(best[0], len(fixed)):
        return None
    _, there, form, added = best
    start: Fit | None = fit([*fixed, form])
    if not added:
        start = large_enough(start, own.gate)
    if start is None or form.effect.name not in start.names:
        return None
    return there, start


def _does_better(ground: Ground, chosen: Fit, option: Fit, added: bool) -> bool:
    """Clearly, and by enough: as every addition must where one is `added`, by more than a tie where one is replaced."""
    ahead = option.score.gains - chosen.score.gains
    if added:
        se = np.sqrt(len(ahead)) * ahead.std(ddof=1)
        fits = len(option.parts) <= MAX_EFFECTS
        return fits and ahead.sum() > CLEARLY_SE * se and earns(ground, chosen, option)
    return ahead.sum() > TIE_SHARE * chosen.score.gain and clear(ahead, ground.streams.base_squares)


def _does_as_well(chosen: Fit, option: Fit, beside_static: float) -> bool:
    """With fewer coefficients, and behind by little: by less than what it explains `beside_static` maps."""
    behind = chosen.score.gain - option.score.gain
    fewer = sum(part.freedom for part in option.parts) < sum(part.freedom for part in chosen.parts)
    return fewer and behind <= min(beside_static, AS_GOOD_SHARE * chosen.score.gain)
