"""Lists of captures and names for a warning: the first few, and that there are more."""

from collections.abc import Sequence

from labrig.arrays import Ints

_NAMED = 4


def in_captures(captures: Ints) -> str:
    """`3 captures (4, 9, 20)`, of more than a few `35 captures (25, 26, 27, 28, ...)`."""
    several = "captures" if len(captures) > 1 else "capture"
    return f"{len(captures)} {several} ({first_few([str(c) for c in captures])})"


def first_few(words: Sequence[str]) -> str:
    """The first few of them, and dots for the others."""
    return ", ".join([*words[:_NAMED], *(["..."] if len(words) > _NAMED else [])])
