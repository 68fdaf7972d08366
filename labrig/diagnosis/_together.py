"""What chambers do to each other beside a name of each chamber's own pressure.

A gain, an offset and a curve for every chamber can follow what its neighbours do to it on average, and leave only a
few hundredths of the error: too little for a learner of patterns, which must find them first. But where each chamber
moves the surface is known, so a learner need only find by how much, for each pressure of its neighbours. What it adds
is no misfit of a law of the chamber's own pressure: where a name is one for all chambers, such a law is fitted beside
it.
"""

from dataclasses import dataclass

import numpy as np

from labrig.diagnosis._candidates import Fit, clearly, fit, square_of, stays_plausible
from labrig.diagnosis._columns import columns_of, join
from labrig.diagnosis._gate import MAX_EFFECTS, Ground
from labrig.diagnosis._limit import is_law
from labrig.diagnosis._score import score
from labrig.effects import Context, Term, Variant
from labrig.effects._fields import overlap
from labrig.effects._rows import Floats

CARRIED_BY = "the pressures of neighbouring chambers together"
CLEARLY_SE = 2.5
OFTEN = 0.8
NEARLY_EVERYWHERE = 0.9
CLEARLY_SE_EVERYWHERE = 1.5
EVERYWHERE = 0.99
SMALLEST_OF_FLOOR = 0.015
SMALLEST_SHARE = 0.003
LARGE_SHARE = 0.02
MOST = 0.5


@dataclass(frozen=True)
class Together:
    """What the learner adds: by block of the held-out score (G,), each block's `base`, the fall of the mean square."""

    gains: Floats
    base: Floats
    fall: float

    def matters(self, floor_square: float, explained: float) -> bool:
        """Whether it is clear, in nearly every block or in all, and large enough beside what the names explain."""
        better = float((self.gains > 0).mean())
        least = NEARLY_EVERYWHERE if self.fall < LARGE_SHARE * explained else OFTEN
        clear = better >= least and clearly(self.gains, self.base, CLEARLY_SE)
        clear = clear or (better >= EVERYWHERE and clearly(self.gains, self.base, CLEARLY_SE_EVERYWHERE))
        large = self.fall > max(SMALLEST_OF_FLOOR * floor_square, SMALLEST_SHARE * explained)
        return clear and large


def together(chosen: Fit) -> Together | None:
    """Fit each chamber's response to its neighbours' pressures beside the `chosen`.

    None where nothing could come of it: a single chamber, no name of a chamber's own pressure, or one of pressures
    together among the names already.
    """
    static = [part.effect for part in chosen.parts if part.effect.beyond_static == "no"]
    kinds = {effect.shows_in for effect in static}
    streams = chosen.columns.streams
    if "own pressure" not in kinds or "pressures together" in kinds:
        return None
    term = _neighbours(streams.context)
    if term is None:
        return None
    # a name that is one for all chambers says too little of each
    each = sum(part.freedom for part in chosen.parts if is_law(part)) >= len(streams.context.rows.chambers)
    own = [] if each else [_own(streams.context)]
    one = _with(chosen, *own) if own else chosen
    both = _with(chosen, *own, term)
    before, after = (square_of(streams, streams.residual - f.heldout) for f in (one, both))
    return Together(both.score.gains - one.score.gains, streams.base_squares, before - after)


def _with(chosen: Fit, *terms: Term) -> Fit:
    """The same with columns that no effect has."""
    streams = chosen.columns.streams
    parts = [part.columns for part in chosen.parts]
    columns = join([*parts, columns_of(streams, Variant("together", terms))])
    return Fit(chosen.parts, columns, score(columns))


def with_named(ground: Ground, chosen: Fit) -> Fit:
    """The `chosen` and an effect of pressures together, where it explains most of what neighbours do."""
    left = square_of(ground.streams, ground.streams.residual - chosen.heldout)
    learnt = together(chosen) if len(chosen.parts) < MAX_EFFECTS else None
    if learnt is None or not learnt.matters(
        ground.gate.floor_square, max(ground.gate.base_square - left, 0.0)
    ):
        return chosen
    best = chosen
    for forms in ground.found.values():
        for form in forms if forms[0].effect.shows_in == "pressures together" else ():
            option = fit([*chosen.parts, form])
            gain = option.score.gain - chosen.score.gain
            if (
                gain >= MOST * learnt.gains.sum()
                and option.score.gain > best.score.gain
                and stays_plausible(option)
            ):
                best = option
    return best


def _own(context: Context) -> Term:
    """Two columns for each chamber, u_i and u_i x_i."""
    u, x = context.rows.actuation, context.rows.fraction
    each = np.eye(u.shape[1])
    feature = np.concatenate([u[:, :, None] * each, (u * x)[:, :, None] * each], axis=2)
    return Term("response", "pressure", feature)


def _neighbours(context: Context) -> Term | None:
    """One column for each chamber and each neighbour that moves the same observables: u_i x_j, on chamber i."""
    u, x, near = context.rows.actuation, context.rows.fraction, overlap(context)
    pairs = np.argwhere(near > 0)
    if not len(pairs):
        return None
    feature = np.zeros((*u.shape, len(pairs)))
    for q, (i, j) in enumerate(pairs):
        feature[:, i, q] = u[:, i] * x[:, j]
    return Term("response", "pressure", feature)
