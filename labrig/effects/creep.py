"""Creep: the surface keeps moving under constant pressure, and remembers."""

from collections.abc import Collection, Iterator, Sequence
from itertools import product

import numpy as np

from labrig.arrays import Floats
from labrig.effects._context import MOMENTS, Context
from labrig.effects._effect import Effect, Parameter, Term, Variant
from labrig.effects._family import Space, acting, field, lags, pressure
from labrig.effects._sign import Part, Sign, along_own, by_chamber, follows, of_step, shows, varies
from labrig.effects._skin import by_itself, by_place, by_sensor, lag_behind, per_sensor

TAUS_S = (3.0, 10.0, 30.0, 100.0, 300.0, 1000.0)
ELEMENTS = {"Kelvin-Voigt": 1, "two elements": 2, "log-time": 3}
HOUR_S = 3600.0
DECADE = 10.0
CHAIN_S = (0.5, 1.5, 5.0)
LINKS, STEP = 5, 4.0
"""A spectrum of retardation times: so many, each so many times the one before."""
SETTLE_S = 3.0
LONG_HOLD = 5.0
"""Times the usual settling: from so long a hold on, creep shows within it."""
SHORTEST_S = 3.0
"""A lag behind the settled shape that is shorter than this is a delay."""


class Creep(Effect):
    name = "creep"
    meaning = (
        "The elastomer goes on yielding under a held pressure, fast at first and ever slower,\n"
        "and comes back as slowly after release."
    )
    acts_on = "mechanics"
    unit_in_names = "s"
    remembers = True
    parameters = (
        Parameter("amplitude", "1", 0.0, 0.6, "chamber", "delayed share of the response", turns=True),
        Parameter(
            "spectrum", "1", 0.0, 0.6, meaning="the same for each retardation time of a chain", turns=True
        ),
        Parameter(
            "pattern",
            "observable",
            0.0,
            meaning="delayed response at full pressure, each observable",
            turns=True,
        ),
        Parameter(
            "tau_s", "s", 0.3, 1e5, meaning="retardation time; of a chain the shortest, a decade apart"
        ),
        Parameter(
            "flow", "1/h", 0.0, meaning="what flows in an hour and never comes back, share of the response"
        ),
        Parameter("known", "1", 0.0, 1.0, meaning="share of the delayed response that the base already has"),
    )
    reference = (
        "W. N. Findley, J. S. Lai, K. Onaran, Creep and Relaxation of Nonlinear Viscoelastic Materials, 1976"
    )
    signature = "error that grows with the time in hold towards the load, and fades after release"
    experiment = "hold 3, 10, 60, 300 s at one pressure, release, and watch the recovery"
    needs = "the times of the rows"
    blurred_by = frozenset({"one speed", "one stroke"})

    def variants(self, context: Context) -> Iterator[Variant]:
        if not context.has_time or not context.shows(context.moves or context.has_holds):
            return
        u, chambers = context.rows.actuation, context.rows.chambers
        duration = float(np.nanmax(context.elapsed_s) + np.ptp(context.rows.event_time_s))
        flow = context.integrated() / HOUR_S
        for (name, n), tau in product(ELEMENTS.items(), context.grid("tau_s", TAUS_S)):
            if not context.shows(tau <= duration):
                continue
            chain = [tau * DECADE**i for i in range(n)]
            strain = np.mean([context.relaxed(t) for t in chain], axis=0)
            settled = float(np.mean([-np.expm1(-SETTLE_S / t) for t in chain]))
            for known in context.grid("known", (0.0, settled, 1.0)):
                if not context.shows(known < 1.0 or tau >= SHORTEST_S):
                    continue
                change = strain - known * u
                shape = {"tau_s": tau, "known": known}
                delayed = Term.common("amplitude", change)
                yield Variant(name, (delayed,), shape)
                if context.shows(n == 1 and duration > 0):
                    yield Variant("Burgers", (delayed, Term.common("flow", flow)), shape)
                if context.shows(not context.linear) and n != 2:
                    inside = np.mean([context.strained(t) for t in chain], axis=0)
                    inside = inside - known * context.deflection * context.span / context.deflection_slope
                    yield Variant(f"{name} of the wall", (Term.common("amplitude", inside),), shape)
                    term = Term.per_chamber("amplitude", inside, chambers)
                    yield Variant(f"{name} of the wall per chamber", (term,), shape)
                if len(chambers) > 1 and n != 2:
                    yield Variant(
                        f"{name} per chamber", (Term.per_chamber("amplitude", change, chambers),), shape
                    )
                for each in per_sensor(context, "amplitude", change):
                    yield Variant(f"{name} per sensor", (each,), shape)
                if len(chambers) <= 2:
                    yield Variant(f"{name} pattern", (Term.pattern("pattern", change / context.span),), shape)

        for tau, known in product(context.grid("tau_s", CHAIN_S), context.grid("known", (0.0, 1.0))):
            if context.shows(tau <= duration):
                chain = [tau * STEP**i for i in range(LINKS)]
                change = np.stack([context.relaxed(t) - known * u for t in chain], axis=2)
                labels = tuple(f"{t:.3g} s" for t in chain)
                shape = {"tau_s": tau, "known": known}
                yield Variant("spectrum", (Term("spectrum", "pressure", change, labels),), shape)

    def family(self, context: Context) -> Iterator[Space]:
        """First-order lags of 2 s to 5000 s behind the pressure, its square, or the wall; and settled strain."""
        if not context.has_time or not (context.moves or context.has_holds):
            return
        x = context.rows.fraction
        duration = float(np.nanmax(context.elapsed_s) + np.ptp(context.rows.event_time_s))
        every = (2.0, 5.0, 15.0, 50.0, 150.0, 500.0, 1500.0, 5000.0)
        taus = tuple(t for t in every if context.shows(t <= 1.5 * duration))
        out = lags(context, taus, 3.0)
        out += [pressure("settled", x, 0.1), pressure("settled2", x * x, 0.02)]
        if context.shows(duration > 0):
            likely = 0.3 * (HOUR_S / max(duration, 1.0)) ** 2  # over the whole run
            out.append(pressure("flow", context.integrated() / HOUR_S / context.span, likely))
        square = context.rows.share(context.rows.event_actuation) ** 2
        for tau in (5.0, 50.0, 500.0):
            if tau in taus:
                out.append(pressure(f"square {tau}", context.lagged(tau, square, 0.0) - x * x, 0.3))
        if not context.linear:
            out.append(pressure("settled wall", context.deflection / context.deflection_slope, 0.05))
        yield (retarded := Space("retarded", "creep", acting(out), 0.8))
        yield from by_itself(context, retarded)
        lagging = [(f"skin {tau}", lag_behind(context, tau)) for tau in taus[1:]]
        skin = [field(name, values) for name, values in lagging]
        yield Space("in the skin", "creep skin", acting(skin))
        places = [f for name, values in lagging for f in by_place(context, name, values)]
        places += by_sensor(context, [(n, values + context.displacement) for n, values in lagging])
        if places:
            yield Space("in the skin, by place", "creep skin by place", acting(skin + places))

    def covariate(self, context: Context) -> tuple[str, str, Floats]:
        return ("time in hold", "s", context.elapsed_s)

    def sign(self, context: Context, part: Part) -> Sign:
        """Its growth in the time in hold, where holds are long; else against what is left of the pressures before."""
        time = context.elapsed_s
        if time.max() > LONG_HOLD * max(float(time.min()), SETTLE_S):
            held = of_step(context, part, growth=True)
            if shows(held):
                return held
        if "known" not in part.shape:  # a family's weights, which have no time of their own
            held = along_own(context, part, time, "time in hold", "s")
            if varies(held) and shows(held):
                return held
            tried = [_remembered(context, part, [tau], known) for tau in TAUS_S for known in (0.0, 1.0)]
            return max(tried, key=follows)
        count = next((n for name, n in ELEMENTS.items() if part.form.startswith(name)), LINKS)
        step = STEP if part.form == "spectrum" else DECADE
        return _remembered(
            context, part, [part.shape["tau_s"] * step**i for i in range(count)], part.shape["known"]
        )

    def lacks(self, context: Context, form: str, parameters: Collection[str]) -> str:
        return "" if context.has_time else MOMENTS


def _remembered(context: Context, part: Part, taus_s: Sequence[float], known: float) -> Sign:
    """Creep against what is left of the pressures before: their means over `taus_s`, without what is `known` of those
    of now.
    """
    slow, now = np.mean([context.relaxed(t) for t in taus_s], axis=0), context.rows.actuation
    if "of the wall" in part.form:
        slow = np.mean([context.strained(t) for t in taus_s], axis=0)
        now = context.deflection * context.span / context.deflection_slope
    what = "remembered pressure" + (f" − {100 * known:.0f} % of that now" if known else "")
    return by_chamber(context, part, slow - known * now, what, context.rows.actuation_unit, named=True)
