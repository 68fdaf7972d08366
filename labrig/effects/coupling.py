"""Coupling: neighbouring chambers act on each other."""

from collections.abc import Iterator
from itertools import combinations

import numpy as np

from labrig.arrays import Floats
from labrig.effects._context import FEW_OBSERVABLES, Context
from labrig.effects._effect import Effect, Parameter, Term, Variant
from labrig.effects._family import Space, acting, field, pressure
from labrig.effects._fields import overlap
from labrig.effects._obstacles import by_marker, to_rows
from labrig.effects._reached import nearest, neighbours, reached
from labrig.effects._sign import Part, Sign, by_chamber
from labrig.effects._together import together

_PAIRS = 12
"""Most pairs of chambers that are asked one by one how one turns the other; of more, all others together."""
_OPEN = 0.05
"""Share of the range from which a chamber is open: a grid."""
_EVEN = 0.1
"""Difference of two pressures, share of the range, up to which what goes between them goes with it: a grid."""
_THIRD = 3
"""Of how many neighbours two act at once: a grid, no limit of a verdict."""


class Coupling(Effect):
    name = "coupling"
    meaning = (
        "Chambers act on each other (they press together, share a wall, draw on one supply):\n"
        "together they move the surface by another amount than the sum of what each should do."
    )
    acts_on = "mechanics"
    unit_in_names = "%"
    parameters = (
        Parameter("all", "1", -3.0, 3.0, meaning="change of a chamber's effect with every other one full"),
        Parameter("load", "1", -3.0, 3.0, meaning="change of every chamber's effect with all of them full"),
        Parameter(
            "neighbours", "1", -3.0, 3.0, meaning="the same, by how much two chambers' regions overlap"
        ),
        Parameter("chamber", "1", -3.0, 3.0, "chamber", "the same for each chamber as the one that suffers"),
        Parameter("pair", "1", -6.0, 6.0, meaning="the same for each pair, both ways"),
        Parameter("pattern", "observable", meaning="change with both at full pressure, for each observable"),
        Parameter(
            "reaches", "1", -2.0, 2.0, meaning="share of the neighbours' pressure that a chamber gets, too"
        ),
        Parameter(
            "reaches_chamber", "1", -2.0, 2.0, "chamber", "the same for each chamber as the one that gets it"
        ),
        Parameter("reaches_pair", "1", -2.0, 2.0, meaning="the same for each pair, both ways"),
        Parameter(
            "exchanged",
            "1",
            -2.0,
            2.0,
            meaning="share of the difference to its neighbours that is evened out",
        ),
        Parameter("exchanged_pair", "1", -2.0, 2.0, meaning="the same for each pair"),
    )
    reference = (
        "P. Polygerinos et al., Soft robotics: fluid-driven devices, Adv. Eng. Mater. 19 (2017) 1700016"
    )
    signature = (
        "error that goes with the neighbours' pressures: by the product with its own, or whatever that is"
    )
    experiment = "chambers one at a time, then in pairs, at the same pressures"
    needs = "two chambers or more"

    def variants(self, context: Context) -> Iterator[Variant]:
        C = len(context.rows.chambers)
        if C < 2 or not context.shows(context.moves):
            return
        u, x = context.rows.actuation, context.rows.fraction
        near = overlap(context)
        partner = {"product": x, "saturating": x / (0.3 + x)}
        for form, other in partner.items():
            yield Variant(f"{form}, all", (Term.common("all", u * (other @ (1 - np.eye(C))) / (C - 1)),))
            yield Variant(f"{form}, neighbours", (Term.common("neighbours", u * (other @ near)),))
        yield Variant("total load", (Term.common("load", u * x.mean(axis=1, keepdims=True)),))
        both = np.sqrt(np.clip(x[:, :, None] * x[:, None, :], 0, None))
        mutual = context.span * (both * near).sum(axis=2)
        yield Variant("square root, neighbours", (Term.common("neighbours", mutual),))
        yield Variant("per chamber", (Term.per_chamber("chamber", u * (x @ near), context.rows.chambers),))
        pairs = neighbour_pairs(near)
        if pairs and context.shows(context.rows.n_captures > 1.5 * len(pairs)):
            for form, other in partner.items():
                yield Variant(f"{form}, pairs", (self._pairs(context, pairs, other),))
            few = (
                len(pairs) <= 3 or len(context.rows.unit) <= FEW_OBSERVABLES or context.base_kind == "static"
            )
            if few and len(pairs) <= 40:
                feature = np.stack([x[:, i] * x[:, j] for i, j in pairs], axis=1)
                yield Variant("pattern", (Term.pattern("pattern", feature),))
        yield from _crosstalk(context, near, pairs)

    @staticmethod
    def _pairs(context: Context, pairs: list[tuple[int, int]], other: Floats) -> Term:
        u = context.rows.actuation
        feature = np.zeros((*u.shape, len(pairs)))
        for q, (i, j) in enumerate(pairs):
            feature[:, i, q] = u[:, i] * other[:, j]
            feature[:, j, q] = u[:, j] * other[:, i]
        names = context.rows.chambers
        return Term("pair", "pressure", feature, tuple(f"{names[i]}-{names[j]}" for i, j in pairs))

    def family(self, context: Context) -> Iterator[Space]:
        """Products of a chamber's pressure with that of its neighbours, or of all chambers; linear or saturating.

        Also of each pair for itself, of three, and what two or three do together anywhere.
        """
        C = len(context.rows.chambers)
        if C < 2 or not context.moves:
            return
        x, near = context.rows.fraction, overlap(context)
        d, slope = context.deflection, context.deflection_slope
        sat, others = x / (0.3 + x), 1 - np.eye(C)
        both = np.sqrt(np.clip(x[:, :, None] * x[:, None], 0, None))
        root = np.sqrt(np.clip(d[:, :, None] * d[:, None], 0, None))
        out = [
            pressure("all", x * (x @ others) / (C - 1), 0.5),
            pressure("load", x * x.mean(axis=1, keepdims=True), 0.5),
            pressure("near", x * (x @ near)),
            pressure("near saturating", x * (sat @ near), 0.7),
            pressure("near root", (both * near).sum(axis=2), 0.5),
            pressure("wall near saturating", d * (np.tanh(1.5 * d) @ near) / slope, 0.7),
            pressure("wall near", d * (d @ near) / slope, 0.7),
            pressure("wall near bows", (root * (d[:, :, None] - d[:, None]) * near).sum(axis=2) / slope, 0.5),
        ]
        taken = x @ others / (C - 1)  # a supply gives no more than what the others leave
        out += [pressure(f"ceiling {t}", -np.maximum(x + 0.5 * taken - t, 0), 0.5) for t in (0.7, 0.9, 1.1)]
        for k, y in enumerate(nearest(near, x)[:3], start=1):  # each chamber by its k-th nearest neighbour
            out.append(pressure(f"neighbour {k}", x * y))
        yield Space("together", "coupling", acting(out), 0.6)
        yield from _pair_by_pair(context, near)
        yield from _reached(context, near)
        yield from _turned_along(context)
        yield from together(context, near)

    def covariate(self, context: Context) -> tuple[str, str, Floats]:
        x = context.rows.fraction
        near = overlap(context)
        return ("product of neighbouring pressures", "1", ((x @ near) * x).sum(axis=1) / len(near))

    def sign(self, context: Context, part: Part) -> Sign:
        x = context.rows.fraction
        product = x * (x @ overlap(context))
        return by_chamber(
            context, part, product, "pressure of the chamber x that of its neighbours", "of the range"
        )


def _pair_by_pair(context: Context, near: Floats) -> Iterator[Space]:
    """Each chamber by each other one for itself, and by two at once; as soon as it is open; and if it is the fuller."""
    x, out = context.rows.fraction, []
    others = neighbours(near, x)
    for k, y in enumerate(others, start=1):
        out += [
            pressure(f"by {k}", x * y),
            pressure(f"by {k} early", x * y / (0.3 + np.abs(y)), 0.5),
            pressure(f"by {k} late", x * np.maximum(y - 0.5, 0.0)),
        ]
    out += [
        pressure(f"by {i} and {j}", x * y * z)
        for (i, y), (j, z) in combinations(enumerate(others[:_THIRD], start=1), 2)
    ]
    yield Space("pair by pair", "coupling pairs", acting(out), 0.2)
    still = np.tanh(x / _OPEN)  # however full: an open valve, a wall that is off its seat
    opened = [pressure(f"by {k}", still * y) for k, y in enumerate(others, start=1)]
    opened += [pressure(f"by {k} load", x * y, 0.5) for k, y in enumerate(others, start=1)]
    yield Space("once open", "coupling once open", acting(opened), 0.2)
    more = [np.maximum(np.abs(x) - np.abs(y), 0.0) * np.tanh(np.abs(y) / _OPEN) for y in others]
    fuller = [pressure(f"by {k}", np.sign(x) * over) for k, over in enumerate(more, start=1)]
    fuller += [pressure(f"by {k} load", x * over) for k, over in enumerate(more, start=1)]
    yield Space("the fuller", "coupling the fuller", acting(fuller), 0.2)


def _reached(context: Context, near: Floats) -> Iterator[Space]:
    """What fills one chamber reaches another, whatever that one's own pressure is; or the two even out."""
    yield reached(context)
    x = context.rows.fraction
    others = neighbours(near, x)
    apart = [y - x for y in others]
    out = [pressure(f"to {k}", gap) for k, gap in enumerate(apart, start=1)]
    out += [
        pressure(f"to {k} early", gap / np.sqrt(_EVEN + np.abs(gap)), 0.5)
        for k, gap in enumerate(apart, start=1)
    ]
    yield Space("evened out", "coupling evened out", acting(out), 0.3)


def _crosstalk(context: Context, near: Floats, pairs: list[tuple[int, int]]) -> Iterator[Variant]:
    """Formulas of what reaches a chamber from its neighbours: all alike, for each chamber, for each pair."""
    u, x, names = context.rows.actuation, context.rows.fraction, context.rows.chambers
    reached = (x @ near.T) * context.span
    yield Variant("reached, neighbours", (Term.common("reaches", reached),))
    yield Variant("reached, per chamber", (Term.per_chamber("reaches_chamber", reached, names),))
    even = reached - x * near.sum(axis=1) * context.span
    yield Variant("evened out, neighbours", (Term.common("exchanged", even),))
    if not pairs or not context.shows(context.rows.n_captures > 1.5 * len(pairs)):
        return
    labels = tuple(f"{names[i]}-{names[j]}" for i, j in pairs)
    to, even = (np.zeros((*u.shape, len(pairs))) for _ in range(2))
    for q, pair in enumerate(pairs):
        for i, j in (pair, pair[::-1]):
            to[:, i, q], even[:, i, q] = x[:, j] * context.span[i], (x[:, j] - x[:, i]) * context.span[i]
    yield Variant("reached, pairs", (Term("reaches_pair", "pressure", to, labels),))
    yield Variant("evened out, pairs", (Term("exchanged_pair", "pressure", even, labels),))


def neighbour_pairs(near: Floats) -> list[tuple[int, int]]:
    """The pairs of chambers whose regions overlap at all."""
    return [(i, j) for i, j in combinations(range(len(near)), 2) if near[i, j] > 0 or near[j, i] > 0]


def _turned_along(context: Context) -> Iterator[Space]:
    """One chamber turns the ground on which others stand, and so the way that they move the markers."""
    rows = context.rows
    C = len(rows.chambers)
    if (rows.axis >= 0).sum() < 3 or not (rows.marker >= 0).any():
        return
    moved = [
        by_marker(context, context.jacobian[:, :, c] * (rows.actuation - context.vented)[:, c, None])
        for c in range(C)
    ]
    whole = sum(moved)
    out = []
    for i in range(C):
        parts = (
            [(f"{rows.chambers[j]} by {rows.chambers[i]}", moved[j]) for j in range(C) if j != i]
            if C * (C - 1) <= _PAIRS
            else [(f"all by {rows.chambers[i]}", whole - moved[i])]
        )
        turn = context.deflection[:, i, None, None]
        for name, part in parts:
            out += [
                field(f"{name} about {'xyz'[a]}", to_rows(context, turn * np.cross(np.eye(3)[a], part)))
                for a in range(3)
            ]
    yield Space("turned along", "coupling turned", acting(out))
