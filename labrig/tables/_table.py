"""One foreign table in memory: its columns as numbers or labels; every complaint names the file, row and column."""

from collections.abc import Collection, Mapping, Sequence
from dataclasses import dataclass, field
from pathlib import Path
from typing import TYPE_CHECKING, Any

import numpy as np
from numpy.typing import NDArray

from labrig._errors import LabrigError
from labrig.arrays import Floats, Ints
from labrig.tables._dates import Stamps, UnreadableError, as_text, read_stamps
from labrig.tables._numerals import as_cells, said_of, sign_between, why_no_number, with_points
from labrig.tables._units import same

if TYPE_CHECKING:
    import pandas as pd

DATE = "date"
"""The `unit` of a time column that holds dates and times of day."""
MINUTES = "min:s"
"""The `unit` of a time column that holds minutes and seconds, 12:34.5."""
_LONG = 40


_WORDS = (
    "nan",
    "-nan",
    "nan(ind)",
    "-nan(ind)",
    "na",
    "n/a",
    "n.a.",
    "<na>",
    "none",
    "null",
    "nil",
    "missing",
    "undefined",
    "ol",
    "+ol",
    "-ol",
    "o.l.",
    "ovl",
    "ovld",
    "over",
    "overload",
    "overrange",
    "k.a.",
    "n.d.",
    "err",
    "error",
)
_OF_SHEETS = (
    "#n/a",
    "#nv",
    "#na",
    "#wert!",
    "#value!",
    "#div/0!",
    "#num!",
    "#zahl!",
    "#null!",
    "#ref!",
    "#bezug!",
)
_SIGNS = r"[^\w]*"
NOTHING = frozenset((*_WORDS, *_OF_SHEETS))
"""What instruments, loggers and spreadsheets write, in any case, where they have no number."""


@dataclass(frozen=True)
class Table:
    """The rows of one file.

    Row i is row `first_row + i` as people count, or `lines[i]`; `row_is` is what a row is called there. Markers of C3D
    files appear as columns ``NAME.x`` in mm, their time as ``time_s``. `doubled` are names that more than one column
    has, `missing` what stands where there is no number, beside the usual words; `said` is what was left out.
    """

    path: Path
    frame: "pd.DataFrame"
    first_row: int = 1
    decimal: str = "."
    row_is: str = "row"
    doubled: frozenset[str] = field(default_factory=frozenset)
    missing: frozenset[str] = field(default_factory=frozenset)
    lines: Ints | None = field(default=None, repr=False)
    said: tuple[str, ...] = ()
    units: Mapping[str, str] = field(default_factory=dict)
    """The units that stood in the cells of columns, or in a row below their names."""
    absolute: frozenset[str] = field(default_factory=frozenset)
    """The columns of which such a unit says that they are absolute pressures."""

    def numbers(
        self,
        column: str | int,
        what: str,
        *,
        required: bool = False,
        thousands: str | None = None,
        unit: str | None = None,
    ) -> Floats:
        """A column as floats; `thousands` is the sign between groups of three digits, where its cells do not tell.

        Raises `LabrigError` for a missing column, text, (if required) a gap, or a table that says another `unit`.
        """
        import pandas as pd

        values = self._column(column, what)
        own = self.units.get(str(column))
        if own is not None and unit is not None and "1" not in {own, unit} and not same(own, unit):
            raise LabrigError(
                f"{self.path}: column {column!r} ({what}) is in {own}, as the table says, and in {unit}, as the "
                f"mapping does; write {own}, or convert the column"
            )
        if values.dtype.kind in "fiub" and not thousands:
            out = np.array(values, dtype=float)
            out[np.isin(out, [float(word) for word in self.missing if _is_number(word)])] = np.nan
            blank = np.isnan(out)
        else:
            text = as_cells(values, self.decimal)
            blank = np.asarray(values.isna() | is_nothing(text, self.missing))
            thousands = thousands or sign_between(text[~blank].tolist(), self.decimal)
            text = with_points(text, self.decimal, thousands)
            out = np.asarray(pd.to_numeric(text.where(~blank), errors="coerce"), dtype=float)
        wrong = ~np.isfinite(out) & ~blank
        if wrong.any():
            i = int(np.flatnonzero(wrong)[0])
            found: Any = values.iloc[i]
            found = found if isinstance(found, str) else float(out[i]) if np.isinf(out[i]) else str(found)
            why = why_no_number(found, self.decimal)
            raise LabrigError(
                f"{self.at(i)}: column {column!r} ({what}) holds {short(found)}, not a number{why}"
            )
        if required and blank.any():
            i = int(np.flatnonzero(blank)[0])
            raise LabrigError(f"{self.at(i)}: column {column!r} ({what}) is empty or NaN; every row needs it")
        return out

    def dates(
        self, columns: Sequence[str | int], what: str, *, day_first: bool | None = None, minutes: bool = False
    ) -> Stamps:
        """The dates and times of the rows, in one column or in several; `day_first` and `minutes` as in `read_stamps`.

        Raises `LabrigError` for a missing column, or a cell that is neither.
        """
        cells = [self._column(column, what) for column in columns]
        names = ", ".join(repr(column) for column in columns)
        where = f"column{'s' if len(columns) > 1 else ''} {names} ({what})"
        try:
            out = read_stamps(cells, names, day_first=day_first, minutes=minutes)
        except UnreadableError as error:
            raise LabrigError(f"{self.path}: {where} {error}") from None
        wrong = np.flatnonzero(np.isnan(out.seconds))
        if len(wrong):
            i = int(wrong[0])
            found = (
                cells[0].iloc[i] if len(cells) == 1 else as_text([c.iloc[i : i + 1] for c in cells]).iloc[0]
            )
            raise LabrigError(f"{self.at(i)}: {where} holds {short(found)}, not a date")
        return out

    def labels(self, column: str | int, what: str) -> NDArray[np.object_]:
        """A column as text, empty where there is nothing; whole numbers without a decimal point; shape (rows,)."""
        import pandas as pd

        code, unique = pd.factorize(self._column(column, what), use_na_sentinel=True)
        names = [
            str(int(v)) if isinstance(v, float | np.floating) and float(v).is_integer() else str(v)
            for v in unique.tolist()
        ]
        return np.array([*names, ""], dtype=object)[code]

    def filled(self, column: str | int) -> "pd.Series":
        """The cells of a column that hold something, as text with decimal points, and no sign between thousands."""
        text = self._cells(column)
        return with_points(text, self.decimal, sign_between(text.tolist(), self.decimal))

    def parted(self, columns: Sequence[str | int]) -> list[str]:
        """What is said of those columns, if any, that have a sign between their thousands: one line."""
        found = {}
        for column in columns:
            if self.frame[column].dtype.kind not in "fiubMm":
                cells = self._cells(column).tolist()
                if sign := sign_between(cells, self.decimal):
                    found[str(column)] = cells, sign
        return [said_of([*found], *next(iter(found.values())))] if found else []

    def _cells(self, column: str | int) -> "pd.Series":
        """The cells of a column that hold something, as they are written."""
        values: Any = self.frame[column].dropna()
        text: Any = as_cells(values, self.decimal)
        return text[~is_nothing(text, self.missing)]

    def key(self, name: str) -> str | int:
        """The column that is called so as text: numbers stand for those of a table without names."""
        return next(c for c in self.frame.columns if str(c) == name)

    def at(self, i: int) -> str:
        """Where row i of the table is, for a complaint."""
        return f"{self.path}, {self.row_is} {i + self.first_row if self.lines is None else self.lines[i]}"

    def _column(self, column: str | int, what: str) -> "pd.Series":
        if column in self.doubled:
            raise LabrigError(
                f"{self.path}: two columns are called {column!r} ({what}); rename one of them in the file"
            )
        if column not in self.frame.columns:
            have = ", ".join(short(str(c), quote=False) for c in list(self.frame.columns)[:12])
            more = ", ..." if len(self.frame.columns) > 12 else ""
            raise LabrigError(f"{self.path}: has no column {column!r} ({what}); it has {have}{more}")
        values: Any = self.frame[column]
        return values


def is_nothing(text: "pd.Series", more: Collection[str] = ()) -> "pd.Series":
    """Where cells of text say that there is no number: in one of the usual words, or with signs alone."""
    return text.str.casefold().isin(NOTHING | {w.casefold() for w in more}) | text.str.fullmatch(_SIGNS)


def _is_number(word: str) -> bool:
    try:
        float(word)
    except ValueError:
        return False
    return True


def short(value: Any, *, quote: bool = True) -> str:
    """A value as a complaint shows it: huge cells are cut."""
    text = repr(value) if quote else str(value)
    return text if len(text) <= _LONG + 8 else f"{text[:_LONG]}... ({len(text)} characters)"
