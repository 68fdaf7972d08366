"""Lines of a text table that are no rows of it: notes between them, names that come again, a last one that was cut."""

from itertools import islice
from pathlib import Path
from typing import TYPE_CHECKING, Any

import numpy as np
from numpy.typing import NDArray

from labrig._errors import LabrigError
from labrig.tables._numerals import numeral
from labrig.tables._packed import open_text

if TYPE_CHECKING:
    import pandas as pd

_MANY = 10
_NAMED = 3


def cut_short(frame: "pd.DataFrame") -> bool:
    """Whether the last row was not written to its end: it has nothing in its last columns, where all others have."""
    blank = frame.isna().to_numpy()
    if len(blank) < _MANY or not blank[-1, -1]:
        return False
    own = blank[-1] & ~blank[:-1].any(axis=0)
    filled = np.flatnonzero(~blank[-1])
    return bool(own[-1] and own[filled.max(initial=-1) + 1 :].all())


def without_text(
    frame: "pd.DataFrame", first_row: int, decimal: str
) -> tuple["pd.DataFrame", NDArray[np.int64], list[str]]:
    """The rows that hold a number, the number of each as people count lines, and a line of what was left out.

    Columns of text that hold numbers only without the other rows become numbers.
    """
    import pandas as pd

    number = frame.select_dtypes("number").notna().any(axis=1).to_numpy()
    words = [column for column in frame.columns if frame[column].dtype.kind not in "fiubM"]
    for column in words:
        if number.all():
            break
        cells = frame[column].astype(str).str.strip()
        number = number | (_numbers(cells).notna() | cells.str.fullmatch(numeral(decimal))).to_numpy()
    lines = np.arange(len(frame)) + first_row
    if number.all() or not number.any():
        return frame, lines, []
    gone = lines[~number]
    blank = frame.isna().all(axis=1).to_numpy()
    out = frame.loc[number].reset_index(drop=True)
    for column in words:
        values = _numbers(out[column])
        if decimal == "." and bool((values.notna() == out[column].notna()).all()):
            out[column] = values
    said = [int(i) for i in lines[~number & ~blank]]
    if not said:
        return out, lines[number], []
    where = ", ".join(map(str, said[:_NAMED])) + (", ..." if len(said) > _NAMED else "")
    one = len(said) == 1
    line = f"line {where} holds no number and is" if one else f"{len(said)} lines hold no number and are"
    return (
        pd.DataFrame(out),
        lines[number],
        [f"{line} left out" + ("" if one else f" (line {where})")][: len(gone)],
    )


def _numbers(values: Any) -> Any:
    import pandas as pd

    return pd.to_numeric(values, errors="coerce")


def check_blanks(path: Path, encoding: str, skip: int, width: int, rows: int | None = None) -> None:
    """Raise `LabrigError` where a row of a table with blanks between its cells has too few: which one is not known.

    Of `rows`, where that is said, no line further down is looked at.
    """
    with open_text(path, encoding) as file:
        last = None if rows is None else skip + rows
        for i, line in enumerate(islice(file, last), start=1):
            cells = line.split()
            if i > skip and 0 < len(cells) < width and any(c.isdigit() for c in line):
                raise LabrigError(
                    f"{path}, line {i}: has {len(cells)} cells where others have {width}: with blanks between them, "
                    "which one is missing can't be told; write NaN there, or export it with commas"
                )
