"""The names of a text table's columns: one line of them, or more, where one above says what some have in common."""

import csv
import re
from itertools import combinations, islice, pairwise
from pathlib import Path

from labrig._errors import LabrigError
from labrig.tables._mapping import Format
from labrig.tables._packed import open_text
from labrig.tables._table import short

SEPARATORS = {"whitespace": r"\s+", "tab": "\t", "arrow": r"\s*(?:->|[,;\t])\s*"}
"""By name; with `arrow` each line begins with its time and `->`, as a serial monitor writes it."""
_COMMENT = {"#", "%", "//", ";"}
_LABELS = {"name", "bodyparts", "scorer"}
"""What stands before the names of bodies and markers, over columns that are none of them."""
_TOGETHER = 2
"""Lines above the names that may be needed to tell columns apart: a body, and what of it."""


def split(line: str, separator: str) -> list[str]:
    """The cells of one line; a sign of a comment that stands alone before names is none."""
    if separator == "whitespace":
        cells = line.split()
        return cells[1:] if cells and cells[0] in _COMMENT else cells
    if separator == "arrow":
        return re.split(SEPARATORS[separator], line.strip())
    try:
        return next(csv.reader([line], delimiter=SEPARATORS.get(separator, separator), skipinitialspace=True))
    except (csv.Error, StopIteration):
        return [line]


def begins_with_a_comment(path: Path, how: Format) -> bool:
    """Whether the line of the names begins with the sign of a comment."""
    with open_text(path, how.encoding, "replace") as file:
        return any(
            sign in line.split()[:1]
            for line in islice(file, how.skip_rows, how.skip_rows + 1)
            for sign in _COMMENT
        )


def groups_above(rows: list[list[str]]) -> list[int]:
    """How far above the last of some rows those are that tell columns of equal names, or without one, apart.

    None where its names do. A row that is labelled `Name` counts first, then the nearest.
    """
    width = len(rows[-1])
    if not any(rows[-1]):
        return []
    if _distinct(rows[-1]):
        return [1] if _names_axes(rows) else []
    far = [
        i
        for i, row in enumerate(reversed(rows[:-1]), start=1)
        if len(set(filter(None, row))) > 1 and len(row) > width / 2
    ]
    far.sort(key=lambda i: "name" not in [cell.strip().casefold() for cell in rows[-1 - i][:2]])
    for n in range(1, _TOGETHER + 1):
        for some in combinations(far, n):
            above = [rows[-1 - i] for i in sorted(some, reverse=True)]
            if _distinct(joined([*above, rows[-1]])):
                return sorted(some, reverse=True)
    return []


def _names_axes(rows: list[list[str]]) -> bool:
    """Whether names that are but x and y have the name of what is there above the first, and a blank above the second,
    as where a sheet's cells were merged.
    """
    if len(rows) < 2:
        return False
    own = [cell.strip().casefold() for cell in rows[-1]]
    over = [cell.strip() for cell in rows[-2]]
    return any(pair == ("x", "y") and over[i] and not over[i + 1] for i, pair in enumerate(pairwise(own)))


def _distinct(names: list[str]) -> bool:
    """Whether all names but those of the first two columns, which may be labels, are there and differ."""
    own = [name.strip() for name in names[2:]]
    return all(own) and len(set(names)) == len(names)


def joined(rows: list[list[str]]) -> list[str]:
    """The names of the last row, behind what the rows above say; an empty cell above is as the one to its left."""
    width, out = len(rows[-1]), [[] for _ in rows[-1]]
    for row in rows[:-1]:
        last = ""
        for i, cell in enumerate(islice(row, width)):
            last = cell.strip() or last
            if last and last.casefold() not in _LABELS:
                out[i].append(last)
    for i, name in enumerate(rows[-1]):
        if name.strip():
            out[i].append(name.strip())
    return [" ".join(parts) for parts in out]


def names_of(path: Path, how: Format, encoding: str, width: int) -> tuple[list[str], frozenset[str], int]:
    """The names of at least `width` columns, made different from each other, those that were not, and how many cells
    the line of names has.

    Raises `LabrigError` where there is no such line.
    """
    first = how.skip_rows - max(how.groups, default=0)
    if first < 0:
        raise LabrigError(
            f"{path}: there is no line {max(how.groups)} above its names: see 'format: groups:'"
        )
    with open_text(path, encoding) as file:
        lines = islice(file, first, None)
        if len(SEPARATORS.get(how.separator, how.separator)) > 1:
            rows = [split(line, how.separator) for line in islice(lines, how.skip_rows - first + 1)]
        else:
            reader = csv.reader(
                lines, delimiter=SEPARATORS.get(how.separator, how.separator), skipinitialspace=True
            )
            rows = list(islice(reader, how.skip_rows - first + 1))
    if len(rows) <= how.skip_rows - first:
        raise LabrigError(f"{path}: has no rows")
    raw = joined([*[rows[-1 - i] for i in how.groups], rows[-1]])
    return *distinct([*raw, *[""] * (width - len(raw))]), len(raw)


def too_many(cells: int, names: int, separator: str) -> str:
    """What is said of rows with more cells than there are names above them."""
    comma = (
        "if its decimal signs are commas, write points, or ';' between the cells; "
        if separator == ","
        else ""
    )
    rows = (
        "if its rows have numbers or names in front (R), write no such (row.names=FALSE); "
        if cells == names + 1
        else ""
    )
    return f"has {cells} cells under {names} names: {comma}{rows}else give each column a name"


def distinct(raw: list[str]) -> tuple[list[str], frozenset[str]]:
    """Names of columns, the second of two that are alike with its number behind it; and those that were alike."""
    names: list[str] = []
    doubled = set()
    taken = set(raw)
    for i, name in enumerate(raw):
        name = name if len(name) <= 200 else short(name, quote=False)
        if not name or name in names:
            if name:
                doubled.add(name)
            name = f"{name or 'column'}.{i}"
            while name in taken:
                name += "_"
        names.append(name)
        taken.add(name)
    return names, frozenset(doubled)
