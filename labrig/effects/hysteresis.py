"""Hysteresis: the surface lags behind its pressures, however slowly they change."""

from collections.abc import Iterator
from itertools import pairwise

import numpy as np

from labrig.arrays import Floats
from labrig.effects._context import Context
from labrig.effects._effect import Effect, Parameter, Term, Variant
from labrig.effects._family import Feature, Space, acting, ball_of, field, pressure
from labrig.effects._memory import LENGTHS, fading, memory, trail
from labrig.effects._sign import Part, Sign, by_chamber
from labrig.effects._skin import body_behind, body_settled, by_itself, by_place, felt, per_sensor, play_behind

WIDTHS = (0.05, 0.1, 0.2, 0.35, 0.5)
WIDER = 3.0
CHAIN = (0.01, 0.02, 0.04)
LINKS, STEP = 5, 2.0
"""A spectrum of widths (Prandtl-Ishlinskii): so many, each so many times the one before."""

PARTS = (-1.0, 0.33, 0.67, 2.0)
"""Bounds of low, medium and high loads, shares of the range, where loops may differ."""


class Hysteresis(Effect):
    name = "hysteresis"
    meaning = (
        "The elastomer's response depends on where the pressure came from, not on how fast:\n"
        "a set-point reached from above lies higher than the same one reached from below."
    )
    acts_on = "pressure"
    unit_in_names = "%"
    remembers = True
    parameters = (
        Parameter(
            "weight", "1", 0.0, 5.0, "chamber", "share of the response that goes through the play", turns=True
        ),
        Parameter(
            "spectrum", "1", 0.0, 5.0, meaning="the same for each width of a chain of plays", turns=True
        ),
        Parameter(
            "wide", "1", 0.0, 5.0, meaning="the same for a second play, three times as wide", turns=True
        ),
        Parameter(
            "pattern", "observable", 0.0, meaning="the same for each observable, at full range", turns=True
        ),
        Parameter("width", "1", 0.0, 1.0, meaning="half width of the play, fraction of the range"),
        Parameter(
            "length", "1", 0.0, 10.0, meaning="way on which what was before fades, fraction of the range"
        ),
    )
    reference = "M. A. Krasnosel'skii, A. V. Pokrovskii, Systems with Hysteresis, Springer 1989 (play, P-I)"
    signature = "up and down strokes apart, by an amount that grows with the stroke and then saturates"
    experiment = "the same set-points approached from above and from below, small and large strokes"
    blurred_by = frozenset({"one side", "one speed", "one stroke"})

    def variants(self, context: Context) -> Iterator[Variant]:
        if not context.shows(context.moves):
            return
        u, chambers = context.rows.actuation, context.rows.chambers
        for r in context.grid("width", WIDTHS):
            lag = context.play(r) - u
            shape = {"width": r}
            yield Variant("play", (Term.common("weight", lag),), shape)
            second = context.play(WIDER * r) - u
            yield Variant("two plays", (Term.common("weight", lag), Term.common("wide", second)), shape)
            if len(chambers) > 1:
                yield Variant("play per chamber", (Term.per_chamber("weight", lag, chambers),), shape)
            for term in per_sensor(context, "weight", lag):
                yield Variant("play per sensor", (term,), shape)
            if len(chambers) <= 2:
                yield Variant("pattern", (Term.pattern("pattern", lag / context.span),), shape)

        for length in context.grid("length", LENGTHS):
            for form, loading in (("fading", False), ("fading on the way up", True)):
                lag = trail(context, length, loading=loading) * context.span
                yield Variant(form, (Term.common("weight", lag),), {"length": length})
        for r in context.grid("width", CHAIN):
            chain = [r * STEP**i for i in range(LINKS)]
            lags = np.stack([context.play(w) - u for w in chain], axis=2)
            labels = tuple(f"{w:.3g}" for w in chain)
            yield Variant("spectrum", (Term("spectrum", "pressure", lags, labels),), {"width": r})

    def family(self, context: Context) -> Iterator[Space]:
        """Play operators (Prandtl-Ishlinskii) of pressure and wall deflection, narrow to wide, with a static part.

        Also plays of a part of the range, and of all chambers together; and what fades as a chamber moves on.
        """
        if not context.moves:
            return
        u, span = context.rows.actuation, context.span
        columns = [*_plays(context), *_partial(context), *_settled(context)]
        columns += memory(context) + fading(context)
        yield (play := Space("play", "hysteresis", acting(columns), 0.8))
        yield from by_itself(context, play)
        lags = {f"play {r}": (context.play(r) - u) / span for r in (0.06, 0.12, 0.25, 0.45)}
        if forces := felt(context, lags):
            yield Space("as sensors feel it", "hysteresis felt", acting(forces))
        behind = [(f"skin {w}", play_behind(context, w)) for w in (0.1, 0.25, 0.5, 1.0)]
        skin = [field(name, values) for name, values in behind]
        body = [field(f"body {w}", body_behind(context, w), 0.5) for w in (0.06, 0.15, 0.35, 0.7)]
        yield Space("in the skin", "hysteresis skin", acting(skin + body))
        places = [f for name, values in behind for f in by_place(context, name, values)]
        if places:
            yield Space("in the skin, by place", "hysteresis skin by place", acting(skin + places))
        if len(context.rows.chambers) < 2:
            return  # what a single chamber moves follows that chamber's own loop
        body += [field(f"body settled {p}", body_settled(context, p), 0.3) for p in (0.5, 1.0, 2.0)]
        yield Space("of the whole body", "hysteresis body", acting(body))

    def covariate(self, context: Context) -> tuple[str, str, Floats]:
        return ("mean pressure", context.rows.actuation_unit, context.rows.actuation.mean(axis=1))

    def sign(self, context: Context, part: Part) -> Sign:
        return by_chamber(context, part, strokes=True)


def _plays(context: Context) -> list[Feature]:
    """Loops of each chamber, of its pressure and of what that moves."""
    x, u, span = context.rows.fraction, context.rows.actuation, context.span
    out = []
    for r in (0.03, 0.06, 0.12, 0.25, 0.45, 0.7):
        lag = (context.play(r) - u) / span
        out += [pressure(f"play {r}", lag), pressure(f"play {r} tilted", lag * (2 * x - 1), 0.25)]
        if not context.linear:
            wall = context.played(r, context.event_deflection) - context.deflection
            out.append(pressure(f"wall play {r}", wall / context.deflection_slope, 0.7))
    return out


def _partial(context: Context) -> list[Feature]:
    """Loops of low, medium and high loads by themselves (a Preisach plane), and of all chambers together."""
    events = (context.rows.event_actuation - context.vented) / context.span
    event = context.rows.event
    out = []
    for low, high in pairwise(PARTS):
        part = np.clip(events, low, high)
        name = f"of {low:.2f} to {high:.2f}"
        out += [
            pressure(f"play {r} {name}", context.played(r, part, np.clip(0.0, low, high)) - part[event], 0.5)
            for r in (0.06, 0.2)
        ]
    if len(context.rows.chambers) > 1:
        out += [
            pressure(f"play {r} of all", ball_of(context, events, r) - events[event], 0.5)
            for r in (0.06, 0.15, 0.35)
        ]
    return out


def _settled(context: Context) -> list[Feature]:
    """What a loop has of the set-point itself, since a base is fitted in the middle of it."""
    x, d, slope = context.rows.fraction, context.deflection, context.deflection_slope
    out = [pressure("settled", x, 0.1), pressure("settled2", x * x, 0.1), pressure("settled3", x**3, 0.1)]
    if not context.linear:
        out += [pressure("settled wall", d / slope, 0.1), pressure("settled wall2", d * d / slope, 0.1)]
    return out
