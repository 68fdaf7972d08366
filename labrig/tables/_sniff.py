"""How a text table is written, by its first lines: separator, header, units below it, decimal sign."""

from collections import Counter
from itertools import pairwise
from pathlib import Path

from labrig._errors import LabrigError
from labrig.tables._header import groups_above, split, too_many
from labrig.tables._labelled import LABELS, is_labelled
from labrig.tables._mapping import Format
from labrig.tables._names import is_unit
from labrig.tables._numerals import decimal_of, in_doubt, numeral
from labrig.tables._packed import open_text
from labrig.tables._read import readable
from labrig.tables._text import find_encoding

_LINES = 200
_ABOVE = 12
"""Lines above the first row among which its names are looked for."""
_FEW = 3
_LONGEST = 1 << 16
_USUAL = {"utf-8", "utf-8-sig"}
_ENDS = "0123456789.,"
"""What the last character of a number is; nan and inf end otherwise."""
_ARROW = " -> "
_CHOICES = {",": ",", ";": ";", "tab": "\t", "|": "|", "whitespace": None}


def sniff(path: Path) -> Format:
    """The format of a text table; raises `LabrigError` for a file without rows, or that is no text."""
    lines, encoding = _first_lines(path)
    if not any(line.strip() for line in lines):
        raise LabrigError(f"{path}: has no rows")
    if is_labelled(lines):
        return Format(separator=LABELS, encoding=None if encoding in _USUAL else encoding)
    scores = {name: _score(lines, name) for name in _CHOICES}
    if sum(_ARROW in line for line in lines) > len(lines) / 2:
        scores = {"arrow": _score(lines, "arrow")}
    drawn = {name: score for name, score in scores.items() if _CHOICES.get(name) and score[0] >= 0.5}
    if _is_tabbed(lines):
        drawn = {"tab": scores["tab"]}
    separator = max(drawn or scores, key=lambda name: scores[name])
    cells = [split(line, separator) for line in lines]
    found = layout(cells)
    if found is None:
        raise LabrigError(
            f"{path}: no row of numbers in its first {len(lines)} lines; is it a table of measurements?"
        )
    first, how = found
    width = _width(cells)
    body = [row for row in cells[first:] if len(row) == width]
    if separator == "," and not how.header and (named := _names_of_fewer(cells[:first], body)):
        raise LabrigError(f"{path}, line {first + 1}: {too_many(width, named, separator)}")
    return how.model_copy(
        update={
            "separator": separator,
            "decimal": decimal_of(numbers_in(body), quoted=separator == ","),
            "encoding": None if encoding in _USUAL else encoding,
        }
    )


def _is_tabbed(lines: list[str]) -> bool:
    """Whether most lines have tabs between numbers, so that a comma stands within these; empty cells are no matter."""
    cells = [cell for line in lines for cell in split(line, "tab") if cell.strip()]
    tabs = sum("\t" in line for line in lines)
    return 2 * tabs > len(lines) and 2 * sum(map(_is_number, cells)) > len(cells)


def sign_in_doubt(path: Path, how: Format) -> str:
    """What is said of a text table whose decimal sign may as well part thousands; empty where its numbers tell."""
    if how.separator == LABELS:
        return ""
    cells = [split(line, how.separator) for line in _first_lines(path)[0]]
    return in_doubt(numbers_in([row for row in cells if len(row) == _width(cells)]), how.decimal)


def left_above(path: Path, how: Format) -> str:
    """What is said of lines of numbers above the first that is read; empty where there are none, or names between."""
    if how.header or not how.skip_rows:
        return ""
    cells = [split(line, how.separator) for line in _first_lines(path)[0][: how.skip_rows]]
    lines = sum(sum(_is_number(c) for c in row) > 1 for row in cells)
    return f"{lines} lines of numbers above have another number of cells, and are left out" if lines else ""


def _first_lines(path: Path) -> tuple[list[str], str]:
    """The first lines of a text file, all of them whole, and its encoding."""
    with readable(path, "text"), open_text(path, encoding := find_encoding(path), "replace") as file:
        lines = [line.rstrip("\r\n") for _ in range(_LINES) if (line := file.readline(_LONGEST))]
    return (lines[:-1] if len(lines) == _LINES else lines), encoding


def layout(cells: list[list[str]]) -> tuple[int, Format] | None:
    """The first row of numbers of some lines of cells, and where their names and units are; None without such a row."""
    width = _width(cells)
    first = _first_row(cells, width)
    if first is None:
        return None
    first = _below_settings(cells, first, width)
    top = _header(cells, first, width)
    groups = [] if top is None else groups_above(_block(cells, top, width))
    if top is not None and len(groups) == 1 and _all_differ(cells[top - groups[0]], width):
        top, groups = top - groups[0], []
    units_row = top is not None and top + 1 < first and _are_units(cells[top + 1])
    skip = first if top is None else top
    return first, Format(header=top is not None, units_row=units_row, skip_rows=skip, groups=groups)


def _header(cells: list[list[str]], first: int, width: int) -> int | None:
    """The line of the names: the nearest above the first row that has as many cells, most of them words that are no
    units and not all alike; none where a line between has numbers.
    """
    for i in range(first - 1, max(first - _ABOVE, 0) - 1, -1):
        row = cells[i]
        words = [c.strip() for c in row if c.strip()]
        if not words:
            continue
        if sum(_is_number(c) for c in words) > 1:
            return None
        fits = len(row) == width or len(_filled(row)) == width or width in (len(row) + 1, len(row) - 1)
        alike = len(words) > _FEW and len(set(words[1:])) == 1
        if fits and len(words) >= width / 2 and not alike and not (_are_units(row) and i > 0):
            return i
    return None


def _names_of_fewer(above: list[list[str]], body: list[list[str]]) -> int:
    """How many names the line right above some rows has, where their cells are its columns with some decimal commas
    that part them: digits behind a number without a point. 0 where it is no such line.
    """
    names = [cell.strip() for cell in above[-1]] if above else []
    told = len(names) > 1 and all(names) and len(set(names)) == len(names)
    if not told or any(map(_is_number, names)):
        return 0
    whole = [all(c.strip().lstrip("+-").isdigit() for c in column) for column in zip(*body, strict=True)]
    signed = [any(c.strip()[:1] in "+-" for c in column) for column in zip(*body, strict=True)]
    parts = i = 0
    while i + 1 < len(whole):
        pair = whole[i] and whole[i + 1] and not signed[i + 1]
        parts, i = parts + pair, i + 1 + pair
    return len(names) if 0 < len(whole) - len(names) <= parts else 0


def _all_differ(row: list[str], width: int) -> bool:
    return len(row) >= width and all(c.strip() for c in row[:width]) and len(set(row[:width])) == width


def _block(cells: list[list[str]], top: int, width: int) -> list[list[str]]:
    """The lines above the names that may say what several of them belong to, and the names."""
    start = top
    while start > max(top - _ABOVE, 0) and any(c.strip() for c in cells[start - 1]):
        start -= 1
    return [row[:width] + [""] * (width - len(row)) for row in cells[start : top + 1]]


def _filled(row: list[str]) -> list[str]:
    """A row without the empty cells at its end."""
    while row and not row[-1].strip():
        row = row[:-1]
    return row


def _width(cells: list[list[str]]) -> int:
    """The commonest number of cells, of the rows that hold numbers."""
    widths = Counter(len(row) for row in cells if any(_is_number(c) for c in row))
    return widths.most_common(1)[0][0] if widths else 0


def _score(lines: list[str], separator: str) -> tuple[float, int]:
    """How many rows have the commonest number of cells, all numbers or empty; then how many cells those are."""
    cells = [split(line, separator) for line in lines if line.strip()]
    width = _width(cells)
    if width == 0:
        return 0.0, 0
    alike = [row for row in cells if len(row) == width]
    numbers = sum(sum(_is_number(c) for c in row) for row in alike)
    share = numbers / max(sum(len(row) for row in cells), 1)
    return round(share, 1) * (width > 1), width


def _first_row(cells: list[list[str]], width: int) -> int | None:
    """The first row that has numbers, where the next ones have numbers in the same cells: of a few, or else of one."""
    marks = [[_is_number(c) for c in row] if len(row) == width else [] for row in cells]

    def alike(one: list[bool], other: list[bool]) -> bool:
        both = sum(a and b for a, b in zip(one, other, strict=False))
        return any(one) and both >= 0.5 * max(sum(other), 1)

    goes_on = [alike(one, other) for one, other in pairwise(marks)]
    for i in range(len(goes_on) - _FEW + 1):
        if all(goes_on[i : i + _FEW]):
            return _before_notes(cells, i, width)
    for i, own in enumerate(marks):
        later = [m for m in marks[i + 1 : i + 6] if m]
        if any(own) and (not later or any(alike(own, m) for m in later)):
            return i
    return None


def _below_settings(cells: list[list[str]], first: int, width: int) -> int:
    """The first row below settings, each a row with its name before it (`Width (mm);6;;`), and a line of names; or the
    one that was `first`, where there are none.
    """
    for i, row in enumerate(cells[first:], start=first):
        if row[:1] and _is_number(row[0]):
            return first
        if len(row) == width and all(c.strip() and not _is_number(c) for c in row):
            rows = cells[i + 1 :]
            below = _first_row(rows, width)
            return first if below is None or not _is_number(rows[below][0]) else i + 1 + below
    return first


def _before_notes(cells: list[list[str]], first: int, width: int) -> int:
    """The first of the rows above one that are written as it is, but for blanks where nothing was measured, with notes
    between, but no names of columns.
    """

    def written(row: list[str]) -> list[bool | None]:
        return [_is_number(c) if c.strip() else None for c in row]

    like = written(cells[first])
    for i in range(first - 1, max(first - _ABOVE, 0) - 1, -1):
        own = written(cells[i])
        blank = own.count(True) > 1 and all(a is None or a == b for a, b in zip(own, like, strict=False))
        if own == like or (blank and len(own) == width):
            first = i
        elif len(cells[i]) == width and all(c.strip() for c in cells[i]):
            break
    return first


def _are_units(row: list[str]) -> bool:
    filled = [c.strip().strip("[]()") for c in row if c.strip().strip("[]()")]
    return bool(filled) and all(is_unit(c) or c in {"-", "1"} for c in filled)


def numbers_in(body: list[list[str]]) -> list[list[str]]:
    """The cells of each column of rows, all of one length, that are numbers."""
    columns = zip(*body, strict=True)
    return [[c.strip() for c in column if _is_number(c) and c.strip()[-1] in _ENDS] for column in columns]


def _is_number(cell: str) -> bool:
    cell = cell.strip()
    if any(numeral(decimal).fullmatch(cell) for decimal in ".,"):
        return True
    return cell.lower() in {"nan", "inf", "-inf"}
