"""The design matrix: every space as columns over the observations, under its own prior."""

from collections import Counter
from collections.abc import Callable, Iterator, Mapping, Sequence
from dataclasses import dataclass, replace

import numpy as np

from labrig.arrays import Floats
from labrig.diagnosis._alone import with_single
from labrig.diagnosis._columns import Columns
from labrig.diagnosis._curves import MAP, curves, family_of
from labrig.diagnosis._directions import directions
from labrig.diagnosis._layout import Layout, Made
from labrig.diagnosis._motions import MOTION, motions
from labrig.diagnosis._names import alike, different, has_name, spans
from labrig.diagnosis._observations import Observations
from labrig.diagnosis._one_sensor import SENSOR, of_one_sensor
from labrig.diagnosis._ripple import RIPPLE, ripple
from labrig.diagnosis._tone import TONE, tones
from labrig.diagnosis._unnamed import unnamed
from labrig.effects import Effect, Space

SLOW = "slow noise"
"""The owner of noise that neighbouring captures share."""
DECLARED = "declared"
"""The owner of what the base calls its own."""


@dataclass(frozen=True)
class Block:
    """The columns of one space: `at` says which; owners of the same space have the same."""

    owner: str
    space: Space
    at: slice
    share: float = 1.0
    """Prior probability of this space among those of its owner; of a shared one the least of its owners'."""
    way: Floats | None = None
    """By how much each of its columns (q,) goes the only way in which it can act; None where it may go either way."""


@dataclass(frozen=True)
class FreeBlock:
    """Regressors (S, g) of a space whose shape over all observables is free, kept as they are (a Kronecker product)."""

    owner: str
    space: Space
    G: Floats


@dataclass(frozen=True)
class Design:
    """All columns `W` (P over S r) along directions `V` (K, r), in floors, each of unit prior variance.

    Every space makes one floor, root mean square, before it is scaled. `free` blocks are
    patterns over all observables.
    """

    observations: Observations
    V: Floats
    spread: Floats
    """Prior variance (r,) of free patterns along each direction; over all observables one on average."""
    W: Columns
    blocks: tuple[Block, ...]
    free: tuple[FreeBlock, ...]
    counts: Floats
    """What a floor along each direction (r,) counts for: less than one where all markers shake that way."""


def design_of(
    observations: Observations,
    effects: Mapping[str, Effect],
    declared: Floats | None = None,
    calibrated: Floats | None = None,
) -> Design:
    """Lay out families and plain forms of `effects`, what has no name, slow noise, and what the base calls its own.

    `declared` (F, D) are regressors of every observable by itself, `calibrated` (F, K, D) fields that all share.
    """
    context = observations.context
    named = family_of(effects, context)
    others = _without_name(named, effects, observations)
    V, spread = directions(observations, different([space for _, space in named]))
    layout = Layout(observations, V)
    shared = _shared([*named, *others])
    del named, others
    made, free = _as_columns(layout, shared, with_single(observations))
    made.append(_made(Space(SLOW, SLOW, ()), layout.slow()))
    if calibrated is not None and calibrated.shape[2]:
        made.append(_made(Space(DECLARED, DECLARED, ()), layout.fields(calibrated)))
    if declared is not None:
        G = observations.of_rows(declared)
        G = G[:, np.abs(G).max(axis=0) > 0]
        free.append(FreeBlock(DECLARED, Space(DECLARED, DECLARED, ()), G))
    elif context.learned and context.moves:
        free.append(FreeBlock(RIPPLE.key, RIPPLE, observations.of_rows(ripple(context))))
    made.sort(key=lambda m: not m.through)
    blocks = _blocks(made)
    W = layout.together(made)
    blocks = [
        b if b.space.along is None else replace(b, way=layout.way(b.space.along, W, b.at)) for b in blocks
    ]
    counts = np.ones(len(spread))
    return stilled(Design(observations, V, spread, W, tuple(blocks), tuple(free), counts), observations)


def _without_name(
    named: Sequence[tuple[str, Space]], effects: Mapping[str, Effect], observations: Observations
) -> list[tuple[str, Space]]:
    """The spaces without a name, by owner: what none of those with one holds, and the base's own errors of form."""
    context = observations.context
    spanned = [spans(space) for _, space in named]
    followed = {name for effect in effects.values() for name in effect.follows(context)}
    lonely = (space for space in unnamed(context, followed) if not has_name(space, spanned))
    found = [("?" + space.spectrum, space) for space in lonely]
    of_form = {
        MOTION: motions(context),
        MAP: curves(named, effects, context),
        SENSOR: of_one_sensor(observations),
        TONE: tones(observations),
    }
    return found + [("?" + owner, space) for owner, spaces in of_form.items() for space in spaces]


def _shared(spaces: Sequence[tuple[str, Space]]) -> list[list[tuple[str, Space]]]:
    """Spaces by owner, each with all its owners; what every observable has a measure of its own in has one."""
    out: list[list[tuple[str, Space]]] = []
    for owner, space in spaces:
        same = None if _is_free(owner, space) else next((own for own in out if alike(own[0][1], space)), None)
        if same is None:
            out.append([(owner, space)])
        else:
            same.append((owner, space))
    return out


def _is_free(owner: str, space: Space) -> bool:
    """Whether every observable has a measure of its own in it, and it has no name."""
    return owner.startswith("?") and {f.kind for f in space.features} == {"pattern"}


def _as_columns(
    layout: Layout,
    shared: list[list[tuple[str, Space]]],
    and_single: Callable[[str, Space], Iterator[Space]],
) -> tuple[list[Made], list[FreeBlock]]:
    """Spaces by owners as columns, each once for all of them, and then in one chamber or session alone; and those in
    which every observable has a measure.

    Of many captures there would not be room for columns and features: these are let go, and `shared` is empty after it.
    """
    made: list[Made] = []
    free: list[FreeBlock] = []
    while shared:
        by_key: dict[str, list[tuple[str, Space]]] = {}
        for owner, space in shared.pop(0):
            for one in and_single(owner, space):
                by_key.setdefault(one.key, []).append((owner, one))
        for owners in by_key.values():
            owner, space = owners[0]
            bare = [(name, replace(own, features=())) for name, own in owners]
            if _is_free(owner, space):
                G = layout.regressors(space)
                if G.shape[1]:
                    free.append(FreeBlock(owner, bare[0][1], G))
            elif space.features:
                through = space.apart is None and {f.kind for f in space.features} == {"pressure"}
                columns = layout.through_pressures(space) if through else layout.columns(space)
                if columns is not None:
                    made.append(Made(columns, through, bare))
    return made, free


def _made(space: Space, columns: Floats) -> Made:
    """What is no effect's, and is its own owner."""
    return Made(columns, False, [(space.key, space)])


def _blocks(made: Sequence[Made]) -> list[Block]:
    """The blocks of all owners, where their columns stand side by side."""
    count = Counter((owner, space.plain) for m in made for owner, space in m.owners if not space.alone_in)
    blocks, start = [], 0
    for m in made:
        at = slice(start, start := start + m.columns.shape[2])
        share = min(_share(owner, space, count) for owner, space in m.owners)
        blocks += [Block(owner, space, at, share) for owner, space in m.owners]
    return blocks


def stilled(design: Design, observations: Observations) -> Design:
    """A design of raw observations as one of observations that count less what shakes (`Observations.still`).

    What shakes is then a direction, or several, by itself; the others are the principal axes beside it.
    """
    still, V = observations.still, design.V.astype(float)
    m = len(still.less)
    if m == 0:
        return design
    shaken = np.linalg.qr(V.T @ still.ways)[0]
    beside = np.linalg.svd(np.eye(len(V.T)) - shaken @ shaken.T)[0][:, : len(shaken) - m]
    turn = np.concatenate([shaken, beside @ np.linalg.eigh((beside.T * design.spread) @ beside)[1]], axis=1)
    counts = np.concatenate([still.less, np.ones(len(turn) - m)])
    spread = (turn**2).T @ design.spread * counts**2
    to = (turn * counts).astype(design.V.dtype)
    return replace(
        design,
        observations=observations,
        V=(V @ turn).astype(design.V.dtype),
        spread=spread,
        W=design.W.turned(to),
        counts=counts,
    )


def _share(owner: str, space: Space, count: Mapping[tuple[str, bool], int]) -> float:
    """Spaces of one owner are equally likely, and its plain forms together as likely as its other spaces together;
    where they were found by a scan, as likely as each place scanned. That all chambers have it is as likely as that one
    alone has, whichever it is.
    """
    if space.scanned:
        return 1.0 / space.scanned
    both = 1.0 + ((owner, not space.plain) in count)
    # one chamber's may be there where what all have was too little to be laid out
    return 1.0 / both / max(count[owner, space.plain], 1) / space.rarer
