"""Columns of a foreign table that hold words: what is said of those that are left out, and which can't be."""

from collections.abc import Callable, Sequence
from typing import Any

import numpy as np

from labrig._errors import LabrigError
from labrig.tables._names import Name
from labrig.tables._numerals import why_no_number
from labrig.tables._table import Table, short


def words_among(table: Table, column: Any) -> str:
    """What a column holds that has numbers in most of its rows, and other words in some; empty for any other."""
    import pandas as pd

    if table.frame[column].dtype.kind in "fiubMm":
        return ""
    text = table.filled(column)
    words: Any = text[np.isnan(np.asarray(pd.to_numeric(text, errors="coerce"), dtype=float))]
    if not len(words) or len(words) > 0.5 * len(text):
        return ""
    row = int(words.index[0])
    first = str(table.frame[column][row]).strip()
    where = table.at(row).removeprefix(f"{table.path}, ")
    return (
        f"holds numbers, but in {len(words)} of {len(table.frame)} cells words, first {short(first)} in {where} "
        f"(missing: [{short(first)}] under 'format:' makes them missing),"
    )


def no_numbers(table: Table, column: Any) -> str:
    """What a column holds that has no numbers, or none with the decimal sign of the table."""
    import pandas as pd

    seen = table.frame[column].dropna()
    first = seen.iloc[0]
    why = why_no_number(first, table.decimal)
    if why:
        return f"holds {short(first)}, no number{why},"
    label, found = pd.factorize(seen)
    together = int((np.diff(label) != 0).sum()) + 1 == len(found)
    if together and 1 < len(found) < len(label) / 2:  # specimens or days, one behind the other
        return f"holds no numbers (if it names specimens or days, 'session: {{column: {column}}}' says so)"
    return "holds no numbers"


def refuse_worded(table: Table, worded: Sequence[Name], needed: Callable[[Name], bool], what: str) -> None:
    """Raise `LabrigError` for the first of the columns with `worded` cells that is `needed`: called `what`."""
    if (n := next(filter(needed, worded), None)) is not None:
        raise LabrigError(
            f"{table.path}: column {n.column!r} is called {what}, and "
            f"{words_among(table, table.key(n.column)).rstrip(',')}; correct them, or write a mapping "
            "(docs/how-to/your-data.md)"
        )
