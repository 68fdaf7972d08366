"""What an effect must show to come in: better than chance, clearly, and by enough to matter."""

from collections.abc import Mapping
from dataclasses import dataclass, replace

import numpy as np

from labrig.diagnosis._blocks import MAX_GROUPS
from labrig.diagnosis._candidates import Candidate, Fit, clear, explore, fit, relative, square_of
from labrig.diagnosis._ceiling import STATIC, ceiling
from labrig.diagnosis._score import null_gains, score
from labrig.diagnosis._streams import Streams
from labrig.effects import Effect
from labrig.effects._rows import Floats

MAX_EFFECTS = 3
SIGNIFICANT = 0.02
EVERYWHERE = 10
LOCAL_Z = 2.0
LOCAL_OF_FLOOR = 0.55
SMALLEST_OF_FLOOR = 0.33
SMALLEST_SHARE = 0.1
SMALLEST_OF_REST = 0.6
SMALLEST_SHARE_OF_REST = 0.04
RULES_SHARE = 0.5
STATIC_SHARE_FIRST = 0.3
STATIC_SHARE_NEXT = 0.98


@dataclass(frozen=True)
class Gate:
    """What an effect must pass to come in: squares are mean squares in the units of the observables."""

    floor_square: float
    base_square: float
    tolerance: float | None
    of_floor: float = SMALLEST_OF_FLOOR

    def smallest(self, share: float) -> float:
        """The least fall of the mean square that matters."""
        least = (self.of_floor**2) * self.floor_square
        least = max(least, share * max(self.base_square - self.floor_square, 0.0))
        return max(least, self.tolerance**2) if self.tolerance else least


@dataclass(frozen=True)
class Ground:
    """Where a group of effects competes: streams, the forms found there, and the null of the whole search."""

    streams: Streams
    effects: Mapping[str, Effect]
    found: Mapping[str, list[Candidate]]
    null: Floats
    gate: Gate


def p_of_search(found: Mapping[str, list[Candidate]], ground: Ground) -> float:
    shares = [relative(c.score.gains, ground.streams.base_squares) for forms in found.values() for c in forms]
    return float((1 + (ground.null >= max(shares, default=0.0)).sum()) / (1 + len(ground.null)))


def earns(ground: Ground, before: Fit | None, after: Fit) -> bool:
    """Better than its standard error, and large enough beside what is explained already.

    A second effect may be small beside the first, which took some of it along, when it explains most of what
    is left.
    """
    more = after.score.gains - (before.score.gains if before else 0.0)
    if more.sum() <= 0 or not clear(more, ground.streams.base_squares):
        return False
    gate, fell = ground.gate, fall(ground.streams, before, after)
    if before is None:
        return fell >= gate.smallest(0.0)
    if fell >= gate.smallest(SMALLEST_SHARE):
        return True
    left = square_of(ground.streams, ground.streams.residual - before.heldout) - gate.floor_square
    return fell >= max(gate.smallest(SMALLEST_SHARE_OF_REST), SMALLEST_OF_REST * left)


def fall(streams: Streams, before: Fit | None, after: Fit) -> float:
    """By how much the held-out mean square falls."""
    left = square_of(streams, streams.residual - (before.heldout if before else streams.nothing))
    return left - square_of(streams, streams.residual - after.heldout)


def fits_form(streams: Streams, before: Fit | None, after: Fit, needed: float | None = None) -> bool:
    """Whether a static effect explains most of what any static map of the pressures could.

    If it does not, it is no more than a part of a base of wrong form, and its name would mislead. A form that is right
    does as well as a learner, which has to find it from the same captures, or better; the first one may do worse, for
    what comes later. `needed` is the share that is asked for, if not that.
    """
    if streams.as_features or after.parts[-1].effect.beyond_static != "no":
        return True
    left = streams.residual - (before.heldout if before else streams.nothing)
    learnt = ceiling(streams, streams.context, left, only=STATIC)
    if not learnt:
        return True
    possible = square_of(streams, left) - square_of(streams, left - learnt[STATIC].heldout)
    usual = STATIC_SHARE_FIRST if before is None else STATIC_SHARE_NEXT
    return fall(streams, before, after) >= (usual if needed is None else needed) * possible


def everywhere(before: Fit | None, after: Fit) -> bool:
    """Whether nearly every left-out block is predicted better.

    Where flipped blocks leave the search much to find (a base of wrong form does), the p-value says little;
    under the null a block gains or loses by chance, and twelve of twelve gain in one case of 4096.
    """
    more = after.score.gains - (before.score.gains if before else 0.0)
    return len(more) >= EVERYWHERE and int((more <= 0).sum()) <= (1 if len(more) >= MAX_GROUPS else 0)


def clear_locally(ground: Ground, before: Fit | None, after: Fit) -> bool:
    """Whether single captures say so clearly, and it is large.

    Signs of m blocks can give no p-value below 2^(1 - m), so what happens in a few blocks only (a slip, a
    limit that is rarely reached) needs another way in: a fall that is larger than all that slow noise of
    half a floor could give, and clear by capture.
    """
    streams = ground.streams
    old = streams.residual - (before.heldout if before else streams.nothing)
    each = streams.square(old) - streams.square(streams.residual - after.heldout)
    gains = np.bincount(streams.source, weights=each)
    z = gains.sum() / max(np.sqrt(len(gains)) * gains.std(ddof=1), 1e-300) if len(gains) > 2 else 0.0
    return bool(z > LOCAL_Z and fall(streams, before, after) > LOCAL_OF_FLOOR**2 * ground.gate.floor_square)


def similarity(chosen: Fit, i: int, option: Fit) -> float:
    """How alike the fields of the i-th part of `chosen` and of the last of `option` are, each beside the others."""
    last = option.parts[-1].columns.field(option.own(len(option.parts) - 1))
    return cosine(chosen.columns.streams, chosen.parts[i].columns.field(chosen.own(i)), last)


def cosine(streams: Streams, one: Floats, other: Floats) -> float:
    """Cosine between two fields (S, K), weighted as the scores are; 0 where one is nothing."""
    w = streams.weight
    size = np.sqrt((w * one**2).sum() * (w * other**2).sum())
    return float((w * one * other).sum() / size) if size > 0 else 0.0


def p_of_best(ground: Ground, best: Fit, signs: Floats) -> float:
    """How often the whole search would find as much in what `best` leaves, by flipped blocks.

    A strong effect, flipped by blocks, looks like a drift of itself; flipping what it leaves does not.
    """
    streams = ground.streams
    observed = relative(best.score.gains, streams.base_squares)
    left = replace(streams, residual=streams.residual - best.columns.field(best.score.beta))
    _, null = explore(left, streams.context, ground.effects, signs)
    return float((1 + (null >= observed).sum()) / (1 + len(null)))


def p_of_addition(
    streams: Streams, chosen: Fit, found: Mapping[str, list[Candidate]], best: Fit, signs: Floats
) -> float:
    """How often the whole search would find as much in what `chosen` leaves, by flipped blocks."""
    left = replace(streams, residual=streams.residual - chosen.columns.field(chosen.score.beta))
    largest = np.zeros(len(signs))
    observed = 0.0
    for name, forms in found.items():
        for c in forms:
            columns = replace(c.columns, streams=left)
            scored = score(columns)
            largest = np.maximum(largest, null_gains(columns, signs, scored.ridge, streams.base_squares))
            if name == best.names[-1]:
                observed = max(observed, relative(scored.gains, streams.base_squares))
    return float((1 + (largest >= observed).sum()) / (1 + len(signs)))


def rules_the_hold(part: Candidate) -> bool:
    """Whether an effect explains most of what changes within the holds, however much differs between them."""
    streams = part.columns.streams
    within = streams.within_holds
    if not within.any():
        return False
    before = (streams.residual - streams.nothing)[within]
    after = (streams.residual - fit([part]).heldout)[within]
    seen = streams.weight[within] > 0
    return bool(np.square(after[seen]).sum() < RULES_SHARE * np.square(before[seen]).sum())
