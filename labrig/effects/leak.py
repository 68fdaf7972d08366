"""Leak: a chamber loses pressure within the hold."""

from collections.abc import Collection, Iterator

import numpy as np

from labrig.arrays import Floats
from labrig.effects._closed_volume import FORM, GONE_S, closed_volumes, gone, gone_for_good
from labrig.effects._context import MOMENTS, Context
from labrig.effects._effect import Effect, Parameter, Term, Variant
from labrig.effects._family import Space, acting, field, one_way, pressure
from labrig.effects._fields import overlap
from labrig.effects._fitted import Fitted
from labrig.effects._leak_words import by_formula, by_weights
from labrig.effects._other_way import is_turned_round
from labrig.effects._sign import Part, Sign, of_field, pressures
from labrig.effects._skin import by_place

TAUS_S = (2.0, 5.0, 10.0, 20.0, 40.0, 80.0, 200.0, 1000.0, 5000.0, 25000.0)
REFILLED = ", slowly refilled"
"""dl/dt = p / tau_leak - l / tau: what is lost follows the pressure, with the time constant of what fills it up."""
LOST_S = (2.0, 6.0, 20.0, 60.0, 200.0, 1000.0, 10000.0)
"""Time constants of what is lost, s: a grid."""
RISES = "what rises during a hold"
_RISE_S = (0.2, 0.5, 1.0)
"""How fast a chamber fills that was empty: faster than a leak takes it."""
_HELD = 0.1
"""Of the range: in a chamber with less, a share of its pressure says nothing."""


class Leak(Effect):
    name = "leak"
    meaning = (
        "Air escapes from a held chamber, or into the next one, the faster the higher its pressure;\n"
        "the next actuation fills it up again, but for a volume that is closed (a syringe's)."
    )
    acts_on = "pressure"
    unit_in_names = "s"
    remembers = True
    parameters = (
        Parameter("loss", "1", 0.4, 1.5, "chamber", "share of the pressure that escapes in the end"),
        Parameter("tau_s", "s", 0.1, 1e6, meaning="time constant of the escape"),
        Parameter("chamber", "1", 0.0, per="chamber", meaning="the only one that leaks, counted from 0"),
        Parameter("sensor", "1", 0.2, 1.8, meaning="share of the measured loss that reaches the surface"),
    )
    reference = "ISO 6358-1:2013 (flow through pneumatic components); linearised: dp/dt = -p / tau"
    signature = "error that grows with the time in hold against the load, in proportion to the pressure"
    ruled_out_by = "close every leak: clamp or change the hoses, seal the chambers"
    experiment = "the same long hold at two pressures: a leak doubles with the pressure, a drift does not"
    needs = "rows at different times after a set-point, or pressures that never rest"
    blurred_by = frozenset({"one moment", "one speed", "one stroke"})

    def variants(self, context: Context) -> Iterator[Variant]:
        yield from self._within_holds(context)
        yield from closed_volumes(context, TAUS_S)
        if context.shows(_never_rests(context)):
            for tau in context.grid("tau_s", TAUS_S):
                yield from _forms(REFILLED, context.vented - context.relaxed(tau), tau, context)

    def _within_holds(self, context: Context) -> Iterator[Variant]:
        """What is lost since the actuation, which fills it up again."""
        u, t = context.rows.actuation, context.elapsed_s[:, None]
        if not context.shows(np.any(t > 0) and np.ptp(t) > 0):
            return
        x, span = context.rows.fraction, context.span
        for tau in context.grid("tau_s", TAUS_S):
            share = np.expm1(-t / tau)
            yield from _forms("", u * share, tau, context)
            # through an orifice at subcritical flow: by the root of the pressure, of the whole at the full one
            yield from _forms(", by the root", np.sqrt(np.clip(x, 0.0, None)) * span * share, tau, context)
        fall = context.measured_fall
        if fall is not None:
            yield Variant("as measured", (Term.common("sensor", fall),))

    def family(self, context: Context) -> Iterator[Space]:
        """Pressure lost since the actuation, fast or slowly, in proportion to the pressure, its square, or its root."""
        x, t = context.rows.fraction, context.elapsed_s[:, None]
        if _never_rests(context):
            root = np.sqrt(np.clip(context.rows.share(context.rows.event_actuation), 0.0, None))
            out = [
                pressure(f"lost {tau}", (context.vented - context.relaxed(tau)) / context.span)
                for tau in LOST_S
            ]
            out += [pressure(f"lost {tau} root", -context.lagged(tau, root), 0.3) for tau in LOST_S]
            out += [
                pressure(f"gone {tau} since it was empty", -gone(context, tau, True) / context.span, 0.3)
                for tau in GONE_S
            ]
            yield one_way(Space("refilled", "leak refilled", acting(out), 0.4))
        if for_good := acting([*gone_for_good(context)]):
            yield one_way(Space("gone for good", "leak for good", for_good, 0.4))
        if np.ptp(t) <= 0:
            return
        out = []
        for tau in LOST_S:
            lost = -np.expm1(-t / tau)
            out += [
                pressure(f"lost {tau}", -x * lost),
                pressure(f"lost {tau} square", -x * x * lost, 0.3),
                pressure(f"lost {tau} root", -np.sqrt(np.clip(x, 0, None)) * lost, 0.3),
            ]
            if context.has_time and 5 < tau < 500:  # into a pocket in the wall, which fills
                out.append(pressure(f"pocket {tau}", -context.gained(tau) / context.span, 0.3))
            if x.shape[1] > 1:  # through a wall that two chambers share, one gains what the other loses
                out.append(pressure(f"gained {tau}", (x @ overlap(context).T - x) * -lost, 0.3))
                out.append(pressure(f"gained by all {tau}", (x.mean(axis=1, keepdims=True) - x) * -lost, 0.1))
        lost = np.sum([f.values for f in out if f.name.startswith("lost")], axis=0)
        yield Space("lost", "leak", acting(out), 0.4, along=pressure("lost", lost))
        sinking = [
            (f"skin {tau}", context.displacement * np.expm1(-t / tau)) for tau in (6.0, 60.0, 600.0, 10000.0)
        ]
        skin = [field(name, values) for name, values in sinking]
        skin += [
            field(f"{name} load", values * x.mean(axis=1, keepdims=True), 0.5) for name, values in sinking
        ]
        sinks = field("sinks", np.sum([values for _, values in sinking], axis=0))
        yield Space("in the skin", "leak skin", acting(skin), along=sinks)
        if places := [f for name, values in sinking for f in by_place(context, name, values)]:
            placed = acting(skin[: len(sinking)] + places)
            yield Space("in the skin, by place", "leak skin by place", placed, along=sinks)

    def covariate(self, context: Context) -> tuple[str, str, Floats]:
        return ("time in hold", "s", context.elapsed_s)

    def sign(self, context: Context, part: Part) -> Sign:
        """Shares of the pressures, of the chambers that lose most where each has its own, against the time in hold."""
        rows, C = context.rows, len(context.rows.chambers)
        time = context.elapsed_s
        found = pressures(context, part)
        if found is None or part.form == "exponential" or C == 1:
            moved = np.einsum("fkc,fc->fk", context.jacobian, rows.actuation)
            return of_field(part, moved, "share of the pressure", time, "time in hold", "s")
        held = np.where(np.abs(rows.actuation) > _HELD * np.abs(context.span), rows.actuation, np.nan)
        measured, fitted, weight = found
        worst = int(np.argmax(np.sqrt((fitted**2).mean(axis=0))))
        some = np.isfinite(held[:, worst])
        says, share = (weight * rows.actuation**2)[some, worst], 100 / held[some, worst]
        return Sign(
            "time in hold",
            "s",
            f"share of the pressure of {rows.chambers[worst]}",
            "%",
            time[some],
            share * measured[some, worst],
            share * fitted[some, worst],
            says,
            np.full(len(says), rows.chambers[worst]),
        )

    def turned_round(self, context: Context) -> str:
        """What rises during a hold is no leak."""
        u, t = context.rows.actuation, context.elapsed_s[:, None]
        falls = ((u * np.expm1(-t / tau), True) for tau in (*_RISE_S, *TAUS_S))
        return RISES if is_turned_round(context, falls, within_holds=True) else ""

    def lacks(self, context: Context, form: str, parameters: Collection[str]) -> str:
        if form == "as measured":
            return "measured pressures" if context.measured_error is None else ""
        if form.startswith(FORM):
            return "" if context.has_time else MOMENTS
        timed = np.isfinite(context.rows.hold_s).all() or context.has_time
        return "" if timed else MOMENTS

    def in_words(self, found: Fitted) -> str:
        said = by_weights(found) if "weights" in found.parameters else by_formula(found)
        return said.replace("of its pressure", "of its volume") if found.form.startswith(FORM) else said


def _never_rests(context: Context) -> bool:
    """Whether pressures were recorded as they moved, with no holds in which a loss could be seen."""
    return context.rows.by_pressure and context.has_time and context.moves and bool(context.sample_s)


def _forms(how: str, lost: Floats, tau_s: float, context: Context) -> Iterator[Variant]:
    """All chambers alike, each by itself, or one alone; `lost` (F, C) is what a loss of one takes off the pressures."""
    chambers, shape = context.rows.chambers, {"tau_s": tau_s}
    yield Variant(f"exponential{how}", (Term.common("loss", lost),), shape)
    if len(chambers) < 2:
        return
    yield Variant(f"per chamber{how}", (Term.per_chamber("loss", lost, chambers),), shape)
    for c in context.grid("chamber", range(len(chambers))):
        alone = np.where(np.arange(len(chambers)) == c, lost, 0.0)[:, :, None]
        if context.shows(bool(alone.any())):
            own = Term("loss", "pressure", alone, (chambers[int(c)],))
            yield Variant(f"one chamber{how}", (own,), shape | {"chamber": float(c)})
