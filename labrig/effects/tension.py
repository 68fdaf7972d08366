"""Tension: the pre-stretch of the top membrane is not the model's."""

from collections.abc import Iterator

from labrig.effects._context import Context
from labrig.effects._effect import Effect, Parameter, Term, Variant
from labrig.effects._inside import inside
from labrig.effects._rows import Floats


class Tension(Effect):
    name = "tension"
    meaning = (
        "The membrane was mounted tighter (or slacker): it holds the surface back while it moves\n"
        "little, and matters less the further the surface has come out."
    )
    acts_on = "mechanics"
    parameters = (
        Parameter(
            "pre_stretch",
            "1",
            -1.5,
            1.5,
            meaning="pressure given back at full deflection, of the range",
        ),
        Parameter("fading", "1", -1.5, 1.5, meaning="change of the displacement near rest; < 0: tighter"),
        Parameter("prestretch", "1", -0.2, 0.2, meaning="surplus of the simulator's pre-stretch"),
        Parameter(
            "fades_at", "1", 0.0, 1.0, meaning="travel at which half of it is left, of the largest travel"
        ),
    )
    reference = "W. B. Fichter, Large deflections of uniformly loaded circular membranes, NASA TP-3658, 1997"
    signature = (
        "error in proportion to how far the surface has come out, not to the pressure, for every chamber"
    )
    experiment = "all chambers together in small steps from zero"

    def variants(self, context: Context) -> Iterator[Variant]:
        far = float(context.travel.max())
        if not context.moves or far <= 0:
            return
        yield from inside(context, prestretch="prestretch_")
        # a tension T holds back a deflection d with a pressure in proportion to T d (Laplace's law at
        # small slopes); where d is proportional to the pressure this is a gain of the regulator
        back = context.span * context.deflection
        if not context.linear:
            yield Variant("restoring", (Term.common("pre_stretch", back),))
        for share in context.grid("fades_at", (0.1, 0.2, 0.4)):
            held = context.displacement / (1 + (context.travel / (share * far)) ** 2)
            yield Variant("fading", (Term.field("fading", held),), {"fades_at": share})

    def covariate(self, context: Context) -> tuple[str, str, Floats]:
        return ("mean travel", context.rows.unit[0], context.travel.mean(axis=1))
