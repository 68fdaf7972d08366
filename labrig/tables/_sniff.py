"""How a text table is written, by its first lines: separator, header, units below it, decimal sign."""

import csv
import re
from collections import Counter
from pathlib import Path

from labrig._errors import LabrigError
from labrig.tables._mapping import Format
from labrig.tables._names import is_unit
from labrig.tables._text import SEPARATORS, find_encoding

_LINES = 200
_LONGEST = 1 << 16
_NUMBER = re.compile(r"[+-]?(\d+([.,]\d*)?|[.,]\d+)([eE][+-]?\d+)?")
_CHOICES = {",": ",", ";": ";", "tab": "\t", "|": "|", "whitespace": None}


def sniff(path: Path) -> Format:
    """The format of a text table; raises `LabrigError` for a file without rows, or that is no text."""
    encoding = find_encoding(path)
    with path.open(encoding=encoding, errors="replace", newline=None) as file:
        lines = [line for _ in range(_LINES) if (line := file.readline(_LONGEST))]
    lines = [line.rstrip("\r\n") for line in lines]
    if not any(line.strip() for line in lines):
        raise LabrigError(f"{path}: has no rows")
    if len(lines) == _LINES:
        lines = lines[:-1]
    separator = max(_CHOICES, key=lambda name: _score(lines, name))
    cells = [_split(line, separator) for line in lines]
    width = _width(cells)
    first = _first_row(cells, width)
    if first is None:
        raise LabrigError(
            f"{path}: no row of numbers in its first {len(lines)} lines; is it a table of measurements?"
        )
    above = next((i for i in range(first - 1, -1, -1) if any(c.strip() for c in cells[i])), None)
    header = above is not None and len(cells[above]) == width
    units_row = False
    if header and above and len(cells[above - 1]) == width and _are_units(cells[above]):
        units_row, above = True, above - 1
    skip = above if header and above is not None else first
    body = [row for row in cells[first:] if len(row) == width]
    return Format(
        separator=separator,
        header=header,
        units_row=units_row,
        decimal="," if separator != "," and _commas(body) else ".",
        encoding=None if encoding in {"utf-8", "utf-8-sig"} else encoding,
        skip_rows=skip,
    )


def _split(line: str, separator: str) -> list[str]:
    if separator == "whitespace":
        return line.split()
    try:
        return next(csv.reader([line], delimiter=SEPARATORS.get(separator, separator), skipinitialspace=True))
    except (csv.Error, StopIteration):
        return [line]


def _width(cells: list[list[str]]) -> int:
    """The commonest number of cells, of the rows that hold numbers."""
    widths = Counter(len(row) for row in cells if any(_is_number(c) for c in row))
    return widths.most_common(1)[0][0] if widths else 0


def _score(lines: list[str], separator: str) -> tuple[float, int]:
    """How many rows have the commonest number of cells, all numbers or empty; then how many cells those are."""
    cells = [_split(line, separator) for line in lines if line.strip()]
    width = _width(cells)
    if width == 0:
        return 0.0, 0
    alike = [row for row in cells if len(row) == width]
    numbers = sum(sum(_is_number(c) for c in row) for row in alike)
    share = numbers / max(sum(len(row) for row in cells), 1)
    return round(share, 1) * (width > 1), width


def _first_row(cells: list[list[str]], width: int) -> int | None:
    """The first row that has numbers, where the next one has numbers in the same cells."""
    marks = [[_is_number(c) for c in row] if len(row) == width else [] for row in cells]
    for i, own in enumerate(marks):
        if not any(own):
            continue
        later = [m for m in marks[i + 1 : i + 6] if m]
        if not later or any(sum(a and b for a, b in zip(own, m, strict=True)) >= 0.5 * sum(m) for m in later):
            return i
    return None


def _are_units(row: list[str]) -> bool:
    filled = [c.strip().strip("[]()") for c in row if c.strip().strip("[]()")]
    return bool(filled) and all(is_unit(c) or c in {"-", "1"} for c in filled)


def _commas(body: list[list[str]]) -> bool:
    with_comma = sum("," in c and _is_number(c) for row in body for c in row)
    with_dot = sum("." in c and _is_number(c) for row in body for c in row)
    return with_comma > with_dot


def _is_number(cell: str) -> bool:
    cell = cell.strip()
    return bool(cell) and (_NUMBER.fullmatch(cell) is not None or cell.lower() in {"nan", "inf", "-inf"})
