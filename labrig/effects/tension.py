"""Tension: the pre-stretch of the top membrane is not the model's."""

from collections.abc import Iterator

import numpy as np

from labrig.arrays import Floats
from labrig.effects._context import Context
from labrig.effects._effect import Effect, Parameter, Term, Variant
from labrig.effects._family import Space, acting, field, pressure
from labrig.effects._fields import travel_of_all
from labrig.effects._inside import inside
from labrig.effects._own_pressure import any_curve
from labrig.effects._sign import Part, Sign, by_chamber, by_marker


class Tension(Effect):
    name = "tension"
    meaning = (
        "The membrane was mounted tighter (or slacker): it holds the surface back while it moves\n"
        "little, and matters less the further the surface has come out."
    )
    acts_on = "mechanics"
    unit_in_names = "%"
    parameters = (
        Parameter(
            "pre_stretch",
            "1",
            -1.5,
            1.5,
            meaning="pressure given back at full deflection, of the range",
        ),
        Parameter("preload", "1", -1.5, 1.5, meaning="pressure given to the surface at rest, of the range"),
        Parameter("fading", "1", -1.5, 1.5, meaning="change of the displacement near rest; < 0: tighter"),
        Parameter(
            "held",
            "1",
            -1.5,
            0.9,
            meaning="share of the displacement that is held back, as by a spring beside",
        ),
        Parameter("prestretch", "1", -0.2, 0.2, meaning="surplus of the simulator's pre-stretch"),
        Parameter("half_at", "observable", 0.0, meaning="travel at which half of the fading is left"),
    )
    reference = "W. B. Fichter, Large deflections of uniformly loaded circular membranes, NASA TP-3658, 1997"
    signature = (
        "error in proportion to how far the surface has come out, not to the pressure, for every chamber"
    )
    experiment = "all chambers together in small steps from zero"
    blurred_by = frozenset({"one moment", "one side"})

    def variants(self, context: Context) -> Iterator[Variant]:
        far = float(context.travel.max())
        if not context.shows(context.moves and far > 0):
            return
        yield from inside(context, prestretch="prestretch_")
        # a tension T holds back a deflection d with a pressure in proportion to T d (Laplace's law at
        # small slopes); where d is proportional to the pressure this is a gain of the regulator
        back = context.span * context.deflection
        if context.shows(not context.linear):
            yield Variant("restoring", (Term.common("pre_stretch", back),))
            pulled = Term.common("preload", np.broadcast_to(context.span, back.shape))
            yield Variant("restoring, preloaded", (Term.common("pre_stretch", back), pulled))
            yield Variant("a spring beside", (Term.field("held", -context.displacement),))
        for half in context.grid("half_at", [share * far for share in (0.1, 0.2, 0.4)]):
            held = context.displacement / (1 + (context.travel / half) ** 2)
            yield Variant("fading", (Term.field("fading", held),), {"half_at": half})

    def family(self, context: Context) -> Iterator[Space]:
        """A restoring force on the walls: proportional to their travel, limited, or fading with it; with that of each
        place, or of all, since a membrane is as tight all over; or a share of all that moves.
        """
        far = float(context.yardstick("farthest travel", context.travel.max))
        if not context.moves or far <= 0:
            return
        out = []
        if not context.linear:
            out += [
                pressure("laplace", context.deflection),
                pressure("laplace wall", context.deflection / context.deflection_slope, 0.3),
            ]
            for r in (0.3, 0.7):
                out += [
                    pressure(f"string {r}", context.deflection / np.hypot(context.deflection, r), 0.5),
                    pressure(f"fabric {r}", context.deflection / (1 + (context.deflection / r) ** 2), 0.5),
                ]
        fading, together = (
            [
                field(f"fading {s}", context.displacement / (1 + (share / s) ** 2), 0.5)
                for s in (0.1, 0.2, 0.4)
            ]
            for share in (context.travel / far, travel_of_all(context))
        )
        yield Space("pre-stretch", "tension", acting([*out, *fading]), 0.95)
        if not context.linear:
            way = field("way", context.displacement)
            yield Space("a spring beside", "tension beside", acting([way]))
        yield Space("fading", "tension fading", acting(fading))
        yield Space("fading as all travel", "tension fading together", acting(together))
        yield any_curve(context)

    def covariate(self, context: Context) -> tuple[str, str, Floats]:
        return ("mean travel", context.rows.unit[0], context.travel.mean(axis=1))

    def sign(self, context: Context, part: Part) -> Sign:
        if part.form == "restoring":
            return by_chamber(
                context, part, 100 * context.deflection, "deflection of the chamber, of the largest", "%"
            )
        return by_marker(context, part)
