"""Two models on the same measurements, in words."""

import math

from labrig._text import NO_BREAK, number, percent, with_unit
from labrig.contents import Gap, Versus


def versus_headline(summary: Versus) -> str:
    """Which model is nearer to the measurements and by how much, or that the run cannot tell."""
    first, second = (str(model["name"]) for model in summary["models"])
    if summary["better"] is None:
        return f"This run cannot tell which model is nearer to the measurements, “{first}” or “{second}”"
    other = first if summary["better"] == second else second
    gap = with_unit(number(abs(summary["difference"]["value"])), summary["units"])
    return f"“{summary['better']}” is nearer to the measurements than “{other}”, by {gap}"


def difference_words(summary: Versus) -> str:
    """The difference of the errors, with its interval."""
    first, second = (str(model["name"]) for model in summary["models"])
    found, units = summary["difference"], summary["units"]
    value, interval = interval_words(found)
    said = f"Error of “{first}” minus error of “{second}”: {with_unit(value, units)}"
    if not interval:
        return f"{said}. The run has too few captures for an interval."
    ends = f"{interval}{NO_BREAK}{units}"
    return f"{said} ({percent(found['level'])} interval {ends}, from {found['blocks']} blocks of captures)."


def interval_words(found: Gap) -> tuple[str, str]:
    """A difference and `low to high`, both to two digits of the interval's half width; without one, no interval."""
    low, high = found["low"], found["high"]
    half = (high - low) / 2
    if not half > 0:
        return signed(found["value"]), ""
    places = max(0, min(6, 1 - math.floor(math.log10(half))))
    value, low, high = (signed(number, places) for number in (found["value"], low, high))
    return value, f"{low} to {high}"


def share_words(summary: Versus) -> str:
    """What the difference means beside the noise floor."""
    floor, units = summary["error"]["floor"], summary["units"]
    errors = [float(model["error"]) for model in summary["models"]]
    if max(errors) < 1.1 * floor:
        return (
            f"Both are as good as the measurements, whose noise floor is {with_unit(number(floor), units)}."
        )
    if summary["better"] is None:
        return "More captures, or captures where the two predict different shapes, would narrow the interval."
    worse, nearer = max(errors), min(errors)
    beyond = (max(worse**2 - floor**2, 0.0), max(nearer**2 - floor**2, 0.0))
    less = 1 - (beyond[1] / beyond[0]) ** 0.5
    return f"That is {percent(less)} of the error beyond the noise floor, {with_unit(number(floor), units)}."


def signed(value: float, places: int | None = None) -> str:
    """A number with its sign, a true minus; three digits, or so many behind the point."""
    size = number(abs(value)) if places is None else f"{abs(value):.{places}f}"
    return ("+" if value > 0 else "−" if value < 0 else "") + size
