"""From scores to a verdict, with a probability and the reasons for it."""

from collections.abc import Mapping
from dataclasses import dataclass, field
from typing import Literal

import numpy as np

import labrig.diagnosis._probability as probability
from labrig.diagnosis._candidates import Candidate, Fit, fit, square_of
from labrig.diagnosis._ceiling import Ceiling
from labrig.diagnosis._gate import Gate, similarity
from labrig.diagnosis._search import STATIC, Search
from labrig.diagnosis._streams import Streams
from labrig.effects._rows import Floats

Name = Literal["nothing_missing", "identified", "multiple", "confounded", "unknown", "underpowered"]

ALIKE_SHARE = 0.02
ALIKE_COSINE = 0.95
IMITATES_WIDTH = 1.5
EQUAL_SHARE = 0.005
EQUAL_Z = 1.5
SAME_SHARE = 0.0003
CEILING_SE = 1.6
CEILING_SE_FEW = 2.5
FEW_CAPTURES = 60
FEW_HOLDS = 6
LEARNT_Z = 4.0
LARGE_SHARE = 0.25
UNKNOWN_OF_FLOOR = 0.35
UNKNOWN_OF_FLOOR_MOVING = 0.12
UNKNOWN_SHARE = 0.1
UNKNOWN_OF_FLOOR_STATIC = 0.25
UNKNOWN_SHARE_STATIC = 0.025
UNKNOWN_SHARE_FORM = 0.8


@dataclass(frozen=True)
class Rival:
    """Another effect in the place of `instead_of`: how far behind it is, as a z-score and a share."""

    effect: str
    instead_of: str
    z: float
    share: float
    cosine: float
    wider: float

    @property
    def alike(self) -> bool:
        """Whether these data can't tell the two apart.

        A rival with many more coefficients that only reproduces the same field (a free offset of every
        marker in place of a shifted frame) is no rival: it contains the simpler one.
        """
        same_shape = abs(self.cosine) > ALIKE_COSINE
        if self.imitates:
            return False
        if same_shape and (self.share < SAME_SHARE or (self.share < EQUAL_SHARE and self.z < EQUAL_Z)):
            return True
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
    if searched.chosen is None:
        return []
    on_off = _on_off(searched.static_ground.streams)
    static = searched.found if on_off else searched.static_ground.found
    if searched.moving is None:
        return _rivals(searched.chosen, static, 0)
    kept = set(searched.chosen.names)
    fixed = sum(name in kept for name in searched.moving.names)
    own = [r for r in _rivals(searched.moving, searched.moving_ground.found, 0) if r.instead_of in kept]
    return own + _rivals(searched.chosen, static, fixed)


def _on_off(streams: Streams) -> bool:
    """Whether no chamber was at more than two pressures."""
    return max(len(np.unique(np.round(x, 2))) for x in streams.context.rows.fraction.T) <= 2


def _rivals(chosen: Fit, found: Mapping[str, list[Candidate]], first: int) -> list[Rival]:
    out = []
    for i in range(first, len(chosen.parts)):
        part = chosen.parts[i]
        rest = [p for j, p in enumerate(chosen.parts) if j != i]
        without = fit(rest).score.gains if rest else np.zeros_like(chosen.score.gains)
        worth = float((chosen.score.gains - without).sum())
        taken = set(chosen.names)
        for name, forms in found.items():
            if name in taken:
                continue
            fits = sorted((fit([*rest, c]) for c in forms), key=lambda f: -f.score.gain)
            each = [_compare(name, chosen, part, worth, option) for option in fits]
            out.append(next((r for r in each if r.alike), each[0]))
    return out


def _compare(name: str, chosen: Fit, part: Candidate, worth: float, option: Fit) -> Rival:
    """The last part of `option` against `part` of `chosen`, in whose place it stands."""
    behind = chosen.score.gains - option.score.gains
    n = len(behind)
    se = float(np.sqrt(n) * behind.std(ddof=1)) if n > 1 else np.inf
    z = behind.sum() / se if se > 0 else np.inf
    share = behind.sum() / worth if worth > 0 else 1.0
    wider = option.parts[-1].freedom / part.freedom
    cosine = similarity(part, option.parts[-1])
    return Rival(name, part.effect.name, float(z), float(share), cosine, wider)


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
        return _without_effect(streams, before, gate)
    compared = rivals_of(searched)
    left = square_of(streams, streams.residual - chosen.heldout)
    explained = gate.base_square - left
    beyond, share, learner = _predictable(streams, chosen, after, explained)
    warnings: list[str] = []
    if learner is not None:
        if _is_unknown(chosen, beyond / gate.floor_square, share, _static_only(after, learner)):
            return Verdict(
                "unknown",
                (),
                probability.UNKNOWN,
                tuple(chosen.names),
                learner.covariates,
                compared=tuple(compared),
            )
        if beyond > UNKNOWN_OF_FLOOR * gate.floor_square:
            warnings.append(
                f"beside {' and '.join(chosen.names)}, a smooth function of {learner.covariates} would explain "
                f"{np.sqrt(beyond):.3g} more: the base or the effect may be wrong in form"
            )
    alike = [r for r in compared if r.alike]
    if alike:
        names = tuple(dict.fromkeys(r.effect for r in sorted(alike, key=lambda r: r.z)))
        by_design = _on_off(streams) or int(streams.index.max()) + 1 < FEW_HOLDS
        return Verdict(
            "confounded",
            chosen.names,
            probability.of_confounded(by_design),
            names,
            warnings=tuple(warnings),
            compared=tuple(compared),
        )
    name: Name = "identified" if len(chosen.parts) == 1 else "multiple"
    sure = probability.of_names(left, gate.base_square, gate.floor_square)
    return Verdict(name, chosen.names, sure, (), warnings=tuple(warnings), compared=tuple(compared))


def _is_unknown(chosen: Fit, beyond: float, share: float, static_only: bool) -> bool:
    """Whether what a learner still predicts is too much for a misfit of form.

    `beyond` is its mean square in those of the floor, `share` its part of all that is explainable. What moves
    must be explained by a name that is right, to a tenth, or to a twentieth where that is more than half a floor.
    What is static beside a name that moves may be the base's own error of form; beside names that are static
    themselves more than half a floor says that they are wrong.
    """
    if not static_only:
        much = beyond > UNKNOWN_OF_FLOOR and share > UNKNOWN_SHARE / 2
        return much or (beyond > UNKNOWN_OF_FLOOR_MOVING and share > UNKNOWN_SHARE)
    if any(p.effect.beyond_static != "no" for p in chosen.parts):
        return beyond > UNKNOWN_OF_FLOOR and share > UNKNOWN_SHARE_FORM
    return beyond > UNKNOWN_OF_FLOOR_STATIC and share > UNKNOWN_SHARE_STATIC


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


def _predictable(
    streams: Streams, chosen: Fit, after: Mapping[str, Ceiling], explained: float
) -> tuple[float, float, Ceiling | None]:
    """What a learner still predicts of what the effects leave: mean square, share of all explainable, who."""
    best = max(after.values(), key=lambda c: c.gain, default=None)
    if best is None or best.gain <= 0:
        return 0.0, 0.0, None
    left = streams.residual - chosen.heldout
    beyond = square_of(streams, left) - square_of(streams, left - best.heldout)
    share = beyond / (beyond + max(explained, 0.0)) if beyond > 0 else 0.0
    few = int(streams.index.max()) + 1 < FEW_CAPTURES
    clear = best.gain > (CEILING_SE_FEW if few else CEILING_SE) * _se(best.gains)
    # what lives in a few long holds fills few blocks
    clear = clear or (not few and share > LARGE_SHARE and best.gain > _se(best.gains))
    return (beyond, share, best) if clear and share > 0 else (0.0, 0.0, None)


def _static_only(after: Mapping[str, Ceiling], learner: Ceiling | None) -> bool:
    """Whether the pressures alone carry most of what is still predictable."""
    return learner is not None and STATIC in after and after[STATIC].gain > 0.7 * learner.gain


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
