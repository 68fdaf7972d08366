"""Text tables: CSV and its kin, in any encoding."""

import codecs
import itertools
import re
import warnings
from collections import Counter
from pathlib import Path
from typing import TYPE_CHECKING, Any

import numpy as np
from numpy.typing import NDArray

from labrig._errors import LabrigError
from labrig.tables._header import SEPARATORS, names_of, split, too_many
from labrig.tables._labelled import LABELS, read_labelled
from labrig.tables._lines import check_blanks, cut_short, without_text
from labrig.tables._mapping import Format
from labrig.tables._packed import open_bytes, open_text
from labrig.tables._table import Table

if TYPE_CHECKING:
    import pandas as pd

_BLOCK = 1 << 22
_MARKS = (
    (codecs.BOM_UTF8, "utf-8-sig"),
    (codecs.BOM_UTF32_LE, "utf-32"),
    (codecs.BOM_UTF32_BE, "utf-32"),
    (codecs.BOM_UTF16_LE, "utf-16"),
    (codecs.BOM_UTF16_BE, "utf-16"),
)
_OLD = ["cp1252", "cp1251", "cp932", "gb18030", "mac_roman"]
_FEW = 20
_LONGER = re.compile(r"Expected (?P<others>\d+) fields in line (?P<line>\d+), saw (?P<own>\d+)")
"""What pandas says of a row that has more cells than the first."""


def find_encoding(path: Path) -> str:
    """The encoding of a text file, by its first bytes and by what it can be decoded as.

    Raises `LabrigError` for a file that is no text.
    """
    with open_bytes(path) as file:
        head = file.read(1 << 16)
        for mark, name in _MARKS:
            if head.startswith(mark):
                return name
        if b"\x00" in head:
            zeros = head[1::2].count(0), head[::2].count(0)
            if max(zeros) > 0.4 * (len(head) / 2) and min(zeros) < 0.05 * (len(head) / 2):
                return "utf-16-le" if zeros[0] > zeros[1] else "utf-16-be"
            raise LabrigError(
                f"{path}: is no text and no table that labrig knows by its first bytes; "
                "save it as CSV, Excel, Parquet, HDF5, MAT or NPZ"
            )
        decoder = codecs.getincrementaldecoder("utf-8")()
        sample = b""
        block, valid = head, True
        while block:
            try:
                decoder.decode(block)
            except UnicodeDecodeError:
                valid = False
            if not block.isascii():
                sample += b"\n".join(line for line in block.splitlines() if not line.isascii())[: 1 << 14]
            if not valid:
                break
            block = file.read(_BLOCK)
    return "utf-8" if valid else _old_encoding(sample)


def _old_encoding(sample: bytes) -> str:
    """One of the encodings from before Unicode; the western one where little speaks for another."""
    from charset_normalizer import from_bytes

    if sum(byte > 0x7F for byte in sample) >= 24 and (
        best := from_bytes(sample, cp_isolation=_OLD, threshold=0.4).best()
    ):
        return best.encoding
    return "cp1252"


def read_text(path: Path, how: Format, *, as_text: bool = False) -> Table:
    """Read a text table; `as_text` leaves its cells as they are written. What is said of it are lines left out.

    Raises `LabrigError` if its encoding is wrong, its rows have more cells than it has names, or it is no text.
    """
    import pandas as pd

    encoding = how.encoding or find_encoding(path)
    try:
        codecs.lookup(encoding)
    except LookupError:
        raise LabrigError(
            f"{path}: there is no encoding {encoding!r}; use one such as utf-8, utf-16 or cp1252"
        ) from None
    if how.separator == LABELS:
        return read_labelled(path, encoding, how.rows)
    options: dict[str, Any] = {
        "sep": SEPARATORS.get(how.separator, how.separator),
        "encoding": encoding,
        "skipinitialspace": True,
        "skip_blank_lines": False,
        "header": None,
        "index_col": False,
    }
    if len(options["sep"]) > 1 and how.separator != "whitespace":
        options["engine"] = "python"  # the faster one knows no patterns
    if as_text or how.decimal != ".":
        options["dtype"] = str
    above = how.skip_rows + how.header + (how.units_row and how.header)
    if how.rows is not None:
        options["nrows"] = how.rows
    try:
        names, doubled, named = None, frozenset(), None
        if how.header:
            names, doubled, named = names_of(path, how, encoding, _width(path, how, encoding, above))
        with warnings.catch_warnings():
            warnings.simplefilter("ignore", pd.errors.DtypeWarning)
            warnings.simplefilter("error", pd.errors.ParserWarning)
            with open_bytes(path) as file:
                frame = pd.read_csv(file, skiprows=above, names=names, **options)
        if how.separator == "whitespace":
            check_blanks(path, encoding, above, len(frame.columns), how.rows)
    except pd.errors.EmptyDataError:
        raise LabrigError(f"{path}: has no rows") from None
    except pd.errors.ParserError as error:
        if (found := _LONGER.search(str(error))) is None:
            raise
        raise LabrigError(
            f"{path}, line {found['line']}: has {found['own']} cells where those before have {found['others']}: does a "
            "second table begin there? 'format: rows:' reads the first alone, 'skip_rows:' the other"
        ) from None
    except pd.errors.ParserWarning:
        raise LabrigError(f"{path}: its rows have more cells than its header has names") from None
    except UnicodeError:
        raise LabrigError(
            f"{path}: is not text in the encoding {encoding}; name the right one under 'format: encoding:'"
        ) from None
    if named is not None:
        _refuse_unnamed(path, frame, named, above, how.separator)
    said = []
    if frame.isna().to_numpy()[-1:].all():
        frame = frame.iloc[: frame.notna().any(axis=1).to_numpy().nonzero()[0].max(initial=-1) + 1]
    if how.rows is None and cut_short(frame):
        frame, said = frame.iloc[:-1], ["its last line was not written to its end and is left out"]
    frame, lines, more = without_text(frame, above + 1, how.decimal)
    return Table(path, frame, above + 1, how.decimal, "line", doubled, lines=lines, said=(*said, *more))


def _refuse_unnamed(path: Path, frame: "pd.DataFrame", named: int, above: int, separator: str) -> None:
    """Raise `LabrigError` where numbers stand in cells that none of the `named` first columns has; empty ones, behind a
    last separator in each row, and words do no harm.
    """
    filled = frame.notna().to_numpy()
    numbers = [_numeric(frame.iloc[:, k]) for k in range(named, frame.shape[1])]
    rows = np.flatnonzero(np.any(numbers, axis=0)) if numbers else []
    if len(rows):
        i = int(rows[0])
        cells = int(np.flatnonzero(filled[i]).max()) + 1
        raise LabrigError(f"{path}, line {i + above + 1}: {too_many(cells, named, separator)}")


def _numeric(column: "pd.Series") -> NDArray[np.bool_]:
    """Which cells (n,) of a column are numbers."""
    import pandas as pd

    return np.isfinite(np.asarray(pd.to_numeric(column, errors="coerce"), dtype=float))


def _width(path: Path, how: Format, encoding: str, above: int) -> int:
    """The commonest number of cells of the first lines below the names."""
    with open_text(path, encoding) as file:
        lines = list(itertools.islice(file, above, above + _FEW))
    widths = Counter(len(split(line.rstrip("\n"), how.separator)) for line in lines if line.strip())
    return widths.most_common(1)[0][0] if widths else 0
