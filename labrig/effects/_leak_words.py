"""A leak in words: which chamber loses how much of its pressure, and how fast."""

import math

from labrig._text import listed, number, percent, with_unit
from labrig.effects._fitted import MINUTE_S, Fitted

_NAMED = 3  # chambers
_CLEAR = 2.0  # standard deviations from nothing
_LOST = 0.005  # of the full pressure: less is not spoken of
_NONE = "No single chamber leaks clearly."


def by_formula(found: Fitted) -> str:
    """Which chamber loses how much of its pressure at first; empty where the values do not say."""
    if "sensor" in found.parameters and "loss" not in found.parameters:
        share = found.numbers("sensor")
        reaches = f": {percent(share[0])} of it reaches the surface" if share and share[0] <= 1.0 else ""
        return f"Pressure is lost as the sensors measured it{reaches}."
    losses, taus = found.numbers("loss"), found.numbers("tau_s")
    # of a slow leak the rate is known well, and neither the amount nor the time constant
    sds = found.numbers("loss", "sd_given_shape") or found.numbers("loss", "sd")
    if not taus:
        return ""
    chambers = found.names("chamber") or found.names("loss") or found.names("tau_s")
    count = max(len(losses), len(taus))
    if len(chambers) != count:
        chambers = ["Every chamber"] if count == 1 else [f"chamber {i + 1}" for i in range(count)]
    losses = losses if len(losses) == count else (losses or [1.0]) * count
    taus = taus if len(taus) == count else taus[:1] * count
    clear = [i for i in range(count) if len(sds) != count or losses[i] > _CLEAR * sds[i]]
    clear.sort(key=lambda i: -losses[i] / taus[i])
    if not clear:
        return _NONE
    said = [
        f"{chambers[i]} loses {_rate(losses[i] / taus[i])} of its pressure at first "
        f"(time constant {with_unit(number(taus[i]), 's')})"
        for i in clear
    ]
    tight = count - len(clear)
    others = "the other holds its own" if tight == 1 else f"the other {tight} hold theirs"
    rest = f"; {others}, as far as these data tell" if tight else ""
    return f"{'; '.join(said)}{rest}."


def by_weights(found: Fitted) -> str:
    """Which chambers lose most of their full pressure in the longest hold, or in a minute where that is less."""
    hold_s = min(found.longest_s or MINUTE_S, MINUTE_S)  # a record has no holds
    loss: dict[str, float] = {}
    for label, value in zip(found.names("weights"), found.numbers("weights"), strict=False):
        name, _, chamber = label.partition(" of ")
        kind, tau, *_ = (*name.split(), "")
        if kind in {"lost", "gone"}:
            loss[chamber] = loss.get(chamber, 0.0) - value * math.expm1(-hold_s / float(tau))
    if found.form.endswith("gone for good"):
        return "What escapes from a closed volume is gone for good."
    if not loss:  # its functions are those of the surface
        return "The surface sinks as a whole: no chamber stands out."
    common = loss.pop("", 0.0)
    each = {chamber: common + own for chamber, own in loss.items()} or {"Every chamber": common}
    most = sorted(each, key=lambda chamber: -each[chamber])[:_NAMED]
    said = [f"{name} loses {percent(each[name])}" for name in most if each[name] > _LOST]
    if not said:
        return _NONE
    how_long = "a minute" if hold_s == MINUTE_S else f"{hold_s:.2g} s"
    return f"{listed(said)} of its full pressure in {how_long}."


def _rate(per_s: float) -> str:
    for seconds, unit in ((1, "second"), (60, "minute"), (3600, "hour")):
        if per_s * seconds >= 0.001 or unit == "hour":
            return f"{100 * per_s * seconds:.2g} % a {unit}"
    raise AssertionError
