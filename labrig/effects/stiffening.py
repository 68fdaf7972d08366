"""Stiffening: the compliance changes with pressure."""

from collections.abc import Iterator

import numpy as np

from labrig.arrays import Floats
from labrig.effects._context import FEW_OBSERVABLES, Context
from labrig.effects._effect import Effect, Parameter, Term, Variant
from labrig.effects._family import Space, acting, field, pressure
from labrig.effects._fields import travel_of_all
from labrig.effects._inside import inside
from labrig.effects._own_pressure import any_curve
from labrig.effects._sign import Part, Sign, by_chamber

_LEAST = 1e-3


class Stiffening(Effect):
    name = "stiffening"
    meaning = (
        "The wall gets stiffer (or softer) as it stretches: each further kPa moves the surface\n"
        "less (or more) than the one before, whatever the direction and the moment."
    )
    acts_on = "mechanics"
    unit_in_names = "%"
    parameters = (
        Parameter(
            "quadratic", "1", -3.0, 3.0, "chamber", "change of compliance at full pressure; < 0 stiffens"
        ),
        Parameter("cubic", "1", -6.0, 6.0, "chamber", "the same, growing with the square of the pressure"),
        Parameter("pattern", "observable", meaning="change at full pressure, for each observable"),
        Parameter("strain", "1", -2.0, 4.0, meaning="surplus of the simulator's stiffening by strain"),
    )
    reference = (
        "A. N. Gent, Rubber Chem. Technol. 69 (1996) 59-61; R. W. Ogden, Proc. R. Soc. A 326 (1972) 565"
    )
    signature = "error curved in a chamber's own pressure; no loop between approach from above and below"
    experiment = "one chamber swept up and down in small steps over its whole range"
    blurred_by = frozenset({"one moment"})

    def variants(self, context: Context) -> Iterator[Variant]:
        if not context.shows(context.moves):
            return
        yield from inside(context, strain="stiffening_")
        u = context.rows.actuation
        x = context.rows.fraction
        chambers = context.rows.chambers
        second, third = u * x, u * x * x
        yield Variant("quadratic", (Term.common("quadratic", second),))
        yield Variant("cubic", (Term.common("cubic", third),))
        yield Variant("quadratic and cubic", (Term.common("quadratic", second), Term.common("cubic", third)))
        if len(chambers) > 1:
            yield Variant("per chamber", (Term.per_chamber("quadratic", second, chambers),))
            yield Variant(
                "per chamber, cubic",
                (Term.per_chamber("quadratic", second, chambers), Term.per_chamber("cubic", third, chambers)),
            )
        if len(context.rows.unit) <= FEW_OBSERVABLES or context.base_kind == "static":
            yield Variant("pattern", (Term.pattern("pattern", x**2),))
            yield Variant("cubic pattern", (Term.pattern("pattern", np.hstack([x**2, x**3])),))

    def family(self, context: Context) -> Iterator[Space]:
        """Powers of a chamber's own pressure, of its wall's deflection, or of the travel."""
        if not context.moves:
            return
        x, d, slope = context.rows.fraction, context.deflection, context.deflection_slope
        far = float(context.yardstick("farthest travel", context.travel.max))
        out = [
            pressure("square", x**2),
            pressure("cube", x**3),
            pressure("wall square", d**2 / slope),
            pressure("wall cube", d**3 / slope),
            pressure("power", _log(x), 0.5),
            pressure("power, twice", _log(x) * np.log(np.clip(np.abs(x), _LEAST, None)), 0.15),
            pressure("wall power", _log(d) / slope, 0.5),
            pressure("wall fifth", d**5 / slope, 0.5),
        ]
        travelling, together = (
            [
                field(f"travel {n}", context.displacement * share**n, w)
                for n, w in ((1, 0.5), (2, 0.5), (4, 0.25))
            ]
            for share in (context.travel / (far or 1.0), travel_of_all(context))
        )
        yield Space("compliance", "stiffening", acting([*out, *travelling]), 0.8)
        yield Space("as it travels", "stiffening by travel", acting(travelling))
        yield Space("as all travel", "stiffening by all travel", acting(together))
        yield any_curve(context)

    def sign(self, context: Context, part: Part) -> Sign:
        return by_chamber(context, part, named=True)


def _log(x: Floats) -> Floats:
    """x log |x|: how x changes with the power that it is raised to."""
    return x * np.log(np.clip(np.abs(x), _LEAST, None))
