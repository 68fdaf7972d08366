"""A base whose own form is wrong: each chamber moves the surface, but not in the pattern that the base says.

Patches that are placed a little otherwise, a law of the wrong curve: such an error is a function of each chamber's
deflection, free in its pattern over the observables, and nothing when vented. A static name can follow it far enough to
be taken for its cause, and it can hide which name is right. So where it shows beside the names that were found, static
ones are sought again beside it: what a place, a pair or a limit does is not of that form, and stands out clearly.
"""

from collections.abc import Sequence
from dataclasses import replace

import numpy as np

from labrig.diagnosis._candidates import Candidate, Fit, clearly, fit, lay_out, square_of
from labrig.diagnosis._columns import columns_of
from labrig.diagnosis._gate import Gate, Ground
from labrig.diagnosis._streams import Streams, per_capture
from labrig.effects._rows import Floats

OBSERVABLES_PER_CHAMBER = 4
CAPTURES_PER_CHAMBER = 5
CLEARLY_SE = 2.0
SMALLEST_OF_FLOOR = 0.015
LARGE_OF_FLOOR = 0.06
SMALLEST_SHARE = 0.005
OWN_SHARE = 0.25
NEARLY_ALL = 0.15
FORM_RIDGE = 0.03
AHEAD_OF_FORM = 0.15
AHEAD_SHARE = 0.85


def beside_form(streams: Streams) -> Streams | None:
    """The same with the chambers' deflections, free in their patterns, as the base's own.

    None where a static base or these streams have them already, where there are too few captures for it, or too few
    observables: beside a single force nothing would be left of a pressure.
    """
    context = streams.context
    C, K = context.deflection.shape[1], streams.residual.shape[1]
    n = int(streams.index.max()) + 1
    known = context.base_kind == "static" or streams.as_features or streams.shrunk is not None
    known = known or not streams.use_means
    if known or n < CAPTURES_PER_CHAMBER * C or K < OBSERVABLES_PER_CHAMBER * C:
        return None
    form = np.concatenate([per_capture(context.deflection, streams.index), np.zeros((len(streams.keep), C))])
    both = form if streams.declared is None else np.column_stack([streams.declared, form])
    shrunk = np.zeros(both.shape[1])
    shrunk[-C:] = FORM_RIDGE
    return replace(streams, declared=both, shrunk=shrunk)


def on(streams: Streams, parts: "Fit | None") -> Fit | None:
    """The same effects in the same forms on other streams; None where nothing of them is left."""
    if parts is None:
        return None
    made = [lay_out(streams, part.effect, [part.variant]) for part in parts.parts]
    kept = [own[0] for own in made if own]
    return fit(kept) if kept else None


def is_wrong(chosen: Fit, moving: Fit | None, beside: Streams, gate: Gate) -> bool:
    """Whether an error of form, with the `chosen` names or in the place of the static ones, does clearly better.

    It must be of some size beside the floor, and beside what is explained: no name's form is quite right.
    """
    streams = chosen.columns.streams
    before = streams.residual - chosen.heldout
    explained = max(gate.base_square - square_of(streams, before), 0.0)
    smallest = max(SMALLEST_OF_FLOOR * gate.floor_square, SMALLEST_SHARE * explained)
    for parts in (chosen, moving):
        same = on(beside, parts)
        after = beside.residual - (same.heldout if same else beside.nothing)
        ahead = _by_block(streams, before) - _by_block(streams, after)
        falls = square_of(streams, before) - square_of(streams, after)
        least = 1.0 if falls > LARGE_OF_FLOOR * gate.floor_square else CLEARLY_SE
        if falls > smallest and clearly(ahead, streams.base_squares, least):
            return True
    return False


def large_beside(judged: Fit, ground: Ground, moving: Sequence[Candidate]) -> bool:
    """Whether the static effects that were `judged` make up much of what the base leaves, the `moving` put aside."""
    streams = ground.streams
    left = streams.residual - (fit(moving).heldout if moving else streams.nothing)
    own = np.zeros_like(left)
    names = {part.effect.name for part in moving}
    for i, part in enumerate(judged.parts):
        if part.effect.name not in names:
            own += columns_of(streams, part.variant).field(judged.own(i))
    possible = square_of(streams, left) - ground.gate.floor_square
    return square_of(streams, own) >= OWN_SHARE * possible


def is_nearly_all(chosen: Fit, left_by_form: float, gate: Gate) -> bool:
    """Whether names of the chambers' own pressures, and nothing else, explain nearly all that a form could.

    Such a name is of that form itself, so it can't stand beside it; as the smaller one it goes before.
    """
    streams = chosen.columns.streams
    left = square_of(streams, streams.residual - chosen.heldout)
    own = all(part.effect.shows_in == "own pressure" for part in chosen.parts)
    return own and left - left_by_form <= NEARLY_ALL * max(gate.base_square - left_by_form, 0.0)


def as_good(chosen: Fit, beside: Streams, judged: Fit | None) -> bool:
    """Whether names alone leave no more than those `judged` with an error of form beside them."""
    streams = chosen.columns.streams
    after = beside.residual - (judged.heldout if judged else beside.nothing)
    return bool(streams.square(streams.residual - chosen.heldout).sum() <= streams.square(after).sum())


def share_needed(ground: Ground, before: Fit | None, after: Fit) -> float | None:
    """How much of what any static map explains `after` must explain (for `fits_form`); None for as much as is usual.

    What comes in beside others and leaves clearly less than an error of form would in its place is no part of such an
    error, though a learner may still see what its own form misses. Where that error was put aside, nothing can be.
    """
    if before is None or after.parts[-1].effect.beyond_static != "no":
        return None
    if ground.streams.shrunk is not None:
        return AHEAD_SHARE
    beside = beside_form(ground.streams)
    if beside is None:
        return None
    same = on(beside, before)
    by_form = square_of(beside, beside.residual - (same.heldout if same else beside.nothing))
    left = square_of(ground.streams, ground.streams.residual - after.heldout)
    return AHEAD_SHARE if by_form - left > AHEAD_OF_FORM * ground.gate.floor_square else None


def _by_block(streams: Streams, left: Floats) -> Floats:
    each = streams.square(left)
    return np.array([each[own].sum() for own in streams.blocks])
