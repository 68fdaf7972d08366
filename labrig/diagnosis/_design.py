"""The design matrix: every space as columns over the observations, under its own prior."""

from collections import Counter
from collections.abc import Mapping
from dataclasses import dataclass, replace
from typing import Any

import numpy as np

from labrig.arrays import Floats
from labrig.diagnosis._alone import single
from labrig.diagnosis._columns import Columns, gram
from labrig.diagnosis._curves import MAP, curves, family_of
from labrig.diagnosis._directions import directions
from labrig.diagnosis._motions import MOTION, motions
from labrig.diagnosis._names import alike, different, has_name, spans
from labrig.diagnosis._observations import Observations
from labrig.diagnosis._one_sensor import SENSOR, of_one_sensor
from labrig.diagnosis._ripple import RIPPLE, ripple
from labrig.diagnosis._spectra import factor, prior_of
from labrig.diagnosis._unnamed import slow_noise, unnamed
from labrig.effects import Effect, Feature, Space, motion_scale

SLOW = "slow noise"
DECLARED = "declared"
_MOST_COLUMNS = 64
_FREE_COLUMNS = 160
LEAST_SHARE = 2e-5
"""Share of a family's variance below which a direction is left out: half a per cent of its size."""


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
    known = [space for _, space in named]
    spanned = [spans(space) for space in known]
    followed = {name for effect in effects.values() for name in effect.follows(context)}
    lonely = (space for space in unnamed(context, followed) if not has_name(space, spanned))
    others = [("?" + space.spectrum, space) for space in lonely]
    more = {
        MOTION: motions(context),
        MAP: curves(named, effects, context),
        SENSOR: of_one_sensor(observations),
    }
    others += [("?" + owner, space) for owner, spaces in more.items() for space in spaces]
    V, spread = directions(observations, different(known))
    made: list[_Made] = []
    free: list[FreeBlock] = []
    layout = _Layout(observations, V)
    for owner, space in single([*named, *others], observations):
        if not space.features:
            continue
        if owner.startswith("?") and all(f.kind == "pattern" for f in space.features):
            G = layout.regressors(space)
            if G.shape[1]:
                free.append(FreeBlock(owner, space, G))
            continue
        if again := next((m for m in made if alike(m.space, space)), None):
            again.owners.append((owner, space))
            continue
        acts = space.apart is None and all(f.kind == "pressure" for f in space.features)
        columns = layout.through_pressures(space) if acts else layout.columns(space)
        if columns is not None:
            made.append(_Made(space, columns, acts, [(owner, space)]))
    slow = Space(SLOW, SLOW, ())
    made.append(_Made(slow, layout.slow(), False, [(SLOW, slow)]))
    if calibrated is not None and calibrated.shape[2]:
        space = Space(DECLARED, DECLARED, ())
        made.append(_Made(space, layout.fields(calibrated), False, [(DECLARED, space)]))
    if declared is None and context.learned and context.moves:
        free.append(FreeBlock(RIPPLE.key, RIPPLE, observations.whiten @ ripple(context)))
    if declared is not None:
        G = observations.whiten @ declared
        keep = np.abs(G).max(axis=0) > 0
        free.append(FreeBlock(DECLARED, Space(DECLARED, DECLARED, ()), G[:, keep]))
    made.sort(key=lambda m: not m.through)
    count = Counter((owner, space.plain) for m in made for owner, space in m.owners if not space.alone_in)
    blocks, start = [], 0
    for m in made:
        at = slice(start, start := start + m.columns.shape[2])
        share = min(_share(owner, space, count) for owner, space in m.owners)
        blocks += [Block(owner, space, at, share) for owner, space in m.owners]
    W = layout.together(made)
    blocks = [
        b if b.space.along is None else replace(b, way=layout.way(b.space.along, W, b.at)) for b in blocks
    ]
    return stilled(
        Design(observations, V, spread, W, tuple(blocks), tuple(free), np.ones(len(spread))), observations
    )


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


@dataclass(frozen=True)
class _Made:
    """A space that was laid out, once for all its owners: (S, C, q) where it acts through pressures, or (S, r, q)."""

    space: Space
    columns: Floats
    through: bool
    owners: list[tuple[str, Space]]


def _side_by_side(made: list[_Made], rows: tuple[int, int], dtype: "np.dtype[Any]") -> Floats:
    """The columns of all of these in one array; the list is empty after it."""
    out, at = np.empty((*rows, sum(m.columns.shape[2] for m in made)), dtype=dtype), 0
    while made:
        columns = made.pop(0).columns
        out[:, :, at : (at := at + columns.shape[2])] = columns
    return out


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


def _shown(L: Floats, shows: Floats) -> Floats:
    """Functions L (a, q) as principal ones, their squares' sums L' `shows` L, without those that hardly show: all
    that are left out together are a direction that would be.
    """
    power, turn = np.linalg.eigh(L.T @ shows @ L)
    return L @ turn[:, np.cumsum(power) > LEAST_SHARE * max(power.sum(), 0.0)]


def _fewer(moves: Floats) -> Floats:
    """Slopes (n, r, C) whose products are the same, in fewer directions where there are fewer chambers."""
    return moves if moves.shape[1] <= moves.shape[2] else np.linalg.qr(moves)[1]


class _Layout:
    """Turns features into whitened columns along the directions V."""

    def __init__(self, observations: Observations, V: Floats) -> None:
        self.observations, self.V = observations, V
        self.dtype = V.dtype
        self.moves = self._along(V)
        self.fewer = _fewer(self.moves)
        self.T = observations.whiten.astype(self.dtype)

    def _along(self, V: Floats) -> Floats:
        """How far each chamber's whole range moves each capture along directions V (K, r), in floors, (n, r, C)."""
        return np.einsum("nkc,kr->nrc", self.observations.slopes.astype(self.dtype), V.astype(self.dtype))

    def columns(self, space: Space) -> Floats | None:
        """Whitened columns (S, r, q), of one floor in all, rotated to principal axes."""
        if space.apart is not None:
            return self.apart(space, space.apart)
        raw = self.raw(space)
        flat, W = raw.reshape(-1), self.lift(raw)
        square = float(np.einsum("i,i->", flat, flat, dtype=np.float64))
        U = self.axes(space, square, W.reshape(-1, W.shape[2]))
        return None if U is None else W @ U

    def axes(self, space: Space, square: float, W: Floats) -> Floats | None:
        """The principal axes (q, p) of whitened columns whose rows have this square, for one floor in all."""
        total = square / (len(self.observations.index) * len(self.observations.unit))
        if total <= 0:
            return None
        power, U = np.linalg.eigh(gram(W) / total)
        keep = power > max(self._said(), LEAST_SHARE * power.sum())
        keep[: max(0, len(keep) - max(_MOST_COLUMNS, self.wide(space)))] = False
        return (U[:, keep][:, ::-1] / np.sqrt(total)).astype(self.dtype) if keep.any() else None

    def apart(self, space: Space, groups: Floats) -> Floats | None:
        """The same for changes of pressures that each of some groups of observables (n, K) takes on by itself, and all
        as much.
        """
        out, most = [], _FREE_COLUMNS // len(groups)
        for own in groups:
            moves = self._along(own[:, None] * self.V)
            Z = self.through_pressures(space, moves)
            if Z is not None:
                out.append(moves[self.observations.capture] @ (Z[:, :, :most] / np.sqrt(len(groups))))
        return np.concatenate(out, axis=2) if out else None

    def through_pressures(self, space: Space, within: Floats | None = None) -> Floats | None:
        """The same for changes of pressures alone, as what they do to the pressures, (S, C, q).

        How they move the observables is one matrix (r, C) all through a capture. So only the pressures are whitened,
        and the axes are found in the chambers' own coordinates, where these are fewer. `within` (n, r, C): the
        slopes of each capture, where they are not those of all observables.
        """
        moves = self.moves if within is None else within
        fewer = self.fewer if within is None else _fewer(within)
        prior, capture = prior_of(space), self.observations.capture
        P = np.stack([f.values for f in space.features], axis=2).astype(self.dtype)  # (F, C, a)
        F, C, a = P.shape
        both = np.einsum("nrc,nrd->ncd", moves, moves)[self.observations.index]
        alone = np.einsum("fcc->fc", both)
        shows = np.sum([size * P[:, c].T @ P[:, c] for c, size in enumerate(alone.mean(axis=0))], axis=0)
        shared, own = (_shown(factor(L), shows).astype(self.dtype) for L in (prior.shared, prior.own))
        if C == 1:
            own = own[:, :0]
        if shared.shape[1] + own.shape[1] == 0:
            return None
        rows = P @ shared
        square = float(np.einsum("fcq,fcq->", both @ rows, rows, dtype=np.float64))
        square += float(np.einsum("fc,fcq->", alone, (P @ own) ** 2, dtype=np.float64))
        lifted = np.asarray(self.T @ P.reshape(F, C * a)).reshape(-1, C, a)
        Z = np.zeros((len(lifted), C, shared.shape[1] + C * own.shape[1]), dtype=self.dtype)
        Z[:, :, : shared.shape[1]] = lifted @ shared
        for c in range(C):
            start = shared.shape[1] + c * own.shape[1]
            Z[:, c, start : start + own.shape[1]] = lifted[:, c] @ own
        U = self.axes(space, square, (fewer[capture] @ Z).reshape(-1, Z.shape[2]))
        return None if U is None else Z @ U

    def together(self, made: "list[_Made]") -> Columns:
        """All columns: first those that act through pressures, then the others. Each is let go once it is copied, so
        `made` is empty after it: of many captures there would not be room for all of them twice.
        """
        capture, C, r = self.observations.capture, self.moves.shape[2], self.V.shape[1]
        of = {acts: [m for m in made if m.through == acts] for acts in (True, False)}
        made.clear()
        through = _side_by_side(of[True], (len(capture), C), self.dtype)
        return Columns(through, self.moves, capture, _side_by_side(of[False], (len(capture), r), self.dtype))

    def _said(self) -> float:
        """The power of a direction of which the data say as much as its prior, at the size of all to explain."""
        return 1.0 / (self.observations.worth * max(1.0, self.observations.to_explain) ** 2)

    def wide(self, space: Space) -> int:
        """How many columns a space may keep: a free pattern takes one for each direction."""
        return _FREE_COLUMNS if any(f.kind == "pattern" for f in space.features) else 0

    def raw(self, space: Space) -> Floats:
        """Columns (F, r, q) in floors, each of unit prior variance."""
        prior = prior_of(space)
        unit, V = self.observations.unit, self.V
        pressures = [f.values for f in space.features if f.kind == "pressure"]
        fields = [f.values for f in space.features if f.kind == "field"]
        patterns = [f.values for f in space.features if f.kind == "pattern"]
        out = []
        shared = []
        if pressures:
            P = np.stack(pressures, axis=2).astype(self.dtype)  # (F, C, a)
            moves = self.moves[self.observations.index]
            shared.append(moves @ P)
            own = factor(prior.own).astype(self.dtype)
            if own.shape[1] and P.shape[1] > 1:
                each = P @ own
                out.append((moves[:, :, :, None] * each[:, None]).reshape(len(P), V.shape[1], -1))
        if fields:
            shared.append(np.stack([(f / unit).astype(self.dtype) @ V for f in fields], axis=2))
        if shared:
            out.append(np.concatenate(shared, axis=2) @ factor(prior.shared).astype(self.dtype))
        if patterns:
            r = V.shape[1]
            L = factor(prior.pattern)
            L = L[:, np.argsort(-(L**2).sum(axis=0))][:, : max(1, _FREE_COLUMNS // r)]
            size = float(np.sqrt(np.mean((motion_scale(self.observations.context) / unit) ** 2)))
            Q = (size * np.stack(patterns, axis=1) @ L).astype(self.dtype)
            wide = np.zeros((len(Q), r, Q.shape[1], r), dtype=self.dtype)
            wide[:, np.arange(r), :, np.arange(r)] = Q[None]
            out.append(wide.reshape(len(Q), r, -1))
        return np.concatenate(out, axis=2)

    def way(self, along: Feature, W: Columns, at: slice) -> Floats:
        """How much of a feature's own change each column of a block has, (q,): of pressures in each chamber by itself,
        by how far it moves the rig, since chambers that move it against each other are no less held back.
        """
        if along.kind == "pressure":
            shows = np.einsum("nrc,nrc->nc", self.moves, self.moves)[self.observations.capture]
            held = self.T @ along.values.astype(self.dtype)
            return np.einsum("sc,scq->q", shows * held, W.through[:, :, at]).astype(float)
        raw = ((along.values / self.observations.unit).astype(self.dtype) @ self.V)[:, :, None]
        return np.asarray(self.lift(raw).reshape(-1) @ W.of(at), dtype=float)

    def lift(self, raw: Floats) -> Floats:
        """Rows (F, r, q) to observations (S, r, q)."""
        F, r, q = raw.shape
        return np.asarray(self.T @ raw.reshape(F, r * q)).reshape(-1, r, q)

    def regressors(self, space: Space) -> Floats:
        """Regressors (S, g) of free patterns, of one floor in all, as principal axes."""
        f = np.stack(
            [np.sqrt(q.weight) * q.values / (np.sqrt(np.mean(q.values**2)) + 1e-12) for q in space.features],
            axis=1,
        )
        f = f / np.sqrt((f**2).sum() / len(f))
        G = self.observations.whiten @ f
        power, U = np.linalg.eigh(G.T @ G)
        keep = power > max(
            0.1 * self._said(), 1e-7 * power[-1]
        )  # each stands for r directions: a tenth is heard
        return (G @ U[:, keep])[:, ::-1]

    def fields(self, values: Floats) -> Floats:
        """Columns of fields (F, K, q) in the observables' units, each of one floor."""
        raw = np.einsum("fkq,kr->frq", values / self.observations.unit[None, :, None], self.V).astype(
            self.dtype
        )
        raw = raw / np.maximum(np.sqrt((raw**2).sum(axis=1).mean(axis=0) / len(self.V)), 1e-12)
        return self.lift(raw)

    def slow(self) -> Floats:
        """Slow noise along each axis (of unmarked observables: of all together), one floor."""
        rows = self.observations.context.rows
        series = slow_noise(self.observations.context, self.observations.index).astype(self.dtype)
        axes = [rows.axis == a for a in (-1, 0, 1, 2) if (rows.axis == a).any()]
        raw = np.concatenate(
            [series[:, None, :] * self.V[a].sum(axis=0)[None, :, None] for a in axes], axis=2
        )
        return self.lift(raw)
