"""A change in a sentence."""

import math

from labrig.age._places import slips_told
from labrig.contents import HistoryChange

_DIGITS = 3


def change_words(change: HistoryChange, markers: int) -> str:
    """What changed, from what to what, and since when; of places with what so many `markers` in all can't tell."""
    when = f"since {_day(change['date'])} UTC"
    if change["group"] in ("marker", "frame"):
        return f"{_moved(change, markers)} {when}{_untold(markers)}"
    before, after = change["before"][0], change["after"][0]
    verb = ("grows" if after > before else "falls") if change["shape"] == "slope" else "went"
    fold = f" {after / before:.2g}-fold," if change["group"] == "effect" and before * after > 0 else ""
    return f"{_subject(change)} {verb}{fold} from {_both(before, after)} {change['unit']} {when}"


def _moved(change: HistoryChange, markers: int) -> str:
    what = change["name"] if change["group"] == "marker" else "the cameras"
    either = " or the cameras" if change["group"] == "marker" and not slips_told(markers) else ""
    how = "turned" if change["name"] == "turn" else "moved"
    slowly = "slowly " if change["shape"] == "slope" else ""
    size = _number(math.dist(change["before"], change["after"]))
    return f"{what}{either} {slowly}{how} by {size} {change['unit']}"


def _untold(markers: int) -> str:
    """That so few markers tell no second one that slipped from the cameras."""
    return (
        f" ({markers} markers can't tell two that slipped from the cameras)"
        if slips_told(markers) == 1
        else ""
    )


def _subject(change: HistoryChange) -> str:
    name = str(change["name"])
    return {
        "effect": name,
        "gain": "the whole displacement",
        "error": "the model's error",
        "floor": "the noise floor",
        "leak": f"the leak of {name}",
        "zero": f"the zero of {name}",
        "lost": "markers lost",
    }[str(change["group"])]


def _both(before: float, after: float) -> str:
    """Two numbers, to the third digit of their difference."""
    places = _DIGITS - 1 - math.floor(math.log10(abs(after - before))) if after != before else _DIGITS
    places = min(max(places, 0), 6)
    first, last = (round(value, places) + 0.0 for value in (before, after))  # no -0
    return f"{first:.{places}f} to {last:.{places}f}"


def _number(value: float) -> str:
    return f"{value:.{_DIGITS}g}" if abs(value) < 1000 else f"{value:.0f}"


def _day(date: str) -> str:
    return date.split(" ")[0]
