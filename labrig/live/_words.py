"""What a look says, in one line."""

import math

from labrig._text import counted, word
from labrig.live._look import Look

_MOST = 4
_WORTH = 0.05


def look_line(look: Look) -> str:
    """A look as one line: the likeliest effects, the error, the floor, and what is left to gain."""
    likely = sorted(look.probability.items(), key=lambda item: -item[1])
    shown = [f"{word(name)} {p:.2f}" for name, p in likely[:_MOST] if p >= _WORTH]
    said = ", ".join(shown) or "no effect stands out"
    if look.verdict == "underpowered":
        said = "too few captures to say"
    figures = [("error", look.error), ("floor", look.floor), ("left to gain", look.left)]
    errors = ", ".join(f"{name} {value:.3g} {look.units}" for name, value in figures if math.isfinite(value))
    return f"diagnosis of {counted(look.captures, 'capture')}: {said}" + (f"; {errors}" if errors else "")
