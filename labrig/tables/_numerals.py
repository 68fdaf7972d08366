"""How numbers are written: which sign is the decimal one, and which stands between thousands."""

import re
from collections.abc import Sequence
from functools import cache
from typing import TYPE_CHECKING

import numpy as np

if TYPE_CHECKING:
    import pandas as pd

MINUS = "\u2212"
"""What some programs write before a number below zero."""
_SIGNS = ".,'\u2019 \u00a0\u2009\u202f"
"""What stands between groups of three digits in one country or another."""
_CALLED = {".": "dot", ",": "comma"}
_SEVERAL = 4
"""Columns of which no number is without a sign before three digits, from which on it is the decimal sign."""
_TINY = r"(?:[eE][+-]?\d+)?"


@cache
def numeral(decimal: str) -> re.Pattern[str]:
    """What a number looks like that has this decimal sign, with signs between its thousands or without."""
    d, others = re.escape(decimal), re.escape(_SIGNS.replace(decimal, ""))
    parted = rf"[1-9]\d{{0,2}}([{others}])\d{{3}}(?:\1\d{{3}})*(?:{d}\d*)?"
    return re.compile(rf"[+-]?(?:\d+(?:{d}\d*)?|{d}\d+|{parted}){_TINY}")


def sign_between(cells: Sequence[str], decimal: str) -> str | None:
    """The sign between the thousands of a column, given its cells; None where it has none, or they do not agree.

    They agree where it stands before groups of three digits only, and no number of four digits does without it.
    """
    every = "\n".join(cells)
    for sign in _SIGNS.replace(decimal, ""):
        if sign not in every:
            continue
        own = [cell for cell in cells if sign in cell]
        parted = _parted(sign, decimal)
        if all(parted.fullmatch(cell) for cell in own) and not _without(every, decimal):
            return sign
    return None


@cache
def _parted(sign: str, decimal: str) -> re.Pattern[str]:
    d = re.escape(decimal)
    return re.compile(rf"[+-]?[1-9]\d{{0,2}}(?:{re.escape(sign)}\d{{3}})+(?:{d}\d*)?{_TINY}")


def _without(every: str, decimal: str) -> bool:
    """Whether some cell, one a line, has four digits or more that no sign parts."""
    return re.search(rf"^[+-]?\d{{4,}}(?:{re.escape(decimal)}\d*)?$", every, re.MULTILINE) is not None


def with_points(text: "pd.Series", decimal: str, thousands: str | None) -> "pd.Series":
    """Cells of text as programs write numbers: with decimal points, and no sign between thousands.

    A point where it is not the decimal sign becomes that sign: such a cell is no number then.
    """
    if thousands:
        text = text.str.replace(thousands, "", regex=False)
    if decimal != ".":
        text = text.str.translate(str.maketrans({decimal: ".", ".": decimal}))
    return text


def as_cells(values: "pd.Series", decimal: str) -> "pd.Series":
    """The cells of a column as text, as they are written; a number among them gets the decimal sign of the table."""
    import pandas as pd

    text: pd.Series = values.astype(str).str.strip().str.replace(MINUS, "-", regex=False)
    if decimal != "." and pd.api.types.infer_dtype(values, skipna=True) != "string":
        written = values.map(lambda cell: isinstance(cell, str)).astype(bool)
        text = text.where(written, text.str.replace(".", decimal, regex=False))
    return text


def decimal_of(columns: Sequence[Sequence[str]], quoted: bool) -> str:
    """The decimal sign of a table, given the numbers of its columns: the one that fewer columns speak against.

    Else the one that more numbers have; `quoted` is one with commas between its cells, whose numbers with a comma stand
    in quotes: there it parts thousands where it can.
    """
    against = {sign: sum(_against(cells, sign) for cells in columns) for sign in ".,"}
    if against["."] != against[","]:
        return min(against, key=lambda sign: against[sign])
    dots, commas = (sum(sign in cell for cells in columns for cell in cells) for sign in ".,")
    return "," if commas > dots and not (quoted and not against[","]) else "."


def in_doubt(columns: Sequence[Sequence[str]], decimal: str) -> str:
    """What is said of numbers with a decimal sign that may as well part thousands; empty where something tells."""
    own = next((cell for cells in columns for cell in cells if decimal in cell), "")
    other = "." if decimal == "," else ","
    with_it = [cells for cells in columns if any(decimal in cell for cell in cells)]
    if len(with_it) >= _SEVERAL and all(decimal in cell for cells in with_it for cell in cells):
        return ""  # thousands are below 1000 here and there
    if not own or any(_against(cells, other) for cells in columns):
        return ""
    return (
        f"the {_CALLED[decimal]} in {own!r} is read as a decimal sign; if it parts thousands, write "
        f"'decimal: \"{other}\"' under 'format:'"
    )


def said_of(columns: Sequence[str], cells: Sequence[str], sign: str) -> str:
    """What is said of columns with a sign between the thousands of their numbers, given the cells of the first."""
    own = next(cell for cell in cells if sign in cell)
    more = f" (and {len(columns) - 1} more)" if len(columns) > 1 else ""
    return (
        f"the {_CALLED.get(sign, 'sign')} in {own!r} of column {columns[0]!r}{more} is taken to part thousands; "
        "correct 'decimal:' under 'format:' if not"
    )


def why_no_number(cell: object, decimal: str) -> str:
    """What to say behind a cell that is no number, where it would be one with the other decimal sign; else empty."""
    other = "." if decimal == "," else ","
    if not isinstance(cell, str) or other not in cell or not numeral(other).fullmatch(cell.strip()):
        return ""
    return f" where {decimal!r} is the decimal sign"


def _against(cells: Sequence[str], decimal: str) -> bool:
    """Whether the numbers of a column can't be read with a decimal sign, or are hardly written with it."""
    sign = sign_between(cells, decimal)
    for cell in cells:
        other = next((s for s in ".," if s != decimal and s in cell), None)
        if not numeral(decimal).fullmatch(cell) or (other is not None and other != sign):
            return True
    return _parts_thousands(cells, decimal)


def _parts_thousands(cells: Sequence[str], sign: str) -> bool:
    """Whether a sign stands before three digits, the last a zero in some, and never in what are by far larger numbers
    then: 300, 600, 1.200. One whole number that comes again and again (-999) stands where there is none.
    """
    other = "." if sign == "," else ","
    if sign_between(cells, other) != sign:
        return False
    own = [cell for cell in cells if sign in cell]
    whole = [abs(float(cell)) for cell in cells if cell.lstrip("+-").isdigit() and float(cell)]
    if len(whole) > 1 and len(set(whole)) == 1:
        return False
    largest = max(abs(float(cell.replace(sign, "."))) for cell in own)
    return bool(whole) and any(cell.endswith("0") for cell in own) and float(np.median(whole)) > largest
