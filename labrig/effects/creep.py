"""Creep: the surface keeps moving under constant pressure, and remembers."""

from collections.abc import Iterator

import numpy as np

from labrig.effects._context import Context
from labrig.effects._effect import Effect, Parameter, Term, Variant
from labrig.effects._rows import Floats

TAUS_S = (3.0, 10.0, 30.0, 100.0, 300.0, 1000.0)
CHAINS = (
    (1.0, 10.0),
    (3.0, 30.0),
    (10.0, 100.0),
    (1.0, 10.0, 100.0),
    (3.0, 30.0, 300.0),
    (10.0, 100.0, 1000.0),
)
SETTLE_S = 3.0


class Creep(Effect):
    name = "creep"
    meaning = (
        "The elastomer goes on yielding under a held pressure, fast at first and ever slower,\n"
        "and comes back as slowly after release."
    )
    acts_on = "mechanics"
    parameters = (
        Parameter("amplitude", "1", 0.0, 1.0, "chamber", "delayed share of the response"),
        Parameter("pattern", "observable", meaning="delayed response at full pressure, for each observable"),
        Parameter(
            "tau_s", "s", 0.3, 1e5, meaning="retardation time; of a chain the shortest, a decade apart"
        ),
        Parameter("known", "1", 0.0, 1.0, meaning="share of the delayed response that the base already has"),
    )
    reference = (
        "W. N. Findley, J. S. Lai, K. Onaran, Creep and Relaxation of Nonlinear Viscoelastic Materials, 1976"
    )
    signature = "error that grows with the time in hold towards the load, and fades after release"
    experiment = "hold 3, 10, 60, 300 s at one pressure, release, and watch the recovery"

    def variants(self, context: Context) -> Iterator[Variant]:
        if not context.has_time or not (context.moves or context.has_holds):
            return
        u, chambers = context.rows.actuation, context.rows.chambers
        duration = float(np.nanmax(context.elapsed_s) + np.ptp(context.rows.event_time_s))
        chains = [(tau,) for tau in TAUS_S] + list(CHAINS)
        for chain in (c for c in chains if c[0] <= duration):
            name = {1: "Kelvin-Voigt", 2: "two elements", 3: "log-time"}[len(chain)]
            strain = sum(context.relaxed(tau) for tau in chain) / len(chain)
            settled = sum(1 - np.exp(-SETTLE_S / tau) for tau in chain) / len(chain)
            for known in (0.0, settled, 1.0):
                change = strain - known * u
                shape = {"tau_s": chain[0], "known": float(known)}
                yield Variant(name, (Term.common("amplitude", change),), shape)
                if len(chambers) > 1 and len(chain) != 2:
                    yield Variant(
                        f"{name} per chamber", (Term.per_chamber("amplitude", change, chambers),), shape
                    )
                if len(chambers) <= 2:
                    yield Variant(f"{name} pattern", (Term.pattern("pattern", change / context.span),), shape)

    def covariate(self, context: Context) -> tuple[str, str, Floats]:
        return ("time in hold", "s", context.elapsed_s)
