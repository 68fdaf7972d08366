"""Numbers, shares and names as people write them."""

import math
from collections.abc import Sequence
from numbers import Real
from typing import Any

from labrig.contents import Summary

NO_BREAK = "\u00a0"


def number(value: Any) -> str:
    """Three significant digits, without an exponent where that is short; a dash for what is not known."""
    if value is None or not isinstance(value, Real) or value != value:
        return "–"
    value = float(value)
    if value == 0 or 1e-3 <= abs(value) < 1e5:
        return f"{value:.3g}" if abs(value) < 1000 else f"{value:.0f}"
    return f"{value:.2e}"


def give_or_take(value: Any, sd: Any, digits: int = 1) -> str:
    """`2.1 ± 0.1`: the standard deviation to its first digits, the value to the same place; without one, the value."""
    if value is None or value != value or sd is None or not (math.isfinite(sd) and sd > 0):
        return number(value)
    places = digits - 1 - math.floor(math.log10(float(f"{sd:.{digits - 1}e}")))
    if places > 5 or places < -3:
        return f"{number(value)} ± {number(sd)}"
    shown = max(places, 0)
    return f"{round(value, places):.{shown}f} ± {round(sd, places):.{shown}f}"


def percent(value: Any) -> str:
    """A share as people say it, never a false certainty."""
    if value is None or value != value:
        return "–"
    if value > 0.995:
        return "over 99 %"
    if value < 0.005:
        return "under 1 %"
    return f"{100 * value:.0f} %"


def chance(value: Any) -> str:
    """A probability as people say it: rounded down, so that a doubt of 74.9 % is not said to be as probable as what is
    sure from 75 % on.
    """
    if value is None or value != value or value > 0.995:
        return percent(value)
    return f"{math.floor(100 * value + 1e-6)} %" if value >= 0.01 else "under 1 %"


def word(name: str) -> str:
    """An effect's name as a word in a sentence."""
    return name.replace("_", " ")


def listed(names: Sequence[str], last: str = "and") -> str:
    """`a`, `a and b`, `a, b and c`."""
    words = [word(name) for name in names]
    if len(words) < 2:
        return "".join(words)
    return f"{', '.join(words[:-1])} {last} {words[-1]}"


def capital(text: str) -> str:
    """The text with its first letter large."""
    return text[:1].upper() + text[1:]


def counted(count: int, what: str) -> str:
    """`1 marker`, `34 markers`."""
    return f"{count} {what}" if count == 1 else f"{count} {what}s"


def amount(summary: Summary, which: str) -> str:
    """One of the errors with its unit, such as `1.92 mm`."""
    return with_unit(number(summary.get("error", {}).get(which)), summary.get("units", ""))


def with_unit(text: str, unit: Any) -> str:
    """A number and its unit, on one line; a unit of `1` is none."""
    return text if unit in (None, "", "1") else f"{text}{NO_BREAK}{unit}"


def with_sessions(effect: str, sessions: Sequence[str]) -> str:
    """An effect and the sessions in which it was ruled out, `frame (in s1)`; none: in all of the run."""
    return effect + (f" (in {', '.join(sorted(sessions))})" if sessions else "")
