"""Delay: what is seen lags behind what was commanded."""

from collections.abc import Collection, Iterator

import numpy as np

from labrig.arrays import Floats
from labrig.effects._context import MOMENTS, Context
from labrig.effects._effect import Effect, Parameter, Term, Variant
from labrig.effects._family import Feature, Space, acting, field, lags, pressure
from labrig.effects._other_way import is_turned_round
from labrig.effects._sign import Part, Sign, by_chamber, of_step, varies
from labrig.effects._skin import by_itself, by_place, lag_behind, last_motion, per_sensor, settling

TAUS_S = (0.3, 0.5, 0.8, 1.2, 2.0, 3.0, 5.0)
AHEAD = "what is ahead of the input"
SAMPLES = (1, 2, 3, 5, 8, 13, 21)
"""Lags and dead times of a record without holds, in samples."""


class Delay(Effect):
    name = "delay"
    meaning = (
        "Actuation or sensor lags: just after a change the old shape is still (partly) there,\n"
        "and all of it is gone once a few time constants have passed."
    )
    acts_on = "pressure"
    unit_in_names = "s"
    remembers = True
    parameters = (
        Parameter("share", "1", 0.4, 2.5, "chamber", "share of the change that lags; 1 is a plain lag"),
        Parameter("tau_s", "s", 0.0, 30.0, meaning="time constant of the lag"),
        Parameter("dead_s", "s", 0.0, 30.0, meaning="dead time: nothing of the change is there before"),
    )
    reference = "K. Ogata, Modern Control Engineering, 5th ed. 2010, ch. 5 (first-order systems)"
    signature = "error proportional to the last change of pressure, fading fast within the hold"
    experiment = "one large step up and one down, recorded from the moment of the command"
    needs = "the times of the rows"
    blurred_by = frozenset({"one moment", "one speed", "one stroke"})

    def variants(self, context: Context) -> Iterator[Variant]:
        if not context.has_time or not context.shows(context.moves):
            return
        u, chambers = context.rows.actuation, context.rows.chambers
        dt = context.sample_s
        late = TAUS_S if not dt else tuple(dt * n for n in SAMPLES)
        for dead in context.grid("dead_s", late):
            past = context.earlier(dead) - u
            if context.shows(np.any(past)):
                yield Variant("dead time", (Term.common("share", past),), {"dead_s": dead})
        for tau in context.grid("tau_s", (*(dt * n for n in SAMPLES if 0 < dt * n < TAUS_S[0]), *TAUS_S)):
            lag = context.relaxed(tau) - u
            yield Variant("first order", (Term.common("share", lag),), {"tau_s": tau})
            if len(chambers) > 1:
                yield Variant("per chamber", (Term.per_chamber("share", lag, chambers),), {"tau_s": tau})
            for term in per_sensor(context, "share", lag):
                yield Variant("per sensor", (term,), {"tau_s": tau})
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
        for whole_s in (2.0, 4.0, 8.0):
            out.append(pressure(f"filling {whole_s}", _filling(context, whole_s), 0.3))
        yield (late := Space("late", "delay", acting(out), 0.8))
        yield from by_itself(context, late)
        yield from _seen_late(context)
        if dt := context.sample_s:
            yield Space(
                "by samples", "delay by samples", acting(_by_samples(context, dt)), 0.8, absolute=False
            )

    def covariate(self, context: Context) -> tuple[str, str, Floats]:
        return ("time in hold", "s", context.elapsed_s)

    def sign(self, context: Context, part: Part) -> Sign:
        """Against the time since the last move; else, where all rows are as long after it, against that move."""
        held = of_step(context, part)
        if varies(held):
            return held
        moved = context.rows.actuation - context.previous[context.rows.event]
        return by_chamber(context, part, moved, "last move of the chamber", named=True)

    def turned_round(self, context: Context) -> str:
        """What is ahead is no delay: the lag that has most of the residual, more than the rest, has it turned round."""
        return AHEAD if is_turned_round(context, _late_and_early(context)) else ""

    def lacks(self, context: Context, form: str, parameters: Collection[str]) -> str:
        return "" if context.has_time else MOMENTS


def _late_and_early(context: Context) -> Iterator[tuple[Floats, bool]]:
    """Changes of the pressures (F, C) by lags, which are late, and in a record by what is yet to come, which is not."""
    u = context.rows.actuation
    for tau in TAUS_S:
        yield context.relaxed(tau) - u, True
    for n in SAMPLES if context.sample_s else ():
        yield context.earlier(n * context.sample_s) - u, True
        yield context.earlier(-n * context.sample_s) - u, False


def _seen_late(context: Context) -> Iterator[Space]:
    """Lags of what is seen: a filter, a heavy body; and parts of it that follow later than others."""
    taus, left = (0.3, 0.6, 1.2, 2.4), last_motion(context)
    lagging = [(f"skin {tau}", lag_behind(context, tau)) for tau in taus]
    skin = [field(name, values) for name, values in lagging]
    for tau in taus:
        skin.append(field(f"skin second order {tau}", settling(context, tau), 0.5))
        skin.append(field(f"skin dead {tau}", left * (context.elapsed_s < tau)[:, None], 0.3))
    yield Space("in the skin", "delay skin", acting(skin))
    places = [f for name, values in lagging for f in by_place(context, name, values)]
    if places:
        yield Space("in the skin, by place", "delay skin by place", acting(skin[: len(taus)] + places))


def _filling(context: Context, whole_s: float) -> Floats:
    """How far each chamber stays behind, (F, C), where its flow goes with the root of what is left: orifice flow.

    The whole range takes `whole_s`, a ninth of it a third of that; see J. F. Blackburn, G. Reethof, J. L. Shearer,
    Fluid Power Control, MIT Press 1960.
    """
    rows, t = context.rows, context.rows.event_time_s
    drive = rows.event_actuation / context.span
    begin = np.zeros_like(drive)  # what is left to go when an event begins

    def after(left: Floats, gone_s: Floats | float) -> Floats:
        return np.sign(left) * np.maximum(np.sqrt(np.abs(left)) - gone_s / whole_s, 0.0) ** 2

    for e, before in enumerate(context.started):
        if before < 0:
            begin[e] = context.vented / context.span - drive[e]
        else:
            last = drive[before] + after(begin[before], max(t[e] - t[before], 0.0))
            begin[e] = last - drive[e]
    return after(begin[rows.event], context.elapsed_s[:, None])


def _by_samples(context: Context, dt: float) -> list[Feature]:
    """Dead times of some samples of a record, and lags that are shorter than those that all runs are asked for."""
    u, span = context.rows.actuation, context.span
    dead = [pressure(f"dead {n} samples", (context.earlier(n * dt) - u) / span) for n in SAMPLES]
    short = [n for n in SAMPLES if n * dt < TAUS_S[0]]
    return dead + [pressure(f"lag {n} samples", (context.relaxed(n * dt) - u) / span) for n in short]
