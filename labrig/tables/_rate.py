"""How many rows a second a text table says that it has, above its names: for those without a clock of their own."""

import re
from collections.abc import Sequence
from itertools import islice, pairwise
from pathlib import Path

from labrig.tables._mapping import Format
from labrig.tables._packed import open_text
from labrig.tables._text import find_encoding

_NUMBER = re.compile(r"\s*(\d+(?:[.,]\d+)?(?:e[+-]?\d+)?)\s*([a-zµ/]*)\s*", re.I)
_RATE = re.compile(
    r"(?:(?:export|capture|camera|analog|video|point|data|output|sampl\w*)[ _]?)?"
    r"(?:frame ?rate|frequency|freq|rate|frames per second|fps)",
    re.I,
)
_STEP = re.compile(r"(?:sampl\w*|time|data|output)[ _]?(?:interval|period|step)|dt|delta ?t", re.I)
_STEP_OF_LABVIEW = re.compile(r"delta_x", re.I)
_TIMED = re.compile(r"\s*x_dimension\s+time\b", re.I)
"""The line of a LabVIEW file that says that its Delta_X is a time."""
_EXPORTED = re.compile(r"export|output|data", re.I)
_HZ = {"": 1.0, "hz": 1.0, "fps": 1.0, "/s": 1.0, "khz": 1e3}
_S = {"": 1.0, "s": 1.0, "sec": 1.0, "seconds": 1.0, "ms": 1e-3, "us": 1e-6, "µs": 1e-6}
_OF_NEXUS = {"trajectories", "devices", "model outputs", "joints", "segments"}
"""What stands in the first line of an export of Vicon Nexus; its second is the rate."""
_BRACKETS = re.compile(r"\s*[\[(]([^\])]*)[\])]\s*$")
_CELLS = re.compile(r"[;\t]|:\s|\s=\s|=")
_WITH_COMMAS = re.compile(rf",|{_CELLS.pattern}")


def rate_above(path: Path, how: Format) -> tuple[float, int] | None:
    """The rows a second (Hz) that a line above the names says, and the number of that line; None where none does.

    Of several rates that of what was exported counts, else the first.
    """
    encoding = how.encoding or find_encoding(path)
    with open_text(path, encoding, "replace") as file:
        lines = [line.strip() for line in islice(file, how.skip_rows)]
    steps = [_STEP, *([_STEP_OF_LABVIEW] if any(_TIMED.match(line) for line in lines) else [])]
    found = []
    for number, line in enumerate(lines, start=1):
        for pattern in (_CELLS, _WITH_COMMAS):  # 0,1 s is no 0 s
            cells = [cell.strip(" \"'#%") for cell in pattern.split(line)]
            own = [
                (rate, number, name)
                for name, cell in pairwise(cells)
                if (rate := _rate_of(name, cell, steps))
            ]
            if own:
                found += own
                break
    for number, (line, below) in enumerate(pairwise(lines), start=2):
        if line.strip(',;\t "').casefold() in _OF_NEXUS and (
            rate := _rate_of("rate", below.strip(',;\t "'), steps)
        ):
            found.append((rate, number, "rate"))
    exported = [one for one in found if _EXPORTED.match(one[2])]
    return next(((rate, number) for rate, number, _ in exported or found), None)


def _rate_of(name: str, cell: str, steps: Sequence[re.Pattern[str]]) -> float | None:
    """What a cell behind a name says of the rate, Hz; the unit is in brackets behind the name, or behind the number.

    `steps` are what the time between two rows may be called.
    """
    unit = _BRACKETS.search(name)
    name = name[: unit.start()] if unit else name
    number = _NUMBER.fullmatch(cell)
    known = _HZ if _RATE.fullmatch(name) else _S if any(one.fullmatch(name) for one in steps) else None
    if number is None or known is None:
        return None
    scale = known.get((number[2] or (unit[1] if unit else "")).strip().casefold())
    value = float(number[1].replace(",", ".")) * (scale or 0.0)
    if value <= 0:
        return None
    return value if known is _HZ else 1.0 / value
