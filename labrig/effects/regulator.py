"""Regulator: the chamber gets another pressure than the one commanded."""

from collections.abc import Collection, Iterator
from itertools import pairwise

import numpy as np

from labrig.arrays import Floats
from labrig.effects._context import Context
from labrig.effects._effect import Effect, Parameter, Term, Variant
from labrig.effects._family import Feature, Space, acting, one_way, pressure
from labrig.effects._own_pressure import any_curve, curves
from labrig.effects._sessions import IN_EACH, in_sessions, labels
from labrig.effects._sign import Part, Sign, by_chamber

_BANDS = (0.03, 0.06, 0.12, 0.24)
"""Widths of a dead band, and of what a supply lacks, shares of the range: a grid, a factor of two apart."""


class Regulator(Effect):
    name = "regulator"
    meaning = (
        "The pressure regulator or its sensor has a wrong gain, an offset, a bow or a dead band, or its supply\n"
        "ends below the top, so that a settled chamber holds another pressure than the one commanded."
    )
    acts_on = "pressure"
    unit_in_names = "%"
    parameters = (
        Parameter(
            "gain", "1", -0.9, 9.0, "chamber", "error of the gain: true = (1 + gain) commanded + offset"
        ),
        Parameter("offset", "actuation", per="chamber", meaning="pressure held when zero is commanded"),
        Parameter("gain_in_session", "1", -0.9, 9.0, "session", "error of the gain, another in each session"),
        Parameter("offset_in_session", "actuation", per="session", meaning="pressure held at zero, likewise"),
        Parameter("dead_band", "1", 0.0, 1.5, meaning="share of the dead band's pressure that is lost"),
        Parameter("band", "1", 0.0, 0.5, meaning="width of the dead band, fraction of the range"),
        Parameter("short", "1", 0.0, 1.5, meaning="share of what is asked above the top that is lost"),
        Parameter("top", "1", 0.0, 1.0, meaning="where the supply ends, fraction of the range"),
        Parameter(
            "bow",
            "1",
            -0.5,
            0.5,
            "chamber",
            "error half-way to full pressure, of the range; none at the ends",
        ),
        Parameter("sensor", "1", 0.2, 1.8, meaning="share of the measured error that reaches the surface"),
    )
    reference = "J. F. Blackburn, G. Reethof, J. L. Shearer, Fluid Power Control, MIT Press 1960, ch. 7"
    signature = "error proportional to each chamber's pressure, the same in every direction and at every time"
    experiment = "one chamber at a time over its range against a reference manometer"
    ruled_out_by = "set each pressure by a reference manometer"
    by_hand = "read each chamber against a reference manometer over its range"
    blurred_by = frozenset({"one moment", "one side"})

    def variants(self, context: Context) -> Iterator[Variant]:
        if not context.shows(context.moves):
            return
        u = context.rows.actuation
        chambers = context.rows.chambers
        yield Variant("gain", (Term.common("gain", u),))
        if len(chambers) > 1:
            yield Variant("gain per chamber", (Term.per_chamber("gain", u, chambers),))
        # a chamber that is vented is open to the room, whatever its regulator or sensor would hold
        open_at_zero = (np.abs(u - context.vented) > 1e-9 * np.abs(context.span)).astype(float)
        for form, one in (("", np.ones_like(u)), (", open when vented", open_at_zero)):
            if form and not context.shows(not one.all()):
                continue
            yield Variant(f"gain and offset{form}", (Term.common("gain", u), Term.common("offset", one)))
            if len(chambers) > 1:
                terms = (Term.per_chamber("gain", u, chambers), Term.per_chamber("offset", one, chambers))
                yield Variant(f"gain and offset per chamber{form}", terms)
        bow = 4 * u * (1 - np.abs(context.rows.fraction))  # terminal-based non-linearity, IEC 61298-2
        yield Variant("bowed", (Term.common("bow", bow),))
        if len(chambers) > 1:
            yield Variant("bowed per chamber", (Term.per_chamber("bow", bow, chambers),))
        if (each := in_sessions(context)) is not None:
            gain = Term("gain_in_session", "pressure", u[:, :, None] * each[:, None], labels(context))
            zero = np.ones_like(u)[:, :, None] * each[:, None]
            offset = Term("offset_in_session", "pressure", zero, labels(context))
            yield Variant(f"gain{IN_EACH}", (gain,))
            yield Variant(f"offset{IN_EACH}", (offset,))
            yield Variant(f"gain and offset{IN_EACH}", (gain, offset))
        for band in context.grid("band", (0.03, 0.08)):
            width = band * np.abs(context.span)
            lost = -np.clip(u, -width, width)
            yield Variant("dead band", (Term.common("dead_band", lost),), {"band": band})
        for top in context.grid("top", [1 - band for band in _BANDS]):
            over = -_above(context.rows.fraction, top) * context.span
            if context.shows((over != 0).any()):
                yield Variant("supply ends", (Term.common("short", over),), {"top": top})
        settled = context.measured_error
        if settled is not None:
            yield Variant("as measured", (Term.common("sensor", settled),))

    def family(self, context: Context) -> Iterator[Space]:
        """Gain, offset, dead band, steps and a curved characteristic of each chamber's own pressure."""
        if not context.moves:
            return
        yield Space("settled", "regulator", curves(context), 0.4)
        yield any_curve(context)
        yield from _lost(context)
        if (each := in_sessions(context)) is not None:
            x = context.rows.fraction
            for name, values in (("gain", x), ("zero", np.ones_like(x))):
                own = [pressure(f"session {s}", values * there[:, None]) for s, there in enumerate(each.T)]
                spectrum = f"regulator {name} by session"
                yield Space(f"{name} by session", spectrum, acting(own), 0.8, absolute=False)

    def covariate(self, context: Context) -> tuple[str, str, np.ndarray]:
        return ("mean pressure", context.rows.actuation_unit, context.rows.actuation.mean(axis=1))

    def sign(self, context: Context, part: Part) -> Sign:
        return by_chamber(context, part, named=True)

    def lacks(self, context: Context, form: str, parameters: Collection[str]) -> str:
        return "measured pressures" if form == "as measured" and context.measured_error is None else ""


def _lost(context: Context) -> Iterator[Space]:
    """A dead band, and a supply that ends below the top, about as wide as two widths say; and a valve that stays shut
    below a pressure.
    """
    x = context.rows.fraction
    for low, high in pairwise(_BANDS):
        bands = [pressure(f"band {w}", -np.clip(x, -w, w)) for w in (low, high)]
        yield _plain(f"dead band {low} to {high}", acting(bands))
        over = [pressure(f"over {w}", -_above(x, 1 - w)) for w in (low, high)]
        yield _plain(f"no more than {1 - high:g} to {1 - low:g}", acting(over))
    for width in _BANDS:
        shut = pressure("shut", np.where(np.abs(x) < width, -x, 0.0))
        yield _plain(f"shut below {width}", acting([shut]))


def _above(x: Floats, top: float) -> Floats:
    """What of shares of the range is above one, either way."""
    return np.sign(x) * np.maximum(np.abs(x) - top, 0.0)


def _plain(key: str, features: tuple[Feature, ...]) -> Space:
    return one_way(Space(key, "regulator low", features, 0.5, absolute=False, plain=True))
