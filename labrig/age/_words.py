"""A change in a sentence."""

import math
from collections.abc import Mapping
from typing import Any

_DIGITS = 3


def change_words(change: Mapping[str, Any]) -> str:
    """What changed, from what to what, and since when."""
    when = f"since {_day(change['date'])}"
    if change["group"] in ("marker", "frame"):
        moved = math.dist(change["before"], change["after"])
        what = change["name"] if change["group"] == "marker" else "the cameras"
        how = "turned" if change["name"] == "turn" else "moved"
        slowly = "slowly " if change["shape"] == "slope" else ""
        return f"{what} {slowly}{how} by {_number(moved)} {change['unit']} {when}"
    before, after = change["before"][0], change["after"][0]
    unit = f" {change['unit']}"
    way = "grows" if after > before else "falls"
    verb = f"{way} from {_number(before)} to {_number(after)}{unit}" if change["shape"] == "slope" else ""
    verb = verb or f"went from {_number(before)} to {_number(after)}{unit}"
    return f"{_subject(change)} {verb} {when}"


def _subject(change: Mapping[str, Any]) -> str:
    name = str(change["name"])
    return {
        "effect": name,
        "gain": "the whole displacement",
        "error": "the model's error",
        "floor": "the noise floor",
        "leak": f"the leak of {name}",
        "zero": f"the zero of {name}",
        "lost": "markers lost",
        "ambient": name,
    }[str(change["group"])]


def _number(value: float) -> str:
    return f"{value:.{_DIGITS}g}" if abs(value) < 1000 else f"{value:.0f}"


def _day(date: str) -> str:
    return date.split(" ")[0]
