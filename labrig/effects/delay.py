"""Delay: what is seen lags behind what was commanded."""

from collections.abc import Collection, Iterator

import numpy as np

from labrig.arrays import Floats
from labrig.effects._context import MOMENTS, Context
from labrig.effects._effect import Effect, Parameter, Term, Variant
from labrig.effects._family import Space, acting, lags, pressure
from labrig.effects._sign import Part, Sign, of_step
from labrig.effects._skin import lag_behind

TAUS_S = (0.3, 0.5, 0.8, 1.2, 2.0, 3.0, 5.0)


class Delay(Effect):
    name = "delay"
    meaning = (
        "Actuation or sensor lags: just after a change the old shape is still (partly) there,\n"
        "and all of it is gone once a few time constants have passed."
    )
    acts_on = "pressure"
    parameters = (
        Parameter("share", "1", 0.4, 2.5, "chamber", "share of the change that lags; 1 is a plain lag"),
        Parameter("tau_s", "s", 0.05, 30.0, meaning="time constant of the lag"),
    )
    reference = "K. Ogata, Modern Control Engineering, 5th ed. 2010, ch. 5 (first-order systems)"
    signature = "error proportional to the last change of pressure, fading fast within the hold"
    experiment = "one large step up and one down, recorded from the moment of the command"

    def variants(self, context: Context) -> Iterator[Variant]:
        if not context.has_time or not context.shows(context.moves):
            return
        u, chambers = context.rows.actuation, context.rows.chambers
        for tau in context.grid("tau_s", TAUS_S):
            lag = context.relaxed(tau) - u
            yield Variant("first order", (Term.common("share", lag),), {"tau_s": tau})
            if len(chambers) > 1:
                yield Variant("per chamber", (Term.per_chamber("share", lag, chambers),), {"tau_s": tau})
            if not context.linear or len(chambers) > 1:
                seen = Term.field("share", lag_behind(context, tau))
                yield Variant("first order, of the sensor", (seen,), {"tau_s": tau})

    def family(self, context: Context) -> Iterator[Space]:
        """First- and second-order lags of up to a few seconds, and dead times."""
        if not context.has_time or not context.moves:
            return
        out = lags(context, (0.15, 0.3, 0.6, 1.2, 2.4), 0.0)
        gap = (context.previous[context.rows.event] - context.rows.actuation) / context.span
        for tau in (0.3, 0.6, 1.2, 2.4):
            behind = (context.relaxed(tau) - context.rows.actuation) / context.span
            out.append(pressure(f"venting {tau}", np.maximum(behind, 0.0), 0.3))
            q = context.elapsed_s[:, None] / tau
            out += [
                pressure(f"second order {tau}", gap * (1 + q) * np.exp(-q), 0.5),
                pressure(f"dead {tau}", gap * (q < 1), 0.3),
            ]
        yield Space("late", "delay", acting(out), 0.8)

    def covariate(self, context: Context) -> tuple[str, str, Floats]:
        return ("time in hold", "s", context.elapsed_s)

    def sign(self, context: Context, part: Part) -> Sign:
        return of_step(context, part)

    def lacks(self, context: Context, form: str, parameters: Collection[str]) -> str:
        return "" if context.has_time else MOMENTS
