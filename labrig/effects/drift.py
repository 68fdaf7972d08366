"""Drift: something changes with the clock or the temperature, whatever the pressures do."""

from collections.abc import Iterator

import numpy as np

from labrig.effects._context import Context
from labrig.effects._effect import Effect, Parameter, Term, Variant
from labrig.effects._rows import Floats


class Drift(Effect):
    name = "drift"
    meaning = (
        "The zero or the gain of sensors, frame or material wanders with time or temperature\n"
        "during the session."
    )
    acts_on = "observation"
    parameters = (
        Parameter("shift", "observable", meaning="shift by the end of the session, for each observable"),
        Parameter("gain", "1", -1.0, 1.0, meaning="change of the whole displacement by the end"),
        Parameter("pressure", "actuation", per="chamber", meaning="shift of the pressure zero by the end"),
        Parameter("warm_up", "1", 0.0, 10.0, meaning="time constant of a warm-up, of the session"),
    )
    reference = "JCGM 200:2012 (VIM), 4.21 instrumental drift"
    signature = "error that follows the time in session (or the temperature), not the pressure or the hold"
    experiment = "the same probe early and late in the session, with nothing else changed"
    beyond_static = "always"

    def variants(self, context: Context) -> Iterator[Variant]:
        for form, clock, shape in self._clocks(context):
            yield Variant(f"{form}, shift", (Term.pattern("shift", clock),), shape)
            if context.rows.rest_mm is not None:
                yield Variant(f"{form}, frame", (Term("shift", "frame", clock),), shape)
            if np.ptp(context.displacement) > 0:
                gain = Term.field("gain", context.displacement * clock[:, None])
                yield Variant(f"{form}, gain", (gain,), shape)
            if context.moves and len(context.rows.chambers) > 1:
                zero = np.repeat(clock[:, None], len(context.rows.chambers), axis=1)
                term = Term.per_chamber("pressure", zero, context.rows.chambers)
                yield Variant(f"{form}, pressure zero", (term,), shape)

    def _clocks(self, context: Context) -> Iterator[tuple[str, Floats, dict[str, float]]]:
        t = context.session_time_s
        end = float(t.max())
        if end > 0:
            yield "linear", t / end, {}
            for share in context.grid("warm_up", (0.3, 1.0)):
                yield "warm-up", -np.expm1(-t / (share * end)), {"warm_up": share}
            whole = context.rows.time_s - np.nanmin(context.rows.time_s)
            if whole.max() > 1.5 * end:
                yield "linear over all sessions", whole / whole.max(), {}
                for share in context.grid("warm_up", (0.3, 1.0)):
                    yield "warm-up over all sessions", -np.expm1(-whole / (share * end)), {"warm_up": share}
        for name, cov in context.rows.covariates.items():
            known = np.isfinite(cov.values)
            warm = cov.unit in {"degC", "K", "degF", "kelvin"} or "temp" in name.lower()
            if warm and known.all() and np.ptp(cov.values) > 0:
                yield name, (cov.values - cov.values.mean()) / np.ptp(cov.values), {}

    def covariate(self, context: Context) -> tuple[str, str, Floats]:
        return ("time in session", "s", context.session_time_s)
