"""From scores to a verdict, with a probability and the reasons for it."""

from collections.abc import Mapping
from dataclasses import dataclass, field, replace
from typing import Literal

import numpy as np

import labrig.diagnosis._probability as probability
from labrig.diagnosis._candidates import Candidate, Fit, fit, square_of
from labrig.diagnosis._ceiling import NOTHING_LOGGED, STATIC, Ceiling
from labrig.diagnosis._gate import Gate, similarity
from labrig.diagnosis._moving import Design, design_of
from labrig.diagnosis._search import Search
from labrig.diagnosis._streams import Streams
from labrig.diagnosis._together import CARRIED_BY, together
from labrig.effects._rows import Floats

Name = Literal["nothing_missing", "identified", "multiple", "confounded", "unknown", "underpowered"]

ALIKE_SHARE = 0.02
ALIKE_COSINE = 0.95
ALIKE_Z_CAPTURES = 1.5
IMITATES_WIDTH = 1.5
MUCH_WIDER = 3.0
EQUAL_SHARE = 0.005
FORM_COSINE = 0.9
FORM_SHARE = 0.35
FORM_Z = 2.5
EQUAL_Z = 1.5
SAME_SHARE = 0.0003
CEILING_SE = 1.6
CEILING_SE_FEW = 2.5
FEW_CAPTURES = 60
LEARNT_Z = 4.0
LARGE_SHARE = 0.25
MOVES_SE = 2.2
UNKNOWN_OF_FLOOR = 0.35
UNKNOWN_OF_FLOOR_MOVING = 0.05
UNKNOWN_SHARE_MOVING = 0.03
UNKNOWN_OF_FLOOR_MOVING_ALONE = 0.03
UNKNOWN_SHARE_MOVING_ALONE = 0.008
STATIC_SE = 2.5
UNKNOWN_OF_FLOOR_STATIC = 0.06
UNKNOWN_SHARE_STATIC = 0.018
UNKNOWN_SHARE_FORM = 0.8
UNKNOWN_OF_FLOOR_BESIDE_FORM = 0.2
UNKNOWN_SHARE_BESIDE_FORM = 0.15
MUCH_OF_FLOOR = 0.35
MUCH_SHARE = 0.25
THE_WORST = 0.2
UNEXPLAINED_OF_FLOOR = 1.5


@dataclass(frozen=True)
class Rival:
    """Another effect in the place of `instead_of`: how far behind it is, as z-scores (blocks, captures) and as a share.

    It is not `natural` where it has what lives in each chamber the same in all, and the other has not.
    `design` says where the campaign cannot tell them apart but by the form of a curve: `levels`, no chamber was at
    more than two pressures; `holds`, hardly anything was actuated, so time in hold and time in session are one.
    """

    effect: str
    instead_of: str
    z: float
    share: float
    cosine: float
    wider: float
    z_captures: float = 0.0
    natural: bool = True
    design: Design = ""

    @property
    def alike(self) -> bool:
        """Whether these data can't tell the two apart.

        A rival with many more coefficients that only reproduces the same field (a free offset of every
        marker in place of a shifted frame) is no rival: it contains the simpler one.
        """
        same_shape = abs(self.cosine) > ALIKE_COSINE
        if self.imitates or not self.natural:
            return False
        if self.design == "levels" and same_shape and self.share < EQUAL_SHARE:
            return True
        if (
            self.design == "holds"
            and abs(self.cosine) > FORM_COSINE
            and self.z < FORM_Z
            and self.share < FORM_SHARE
        ):
            return True
        if same_shape and (self.share < SAME_SHARE or (self.share < EQUAL_SHARE and self.z < EQUAL_Z)):
            return True
        if self.wider > MUCH_WIDER or self.z_captures > ALIKE_Z_CAPTURES:
            return False
        return self.z < 1.0 and self.share < (3 * ALIKE_SHARE if same_shape else ALIKE_SHARE)

    @property
    def imitates(self) -> bool:
        """Whether it has many more coefficients and only reproduces the same field."""
        return abs(self.cosine) > ALIKE_COSINE and self.wider > IMITATES_WIDTH


@dataclass(frozen=True)
class Verdict:
    """What the data say."""

    verdict: Name
    effects: tuple[str, ...]
    probability: float
    rivals: tuple[str, ...] = ()
    carried_by: str = ""
    warnings: tuple[str, ...] = ()
    compared: tuple[Rival, ...] = field(default=())


def rivals_of(searched: Search) -> list[Rival]:
    """For each chosen effect, how every other one would do in its place, on the ground where it was chosen.

    In the place of a static one those that move stand too where no chamber was at more than two pressures:
    history and pressure are one there.
    """
    if searched.judged is None:
        return []
    design = design_of(searched.static_ground.streams)
    static = searched.found if design and not searched.wrong_form else searched.static_ground.found
    if searched.moving is None:
        return _rivals(searched.judged, static, 0, design)
    kept = set(searched.judged.names)
    fixed = sum(name in kept for name in searched.moving.names)
    own = [
        r for r in _rivals(searched.moving, searched.moving_ground.found, 0, design) if r.instead_of in kept
    ]
    return own + _rivals(searched.judged, static, fixed, design)


def _rivals(chosen: Fit, found: Mapping[str, list[Candidate]], first: int, design: Design) -> list[Rival]:
    out = []
    for i in range(first, len(chosen.parts)):
        rest = [p for j, p in enumerate(chosen.parts) if j != i]
        without = fit(rest).score.gains if rest else np.zeros_like(chosen.score.gains)
        worth = float((chosen.score.gains - without).sum())
        taken = set(chosen.names)
        for name, forms in found.items():
            if name in taken:
                continue
            fits = sorted((fit([*rest, c]) for c in forms), key=lambda f: -f.score.gain)
            each = [replace(_compare(name, chosen, i, worth, option), design=design) for option in fits]
            out.append(next((r for r in each if r.alike), each[0]))
    return out


def _compare(name: str, chosen: Fit, i: int, worth: float, option: Fit) -> Rival:
    """The last part of `option` against the i-th of `chosen`, in whose place it stands."""
    part = chosen.parts[i]
    behind = chosen.score.gains - option.score.gains
    n = len(behind)
    se = float(np.sqrt(n) * behind.std(ddof=1)) if n > 1 else np.inf
    z = behind.sum() / se if se > 0 else np.inf
    share = behind.sum() / worth if worth > 0 else 1.0
    wider = option.parts[-1].freedom / part.freedom
    cosine = similarity(chosen, i, option)
    each = _by_capture(option) - _by_capture(chosen)
    by_capture = float(each.sum() / max(np.sqrt(len(each)) * each.std(), 1e-300))
    natural = part.alike_in_all or not option.parts[-1].alike_in_all
    return Rival(name, part.effect.name, float(z), float(share), cosine, wider, by_capture, natural)


def _by_capture(chosen: Fit) -> Floats:
    streams = chosen.columns.streams
    each = streams.square(streams.residual - chosen.heldout)
    return np.bincount(streams.source, weights=each).astype(float)


def decide(
    streams: Streams,
    searched: Search,
    before: Mapping[str, Ceiling],
    after: Mapping[str, Ceiling],
    gate: Gate,
) -> Verdict:
    """Name the verdict.

    `before` and `after` are the ceilings of what the base leaves and of what the chosen effects leave.
    """
    chosen = searched.chosen
    if chosen is None:
        return _of_wrong_form() if searched.wrong_form else _without_effect(streams, before, gate)
    compared = rivals_of(searched)
    left = square_of(streams, streams.residual - chosen.heldout)
    explained = max(gate.base_square - left, 0.0)
    rest = _leftovers(streams, searched.left, after, explained)
    carrier = _unknown(chosen, rest, explained, gate.floor_square, searched.wrong_form)
    carried_by = carrier.covariates if carrier else ""
    if not carried_by and _much_is_left(searched, explained, gate.floor_square):
        carried_by = NOTHING_LOGGED
    if not carried_by and searched.judged and (other := together(searched.judged)):
        carried_by = CARRIED_BY if other.matters(gate.floor_square, explained) else ""
    if carried_by:
        names, seen = tuple(chosen.names), tuple(compared)
        return Verdict("unknown", (), probability.UNKNOWN, names, carried_by, compared=seen)
    warnings = _of_the_base(searched, left)
    if rest.learner is not None and rest.beyond > UNKNOWN_OF_FLOOR * gate.floor_square:
        warnings.append(
            f"beside {' and '.join(chosen.names)}, a smooth function of {rest.learner.covariates} would explain "
            f"{np.sqrt(rest.beyond):.3g} more: the base or the effect may be wrong in form"
        )
    alike = [r for r in compared if r.alike]
    if alike:
        names = tuple(dict.fromkeys(r.effect for r in sorted(alike, key=lambda r: r.z)))
        by_design = bool(design_of(streams))
        return Verdict(
            "confounded",
            chosen.names,
            probability.of_confounded(by_design),
            names,
            warnings=tuple(warnings),
            compared=tuple(compared),
        )
    name: Name = "identified" if len(chosen.parts) == 1 else "multiple"
    moving = all(p.effect.beyond_static != "no" for p in chosen.parts)
    sure = probability.of_names(
        square_of(streams, searched.left), gate.base_square, gate.floor_square, moving
    )
    return Verdict(name, chosen.names, sure, (), warnings=tuple(warnings), compared=tuple(compared))


def _unknown(
    chosen: Fit, rest: "Leftovers", explained: float, floor_square: float, wrong_form: bool
) -> Ceiling | None:
    """The learner that predicts too much of what the effects leave for a misfit of form, if one does.

    What depends on history or time cannot be the misfit of names that are static: hardly any of it is borne
    beside them. A name that moves may be wrong in form by some hundredths of what is explained. What is static
    beside a name that moves may be the base's own error of form; beside names that are static themselves a
    quarter of the floor (root mean square) says that they are wrong.
    """
    static_names = all(p.effect.beyond_static == "no" for p in chosen.parts)
    of_floor = UNKNOWN_OF_FLOOR_MOVING_ALONE if static_names else UNKNOWN_OF_FLOOR_MOVING
    share = UNKNOWN_SHARE_MOVING_ALONE if static_names else UNKNOWN_SHARE_MOVING
    if rest.mover is not None and rest.moving > max(of_floor * floor_square, share * explained):
        return rest.mover
    of_floor = UNKNOWN_OF_FLOOR_STATIC if static_names else UNKNOWN_OF_FLOOR
    share = UNKNOWN_SHARE_STATIC if static_names else UNKNOWN_SHARE_FORM
    if static_names and wrong_form:
        of_floor, share = UNKNOWN_OF_FLOOR_BESIDE_FORM, UNKNOWN_SHARE_BESIDE_FORM
    much = rest.beyond > max(of_floor * floor_square, share * (rest.beyond + explained))
    if rest.learner is None or not rest.static_only or not much:
        return None
    return (
        rest.learner if not static_names or rest.learner.gain > STATIC_SE * _se(rest.learner.gains) else None
    )


def _of_the_base(searched: Search, left: float) -> list[str]:
    """What is to be said of an error of form that was put aside, where there is one."""
    assert searched.chosen is not None
    more = left - square_of(searched.chosen.columns.streams, searched.left)
    if not searched.wrong_form or more <= 0:
        return []
    how = "chambers move the surface in other patterns than it says"
    if searched.could_be:
        laws = " or ".join(searched.could_be)
        how = f"chambers answer to their own pressures otherwise than it says ({laws}: not told apart here)"
    return [
        f"beside {' and '.join(searched.chosen.names)} the base is wrong in form: {how}, "
        f"by {np.sqrt(more):.3g} root mean square"
    ]


def _much_is_left(searched: Search, explained: float, floor_square: float) -> bool:
    """Whether what stays above the floor, an error of form of the base put aside, is large beside what is explained.

    What cannot be predicted from what was logged is no misfit of a name's form, nor is it noise, which the floor has. A
    static base has too little form of its own to say so, and a slip leaves the block that it fell in. It must be large
    without the worst fifth of the captures, too: the few long holds that name a leak are what its form misses most.
    """
    chosen = searched.chosen
    assert chosen is not None
    streams, left = chosen.columns.streams, searched.left
    if (
        streams.context.base_kind == "static"
        or any(part.effect.scans for part in chosen.parts)
        or design_of(streams)
    ):
        return False
    least = floor_square + max(MUCH_OF_FLOOR * floor_square, MUCH_SHARE * explained)
    each = np.bincount(streams.source, weights=streams.square(left))
    usual = (each <= np.quantile(each, 1 - THE_WORST))[streams.source][:, None]
    without = replace(streams, weight=np.where(usual, streams.weight, 0.0))
    return min(square_of(streams, left), square_of(without, left)) > least


def _of_wrong_form() -> Verdict:
    """What names could follow only as the base's own error of form is none of theirs."""
    return Verdict("unknown", (), probability.UNKNOWN, (), STATIC)


def _without_effect(streams: Streams, before: Mapping[str, Ceiling], gate: Gate) -> Verdict:
    """No named effect came in: unknown if a learner sees structure, else nothing missing or underpowered."""
    best = max(before.values(), key=lambda c: c.gain, default=None)
    if best is not None and _learnt(streams, best) > LEARNT_Z:
        left = square_of(streams, streams.residual - streams.nothing - best.heldout)
        explained = gate.base_square - left
        if explained > max(gate.smallest(0.1), UNKNOWN_OF_FLOOR * gate.floor_square):
            return Verdict("unknown", (), probability.UNKNOWN, (), best.covariates)
    smallest = detectable(streams, gate)
    if gate.tolerance is not None and smallest > gate.tolerance:
        note = (
            f"the smallest effect that these data could show is {smallest:.3g}, above the tolerance asked for"
        )
        return Verdict("underpowered", (), probability.UNDERPOWERED, warnings=(note,))
    unexplained = gate.base_square - gate.floor_square
    least = max(UNEXPLAINED_OF_FLOOR * gate.floor_square, gate.tolerance**2 if gate.tolerance else 0.0)
    if unexplained > least and streams.context.base_kind != "static":
        return Verdict("unknown", (), probability.UNKNOWN, (), NOTHING_LOGGED)
    return Verdict("nothing_missing", (), probability.NOTHING)


def detectable(streams: Streams, gate: Gate) -> float:
    """The smallest effect (root mean square, in units) that the gate would let through with these captures."""
    n = int(streams.index.max()) + 1
    seen = float((streams.weight[:, streams.counted] > 0).sum())
    noise = np.sqrt(max(gate.base_square, gate.floor_square))
    by_chance = noise * np.sqrt(
        12.0 / max(seen / max(len(streams.source) / n, 1.0), 1.0) * len(streams.patterns)
    )
    return float(max(by_chance, np.sqrt(gate.smallest(0.0))))


@dataclass(frozen=True)
class Leftovers:
    """What learners still predict of what the effects leave, as mean squares.

    `beyond` by the best of them, `learner`, if that is clear; `moving` by the best that knows more than the
    pressures, `mover`, over what they alone predict, if that is clear. `static_only`: the pressures carry most
    of it.
    """

    learner: Ceiling | None = None
    beyond: float = 0.0
    static_only: bool = False
    mover: Ceiling | None = None
    moving: float = 0.0


def _leftovers(streams: Streams, left: Floats, after: Mapping[str, Ceiling], explained: float) -> Leftovers:
    def beyond(learner: Ceiling) -> float:
        return square_of(streams, left) - square_of(streams, left - learner.heldout)

    best = max(after.values(), key=lambda c: c.gain, default=None)
    if best is None or best.gain <= 0 or beyond(best) <= 0:
        return Leftovers()
    few = int(streams.index.max()) + 1 < FEW_CAPTURES
    static = after.get(STATIC)
    static_only = static is not None and static.gain > 0.7 * best.gain
    # what lives in a few long holds fills few blocks
    local = (
        not few and beyond(best) > LARGE_SHARE * (beyond(best) + explained) and best.gain > _se(best.gains)
    )
    clear = local or best.gain > (CEILING_SE_FEW if few else CEILING_SE) * _se(best.gains)
    rest = Leftovers(best, beyond(best), static_only) if clear else Leftovers()
    moving = 0.0 if best is static else beyond(best) - (max(beyond(static), 0.0) if static else 0.0)
    moves = (local and not static_only) or best.gain > (CEILING_SE_FEW if few else MOVES_SE) * _se(best.gains)
    return replace(rest, mover=best, moving=moving) if moving > 0 and moves else rest


def _learnt(streams: Streams, learner: Ceiling) -> float:
    """How many standard errors, by capture, the learner's held-out gain is above zero."""
    left = streams.residual - streams.nothing
    each = streams.square(left) - streams.square(left - learner.heldout)
    gains = np.bincount(streams.source, weights=each)
    return float(gains.sum() / max(np.sqrt(len(gains)) * gains.std(), 1e-300))


def _se(gains: Floats) -> float:
    n = len(gains)
    return float(np.sqrt(n) * gains.std(ddof=1)) if n > 1 else float("inf")


__all__ = ["Rival", "Verdict", "decide", "detectable", "rivals_of"]
