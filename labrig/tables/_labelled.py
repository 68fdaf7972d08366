"""Logs in which each number has its name before it: `Setpoint:20.0,Angle:17.9`, as serial plotters want it."""

import re
from collections import Counter
from pathlib import Path

import numpy as np

from labrig._errors import LabrigError
from labrig.tables._dates import DATE
from labrig.tables._packed import open_text
from labrig.tables._table import Table

LABELS = "labels"
"""The `separator` of such a log."""
_MOST = 0.8
"""Share of the lines that have the same names, or it is no such log."""
_NUMBER = r"[+-]?(?:\d+\.?\d*|\.\d+)(?:[eE][+-]?\d+)?|nan"
_STAMP = rf"(?:{DATE})(?:[T ]\d{{1,2}}:\d{{2}}(?::\d{{2}}(?:[.,]\d+)?)?(?:Z|[+-]\d{{2}}:?\d{{2}})?)?"
"""A date with its time of day and zone: one value, in spite of its colons."""
_UNIT = r"[A-Za-z°%µ\u03bc][A-Za-z°%/0-9]{0,7}"
_GAP = r"[ \t]{0,9}"
"""Blanks within a line; few, so that a line of blanks takes no longer than another one."""
_PAIR = re.compile(
    rf"(?<![\w.])(?P<name>[^\W\d][\w ./()%°-]{{0,60}}?){_GAP}[:=]{_GAP}(?P<first>{_STAMP}|{_NUMBER})(?![\w.:])"
    rf"(?: ?(?P<unit>{_UNIT})(?={_GAP}(?:[,;\t|\r\n]|$)| {_GAP}[^\W\d]))?"
    rf"(?P<more>(?:{_GAP}[,; \t]{_GAP}(?:{_NUMBER})(?![\w.:]))*)"
)
_TO_DIGIT = re.compile(r"[^\w+-]*(?P<stamp>.*\d)")
_CELLS = re.compile(r"(?<!:\d\d),|[;\t]")
"""What parts cells, but no comma of a time of day: 13:05:02,123."""
_Cells = tuple[tuple[str, ...], tuple[str, ...]]


def is_labelled(lines: list[str]) -> bool:
    """Whether most lines that are not blank have numbers with the same names before them."""
    filled = [line for line in lines if line.strip()]
    names = Counter(_cells(line)[0] for line in filled)
    del names[()]
    return bool(names) and names.most_common(1)[0][1] >= _MOST * len(filled)


def read_labelled(path: Path, encoding: str, rows: int | None) -> Table:
    """The lines with the commonest names, a column for each; what is written before the first name is `time`.

    Raises `LabrigError` where no line has a name before a number.
    """
    import pandas as pd

    with open_text(path, encoding) as file:
        found = [(number, *_cells(line)) for number, line in enumerate(file, start=1) if line.strip()]
    count = Counter(names for _, names, _ in found)
    del count[()]
    if not count:
        raise LabrigError(f"{path}: no line has a number with its name before it, such as angle:12.3")
    names = count.most_common(1)[0][0]
    kept = [(number, cells) for number, own, cells in found if own == names][:rows]
    frame = pd.DataFrame([cells for _, cells in kept], columns=list(names))
    for column in frame.columns:
        if frame[column].str.fullmatch(_NUMBER).all():
            frame[column] = pd.to_numeric(frame[column])
    other = [number for number, own, _ in found if own != names] if rows is None else []
    said = (f"{len(other)} lines without these names are left out (first line {other[0]})",) if other else ()
    lines = np.array([number for number, _ in kept])
    return Table(path, frame, int(lines[0]), ".", "line", lines=lines, said=said)


def _cells(line: str) -> _Cells:
    """The names of a line's numbers, and the numbers; empty where it has none with a name."""
    pairs = list(_PAIR.finditer(line))
    if not pairs:
        return (), ()
    ahead = line[: pairs[0].start()]
    if sum(any(c.isdigit() for c in cell) for cell in _CELLS.split(ahead)) > 1:
        return (), ()  # other cells without a name: a table, one column of which has words in it
    before = _TO_DIGIT.match(ahead)
    names, cells = (["time"], [before["stamp"]]) if before else ([], [])
    for pair in pairs:
        name = pair["name"].strip()
        more = re.findall(_NUMBER, pair["more"])
        called = f"{name} [{pair['unit']}]" if pair["unit"] else name
        names += [called if not i else f"{name} {i + 1}" for i in range(1 + len(more))]
        cells += [pair["first"], *more]
    return (tuple(names), tuple(cells)) if len(set(names)) == len(names) else ((), ())
