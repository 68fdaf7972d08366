"""Stops at the end of a motion: of the body as a whole, or of one joint, slider or lever that a sensor follows."""

from collections.abc import Iterator
from dataclasses import dataclass

import numpy as np

from labrig._linalg import svd
from labrig.arrays import Floats, Ints
from labrig.effects._context import FEW_OBSERVABLES, Context
from labrig.effects._effect import Term, Variant
from labrig.effects._family import Space, acting, field, motion_scale, one_way
from labrig.effects._sign import ABOVE, BELOW, Part, Sign, along_own
from labrig.effects._skin import at_events, seen_alone
from labrig.effects._speeds import LENGTHS

_LEVELS = (0.35, 0.5, 0.65, 0.8, 0.9)
_FINE = tuple(round(0.3 + 0.05 * i, 2) for i in range(14))
"""Shares of the way at which the body, or one joint, is stopped: a stop between two of these is nearly a mixture."""
_FAR = 0.3
"""Share of the main motion from which on another one is looked at."""
STOP_OF = "stop of "


def end_stops(context: Context) -> Iterator[Space]:
    """The body, in one of its two main motions, or what one of few sensors follows, runs against a stop."""
    scale = motion_scale(context)
    moved = context.displacement / scale
    modes = context.yardstick("main ways", lambda: _main_ways(moved))
    for j, mode in enumerate(modes):
        along = moved @ mode
        for side in (1.0, -1.0):
            top = float(context.yardstick(f"farthest {side:+.0f} along way {j}", (side * along).max))
            if not context.shows(top >= _FAR * np.abs(moved @ modes[0]).max()):
                continue
            past = [(level, np.maximum(side * along - level * top, 0.0)) for level in _LEVELS]
            out = [field(f"end {level}", -p[:, None] * side * mode * scale) for level, p in past]
            yield one_way(Space(f"end of motion {_sign(side)}{j}", "contact end", acting(out)))
    for joint in _joints(context):
        yield joint.space(context)


def stopped_joints(context: Context) -> Iterator[Variant]:
    """The same of one sensor as a formula: where the residuals speak most for a stop, how much of the motion beyond it
    is lost, and what other sensors have of that.
    """
    rows = context.rows
    for joint in _joints(context):
        own = rows.unit[rows.observables.index(joint.name)]
        others = np.flatnonzero(joint.beside)
        names, kinds = tuple(rows.observables[k] for k in others), {rows.unit[k] for k in others}
        units = {"distance": own} | ({"shared": f"{kinds.pop()}/{own}"} if len(kinds) == 1 else {})
        for distance in context.grid("distance", (joint.likeliest(context),)):
            past = np.maximum(joint.way - distance, 0.0)
            stopped = Term.field("stopped", -joint.side * past[:, None] * joint.own)
            form, shape = f"{STOP_OF}{joint.name}, {_sign(joint.side)}", {"distance": distance}
            yield Variant(form, (stopped,), shape, units=units)
            if names:
                change = past[:, None, None] * np.eye(len(joint.own))[:, others]
                shared = Term.field("shared", change, names)
                yield Variant(f"{form}, felt", (stopped, shared), shape, units=units)


@dataclass(frozen=True)
class _Joint:
    """A sensor that follows a motion: which of the observables is its own (K,), which other sensors are beside it (K,),
    to which side it goes, how far it does (F,), in its unit, and how far at most.
    """

    name: str
    own: Floats
    beside: Floats
    side: float
    way: Floats
    top: float

    def space(self, context: Context) -> Space:
        """Stops anywhere on its way, which hold it back; each sensor beside it has what it may of that."""
        scale, out, felt = motion_scale(context), [], []
        measure = float(scale @ self.own)
        for level in _FINE:
            past = np.maximum(self.way - level * self.top, 0.0)[:, None]
            out.append(field(f"stop {level}", -self.side * past * self.own))
            felt += [
                field(f"{level} felt by {k}", past / measure * one * scale, 0.3)
                for k, one in enumerate(np.eye(len(self.own)) * self.beside)
            ]
        stop = one_way(Space(f"{STOP_OF}{self.name}, {_sign(self.side)}", "contact stop", acting(out)))
        return Space(stop.key, stop.spectrum, acting([*out, *felt]), along=stop.along)

    def likeliest(self, context: Context) -> float:
        """How far from where it is vented a stop takes most of the residuals away, in its unit."""
        against = -self.side * np.nan_to_num(context.residual) @ self.own

        def gain(distance: float) -> float:
            past = np.maximum(self.way - distance, 0.0)
            return float(past @ against) / max(float(np.linalg.norm(past)), 1e-300)

        return max((level * self.top for level in _FINE), key=gain)


def sensor_of(form: str) -> str:
    """Which sensor a form is about: `stop of elbow, +, felt` about `elbow`, whose name may have a comma in it."""
    return form.removesuffix(", felt").removeprefix(STOP_OF)[: -len(", +")]


def by_joint(context: Context, part: Part, name: str, *, strokes: bool = False) -> Sign:
    """What gives such a part away: its size against how far the joint has come, by the model, that sensor `name`
    follows; `strokes` tells apart from where it came last.
    """
    rows = context.rows
    k = rows.observables.index(name)
    group = None
    if strokes:
        way, before = at_events(context)[:, k], context.started
        came = way - np.where(before >= 0, way[before], 0.0)
        group = np.where(came[rows.event][rows.first] > 0, BELOW, ABOVE)
    return along_own(context, part, context.base[:, k], f"{name}, by the model", rows.unit[k], group)


def joints(context: Context) -> Ints:
    """Which of few sensors, beside the markers or without any, say how far something has moved, (n,). None where there
    is a single one: its motion is the body's.
    """
    rows = context.rows
    alone = np.flatnonzero(seen_alone(rows))
    if len(rows.unit) < 2 or len(alone) > FEW_OBSERVABLES:
        return alone[:0]
    return alone[[rows.unit[k] in LENGTHS for k in alone]]


def _joints(context: Context) -> Iterator[_Joint]:
    """The motions of joints to either side."""
    rows, scale = context.rows, motion_scale(context)
    alone = seen_alone(rows)
    most = np.abs(context.displacement / scale).max()
    for k in joints(context):
        own = np.eye(len(alone))[k]
        for side in (1.0, -1.0):
            way = side * context.displacement[:, k]
            top = float(context.yardstick(f"farthest {side:+.0f} of {rows.observables[k]}", way.max))
            if context.shows(top / scale[k] >= _FAR * most):
                yield _Joint(rows.observables[k], own, alone * (1 - own), side, way, top)


def _sign(side: float) -> str:
    return "+" if side > 0 else "-"


def _main_ways(moved: Floats) -> Floats:
    """The two ways that rows (F, K) go most, or one where they hardly go another, (n, K)."""
    _, size, ways = svd(moved[:: max(1, len(moved) // 400)])
    main = ways[:2][size[:2] >= 0.2 * size[0]]
    most = np.take_along_axis(main, np.abs(main).argmax(axis=1)[:, None], axis=1)
    return main * np.sign(most)  # whichever way they were found
