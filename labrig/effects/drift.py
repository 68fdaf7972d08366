"""Drift: something changes with the clock or the temperature, whatever the pressures do."""

from collections.abc import Collection, Iterator, Sequence
from dataclasses import replace

import numpy as np

from labrig.arrays import Floats
from labrig.effects._context import Context
from labrig.effects._effect import Effect, Parameter, Term, Variant
from labrig.effects._family import (
    Space,
    acting,
    by_covariate,
    clocks,
    field,
    motion_scale,
    pattern,
    pressure,
    temperatures,
)
from labrig.effects._fields import frame_modes, scale_mode, strain_modes
from labrig.effects._logged import is_temperature
from labrig.effects._sign import Part, Sign, along_own, of_field
from labrig.effects._skin import MARKERS, groups

HOUR_S = 3600.0
_CELSIUS = {
    "degC": (0.0, 1.0),
    "K": (273.15, 1.0),
    "kelvin": (273.15, 1.0),
    "degF": (32.0, 5 / 9),
}
"""Where 0 degC is on a scale of temperature, and how many kelvin its degree has."""


Tick = tuple[str, Floats, float]
"""A slow function: its name, which begins with its clock's, its values (F,), its weight."""
_BY_TIME = ("linear", "warm-up", "linear over all sessions", "warm-up over all sessions")


class Drift(Effect):
    name = "drift"
    meaning = (
        "The zero or the gain of sensors, frame or material wanders with time or temperature\n"
        "during the session."
    )
    acts_on = "observation"
    remembers = True
    blurred_by = frozenset({"one stroke"})
    parameters = (
        Parameter("shift", "observable", meaning="shift after the warm-up, for each observable"),
        Parameter("gain", "1", -1.0, 1.0, meaning="change of the whole displacement after the warm-up"),
        Parameter("pressure", "actuation", per="chamber", meaning="shift of the pressure zero after it"),
        Parameter("tau_s", "s", 0.0, meaning="time constant of the warm-up"),
        Parameter("shift_rate", "observable/h", meaning="shift in an hour, for each observable"),
        Parameter("gain_rate", "1/h", -20.0, 20.0, meaning="change of the whole displacement in an hour"),
        Parameter("pressure_rate", "actuation/h", per="chamber", meaning="shift of the pressure zero"),
        Parameter("shift_per_k", "observable/K", meaning="shift for each kelvin, for each observable"),
        Parameter("gain_per_k", "1/K", -1.0, 1.0, meaning="change of the whole displacement for each kelvin"),
        Parameter("pressure_per_k", "actuation/K", per="chamber", meaning="shift of the pressure zero"),
        Parameter("reference", "degC", meaning="the temperature without a shift", given=True),
    )
    reference = "JCGM 200:2012 (VIM), 4.21 instrumental drift"
    signature = "error that follows the time in session (or the temperature), not the pressure or the hold"
    experiment = "the same probe early and late in the session, with nothing else changed"
    needs = "the times of the rows, or a temperature"

    def variants(self, context: Context) -> Iterator[Variant]:
        for form, clock, per, shape in self._clocks(context):
            yield Variant(f"{form}, shift", (Term.pattern(f"shift{per}", clock),), shape)
            if context.rows.rest_mm is not None:
                yield Variant(f"{form}, frame", (Term(f"shift{per}", "frame", clock),), shape)
            if context.shows(np.ptp(context.displacement) > 0):
                gain = Term.field(f"gain{per}", context.displacement * clock[:, None])
                yield Variant(f"{form}, gain", (gain,), shape)
            if context.shows(context.moves) and len(context.rows.chambers) > 1:
                zero = np.repeat(clock[:, None], len(context.rows.chambers), axis=1)
                term = Term.per_chamber(f"pressure{per}", zero, context.rows.chambers)
                yield Variant(f"{form}, pressure zero", (term,), shape)

    def _clocks(self, context: Context) -> Iterator[tuple[str, Floats, str, dict[str, float]]]:
        """What it follows: the form's name, values (F,), how parameters by it end, and what is not linear."""
        t = context.session_time_s
        end = float(t.max())
        if np.isfinite(context.rows.time_s).all() and context.shows(end > 0):
            taus = (0.3 * end, end)
            yield "linear", t / HOUR_S, "_rate", {}
            for tau in context.grid("tau_s", taus):
                yield "warm-up", -np.expm1(-t / tau), "", {"tau_s": tau}
            whole = context.rows.time_s - context.rows.time_s.min()
            if context.shows(whole.max() > 1.5 * end):
                yield "linear over all sessions", whole / HOUR_S, "_rate", {}
                for tau in context.grid("tau_s", taus):
                    yield "warm-up over all sessions", -np.expm1(-whole / tau), "", {"tau_s": tau}
        for name, cov in context.rows.covariates.items():
            if (
                is_temperature(name, cov)
                and np.isfinite(cov.values).all()
                and context.shows(np.ptp(cov.values) > 0)
            ):
                zero, kelvin = _CELSIUS.get(cov.unit, (0.0, 1.0))
                celsius = (cov.values - zero) * kelvin
                for reference in context.grid(
                    "reference", tuple(round(float(t), 3) for t in (celsius[0], celsius.mean()))
                ):
                    yield name, celsius - reference, "_per_k", {"reference": reference}

    def family(self, context: Context) -> Iterator[Space]:
        """Slow functions of time or temperature: in gain, rigid motion, the pressures' zero, or each observable; in the
        zero and gain of one of few sensors. Where there are several sessions, what goes one way in each has spaces of
        its own, too, and so has a trend over all: a law is seldom both.
        """
        for ending, ticks in _kinds(list(clocks(context)), len(context.rows.sessions)).items():
            for space in self._following(context, ticks):
                yield replace(space, key=space.key + ending)
        for name, warmer in temperatures(context):  # what it was when the model was right is not known
            for key, zero in ((name, 0.0), (f"{name} about its mean", warmer.mean())):
                yield Space(key, "drift temperature", acting(by_covariate(context, name, warmer - zero)))

    def _following(self, context: Context, ticks: Sequence[Tick]) -> Iterator[Space]:
        """What follows these functions."""
        rows = context.rows
        if not ticks:
            return
        has_axis = (rows.axis >= 0).sum() >= 3 and (rows.marker >= 0).any()
        scale = motion_scale(context)
        if np.ptp(context.displacement) > 0:
            out = [field(n, context.displacement * q[:, None], w) for n, q, w in ticks]
            out += [
                pressure(f"{n} load", q[:, None] * rows.fraction, 0.5 * w)
                for n, q, w in ticks
                if context.moves
            ]
            yield Space("gain", "drift gain", acting(out), 0.5, absolute=False)
        if has_axis:
            modes = [frame_modes(context), scale_mode(context)[:, :, None], strain_modes(context)]
            modes = np.concatenate(modes, axis=2)
            size = np.sqrt((modes**2).mean(axis=(0, 1)))
            modes = modes / np.where(size > 0, size, 1.0) * scale[None, :, None]
            out = [
                field(f"{n} {j}", modes[:, :, j] * q[:, None], w * likely)
                for n, q, w in ticks
                for j, likely in enumerate([1.0] * 3 + [0.3] * 4 + [0.1] * 5)
                if j < 6 or "cosine" not in n  # what swells does it slowly
            ]
            yield Space("rigid", "drift rigid", acting(out), absolute=False)
        if context.moves:
            out = [pressure(n, np.repeat(q[:, None], len(rows.chambers), axis=1), w) for n, q, w in ticks]
            yield Space("zero", "drift zero", acting(out), 0.5, absolute=False)
        yield Space("pattern", "drift pattern", acting([pattern(n, q, w) for n, q, w in ticks]))
        for own, name in zip(*groups(rows), strict=True):
            if name != MARKERS:
                out = [field(n, scale * own * q[:, None], w) for n, q, w in ticks]
                out += [field(f"{n} gain", context.displacement * own * q[:, None], w) for n, q, w in ticks]
                yield Space(f"sensor {name}", "drift of a sensor", acting(out), absolute=False)

    def follows(self, context: Context) -> Collection[str]:
        return [name for name, _ in temperatures(context)]

    def covariate(self, context: Context) -> tuple[str, str, Floats]:
        return ("time in session", "s", context.session_time_s)

    def sign(self, context: Context, part: Part) -> Sign:
        """Against the clock or the temperature that it follows; a gain as a share of the displacement."""
        rows = context.rows
        clock = part.form.rsplit(", ", 1)[0]
        name, unit, x = self.covariate(context)
        if clock.endswith("over all sessions"):
            name, x = "time since the run began", rows.time_s - np.nanmin(rows.time_s)
        elif clock not in _BY_TIME and clock in rows.covariates:
            name, unit, x = clock, rows.covariates[clock].unit, rows.covariates[clock].values
        if part.form.endswith(", gain"):
            return of_field(part, context.displacement, "share of the displacement", x, name, unit)
        return along_own(context, part, x, name, unit)

    def lacks(self, context: Context, form: str, parameters: Collection[str]) -> str:
        clock = form.rsplit(", ", 1)[0]
        by_time = clock in _BY_TIME or not any(name.endswith("_per_k") for name in parameters)
        missing = by_time and not np.isfinite(context.rows.time_s).all()
        return "the moments of its rows" if missing else "" if by_time else clock


def _kinds(ticks: Sequence[Tick], sessions: int) -> dict[str, Sequence[Tick]]:
    """All of these functions; where there are several sessions also what goes one way in each, and a trend over all.
    What turns as often as there are sessions is no trend: it is another value in each, whoever has that. By how the
    keys of their spaces end.
    """
    if sessions < 2:
        return {"": ticks}

    def without(other: str, most: int) -> list[Tick]:
        return [tick for tick in ticks if not tick[0].startswith(other) and _turns(tick) <= most]

    return {"": ticks, ", anew": without("run ", 0), ", trend": without("session ", (sessions - 1) // 2)}


def _turns(tick: Tick) -> int:
    """How many half waves a function has; none of what goes one way."""
    _, _, wave = tick[0].partition("cosine ")
    return int(wave or 0)
