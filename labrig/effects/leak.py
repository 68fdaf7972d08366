"""Leak: a chamber loses pressure within the hold."""

from collections.abc import Collection, Iterator

import numpy as np

from labrig.effects._context import Context
from labrig.effects._effect import Effect, Parameter, Term, Variant
from labrig.effects._family import Space, acting, pressure
from labrig.effects._rows import Floats

TAUS_S = (2.0, 5.0, 10.0, 20.0, 40.0, 80.0, 200.0, 1000.0, 5000.0, 25000.0)


class Leak(Effect):
    name = "leak"
    meaning = (
        "Air escapes from a held chamber, the faster the higher its pressure;\n"
        "the next actuation fills it up again."
    )
    acts_on = "pressure"
    parameters = (
        Parameter("loss", "1", 0.4, 1.5, "chamber", "share of the pressure that escapes in the end"),
        Parameter("tau_s", "s", 0.1, 1e6, meaning="time constant of the escape"),
        Parameter("sensor", "1", 0.2, 1.8, meaning="share of the measured loss that reaches the surface"),
    )
    reference = "ISO 6358-1:2013 (flow through pneumatic components); linearised: dp/dt = -p / tau"
    signature = "error that grows with the time in hold against the load, in proportion to the pressure"
    experiment = "the same long hold at two pressures: a leak doubles with the pressure, a drift does not"

    def variants(self, context: Context) -> Iterator[Variant]:
        u, chambers = context.rows.actuation, context.rows.chambers
        t = context.elapsed_s[:, None]
        if not context.shows(np.any(t > 0) and np.ptp(t) > 0):
            return
        for tau in context.grid("tau_s", TAUS_S):
            lost = -u * -np.expm1(-t / tau)
            yield Variant("exponential", (Term.common("loss", lost),), {"tau_s": tau})
            if len(chambers) > 1:
                yield Variant("per chamber", (Term.per_chamber("loss", lost, chambers),), {"tau_s": tau})
        fall = context.measured_fall
        if fall is not None:
            yield Variant("as measured", (Term.common("sensor", fall),))

    def family(self, context: Context) -> Iterator[Space]:
        """What is lost since the actuation, fast or slowly, in proportion to the pressure, its square, or its root."""
        x, t = context.rows.fraction, context.elapsed_s[:, None]
        if np.ptp(t) <= 0:
            return
        out = []
        for tau in (2.0, 6.0, 20.0, 60.0, 200.0, 1000.0, 10000.0):
            lost = -np.expm1(-t / tau)
            out += [
                pressure(f"lost {tau}", -x * lost),
                pressure(f"lost {tau} square", -x * x * lost, 0.3),
                pressure(f"lost {tau} root", -np.sqrt(np.clip(x, 0, None)) * lost, 0.3),
            ]
        yield Space("lost", "leak", acting(out), 0.4)

    def covariate(self, context: Context) -> tuple[str, str, Floats]:
        return ("time in hold", "s", context.elapsed_s)

    def lacks(self, context: Context, form: str, parameters: Collection[str]) -> str:
        return "measured pressures" if form == "as measured" and context.measured_error is None else ""
