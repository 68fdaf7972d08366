"""What leaks out of a closed volume, as before a syringe, is gone for good: no actuation fills it up again."""

from collections.abc import Iterator

import numpy as np

from labrig.arrays import Floats
from labrig.effects._context import Context
from labrig.effects._effect import Term, Variant
from labrig.effects._family import Feature, pressure
from labrig.effects._logged import is_volume

FORM = "closed volume"
_OPENED = ", opened at zero"
GONE_S = (100.0, 1000.0, 10000.0)
_EMPTY = 0.01
"""Of the range: a chamber with less may have been opened."""


def gone_for_good(context: Context) -> Iterator[Feature]:
    """What has gone until then, slowly or fast, for good or until the chamber is empty next, and may be opened; nothing
    where pressures are commanded.
    """
    if is_volume(context.rows.actuation_unit) and context.has_time and context.moves:
        for tau in GONE_S:
            for opened in (False, True):
                name = f"gone {tau}" + (" since it was empty" if opened else "")
                yield pressure(name, -gone(context, tau, opened) / context.span)


def closed_volumes(context: Context, taus_s: tuple[float, ...]) -> Iterator[Variant]:
    """The same as formulas: a share of the volume that is left escapes each second."""
    if context.shows(is_volume(context.rows.actuation_unit) and context.has_time and context.moves):
        for tau in context.grid("tau_s", taus_s):
            for how, opened in (("", False), (_OPENED, True)):
                term = Term.common("loss", -gone(context, tau, opened))
                yield Variant(FORM + how, (term,), {"tau_s": tau})


def gone(context: Context, tau_s: float, opened: bool) -> Floats:
    """How much of what each chamber holds has gone at each row (F, C), where a share 1 / tau_s of what is left goes
    each second.
    """
    rows = context.rows
    held = rows.event_actuation - context.vented
    gap_s = np.maximum(np.diff(rows.event_time_s, prepend=rows.event_time_s[:1]), 0.0)
    empty = np.abs(held) <= _EMPTY * np.abs(context.span)
    lost = np.zeros_like(held)
    for e in range(1, len(held)):
        if context.started[e] == e - 1:
            lost[e] = held[e - 1] + (lost[e - 1] - held[e - 1]) * np.exp(-gap_s[e] / tau_s)
        if opened:
            lost[e] = np.where(empty[e], 0.0, lost[e])
    left = held[rows.event] - lost[rows.event]
    return held[rows.event] - left * np.exp(-context.elapsed_s / tau_s)[:, None]
