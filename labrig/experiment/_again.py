"""The same set-points once more with a suspect taken away: the experiment that no law of it can hide from."""

from collections.abc import Iterable, Mapping
from dataclasses import dataclass

import numpy as np

from labrig._ranges import ends
from labrig.arrays import Floats, Ints
from labrig.contents import ByHand, Summary
from labrig.diagnosis import SURE, Prepared, change_of, forms_of, gone_at_most, shipped
from labrig.effects import Effect, Rows, may_act
from labrig.experiment._plan import Limits, Point

_SHORTEST_S, _LONGEST_S = 4.0, 60.0


@dataclass(frozen=True)
class Again:
    """Set-points to be measured again while an `effect` cannot act, and `what` a person does so that it cannot; or once
    that is undone (`back`).
    """

    effect: str
    what: str
    points: tuple[Point, ...]
    minutes: float
    tells: bool = True
    """Whether any of the points shows the effect where it can act."""
    back: bool = False

    @property
    def label(self) -> str:
        """What its points are called."""
        return f"{self.effect} as before" if self.back else f"{self.effect} ruled out"

    @property
    def why(self) -> str:
        """What is to be seen."""
        if self.back:
            return f"when {self.effect} acts as before, what looks like it must be there again"
        return f"when {self.effect} cannot act, what looks like it must be gone"

    @property
    def said(self) -> list[ByHand]:
        """As next.json has it."""
        hand: ByHand = {
            "effect": self.effect,
            "what": f"{self.what}, leave all else as it is, and measure {len(self.points)} set-points again",
            "points": False,
        }
        if not self.back:
            hand["captures"], hand["minutes"] = len(self.points), self.minutes
        return [hand]


def to_rule_out(found: Summary, effects: Mapping[str, Effect]) -> list[str]:
    """The names of a diagnosis that are not sure, and that somebody can rule out who has not yet, or to no avail."""
    considered = {c["effect"]: c for c in found.get("effects_considered") or ()}
    possible = [name for name, c in considered.items() if c["call"] == "possible"]
    names = [n for n in found["rivals"] or possible if n in effects and effects[n].ruled_out_by]
    return [n for n in names if 1 - SURE < considered.get(n, {}).get("gone", 0.5) < SURE]


def to_put_back(found: Summary, effects: Mapping[str, Effect], rows: Rows) -> str:
    """A name that is gone in the last captures, where it is ruled out, and that would be sure if it came back with what
    was taken away: something else may have gone in the same moment. Empty where there is none.
    """
    for c in found.get("effects_considered") or ():
        name = c["effect"]
        seen_gone = c["call"] == "possible" and c.get("gone", 0.5) >= SURE
        if not seen_gone or name not in effects or may_act(rows, name)[-1]:
            continue
        then = gone_at_most(rows, name, more=1)
        if shipped().of_name(name, c.get("by_evidence", 0.0), c.get("share", 0.0), then) >= SURE:
            return name
    return ""


def is_only_way(each: Again, found: Summary) -> bool:
    """Whether one name is all that is open, and set-points alone never make it sure."""
    return found["rivals"] == [each.effect] and shipped().at_most(each.effect) < SURE


def again(ready: Prepared, effect: Effect, limits: Limits, minutes: float) -> Again:
    """Captures of a campaign that show an effect most, for half of the time, and others spread over it, in their order.

    How much one shows it is what the best form, fitted alone, changes there, root mean square, in noises. What is
    beyond the limits is left out; a vented rig comes last.
    """
    rows = ready.context.rows
    _, first, place = np.unique(rows.capture, return_index=True, return_inverse=True)
    origin, span = ends(limits.low, limits.high)
    share = (rows.actuation[first] - origin) / span
    longest_s = np.zeros(len(first))
    np.maximum.at(longest_s, place, ready.context.elapsed_s)
    hold_s = np.clip(longest_s, _SHORTEST_S, _LONGEST_S).round(1)
    points = [
        Point(tuple(s.clip(0, 1).round(4).tolist()), float(h)) for s, h in zip(share, hold_s, strict=True)
    ]
    inside = ((share > -1e-6) & (share < 1 + 1e-6)).all(axis=1) & may_act(rows, effect.name)[first]
    shown = np.where(inside, _shown(ready, effect, place), -1.0)
    ranked = [int(c) for c in np.argsort(-shown, kind="stable") if inside[c]]
    left_s = 60 * minutes - _seconds([0], [Point(limits.rest, _SHORTEST_S)], limits)
    chosen = _in_time(ranked, points, limits, left_s / 2)
    tells = any(shown[c] > 0 for c in chosen)
    others = [c for c in np.flatnonzero(inside).tolist() if c not in chosen]
    chosen += _in_time(_spread(others), points, limits, left_s - _seconds(chosen, points, limits))
    programme = (*(points[c] for c in sorted(chosen)), Point(limits.rest, _SHORTEST_S))
    takes_min = _seconds(range(len(programme)), programme, limits) / 60
    return Again(effect.name, effect.ruled_out_by, programme, takes_min, tells)


def _shown(ready: Prepared, effect: Effect, place: Ints) -> Floats:
    """How much each capture shows an effect, in noises; zeros where no form of it can act."""
    forms = forms_of(ready.regression, ready.context, effect)
    if not forms:
        return np.zeros(int(place.max()) + 1)
    square = ((change_of(ready.context, forms[0].alone) / ready.floor.row) ** 2).mean(axis=1)
    return np.sqrt(np.bincount(place, square) / np.bincount(place))


def _spread(captures: list[int]) -> list[int]:
    """Captures in an order of which each beginning is spread over all of them: by the bits of their places, reversed
    (J. G. van der Corput 1935).
    """
    bits = max(len(captures) - 1, 1).bit_length()
    return [captures[i] for i in sorted(range(len(captures)), key=lambda i: f"{i:0{bits}b}"[::-1])]


def _in_time(order: Iterable[int], points: "list[Point]", limits: Limits, seconds: float) -> list[int]:
    """The first of these points that are done in the time."""
    chosen: list[int] = []
    for c in order:
        if _seconds([*chosen, c], points, limits) > seconds:
            break
        chosen.append(c)
    return chosen


def _seconds(chosen: Iterable[int], points: "list[Point] | tuple[Point, ...]", limits: Limits) -> float:
    """How long these points take, at most, s: each way may be a whole one."""
    way = float((np.abs(limits.high - limits.low) / limits.slew_per_s).max())
    return sum(way + points[c].hold_s for c in chosen)
