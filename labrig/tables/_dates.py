"""Dates, times of day and durations of a column as seconds: all its cells are read in one way."""

import re
from collections.abc import Sequence
from dataclasses import dataclass, field
from typing import TYPE_CHECKING, Any

import numpy as np

from labrig.arrays import Floats, Ints
from labrig.tables._calendar import Calendar, read_calendar
from labrig.tables._names import unit_of
from labrig.tables._units import factor, like

if TYPE_CHECKING:
    import pandas as pd

DAY_S = 86400.0
_ZONE = r"(?P<zone>Z|UTC|GMT|[+-]\d{1,2}:?(?:\d\d)?)?"
_CLOCK = (
    r"(?P<a>\d+):(?P<b>\d+)(?::(?P<c>\d+))?(?:(?P<sign>[.,:])(?P<part>\d+))?\s*(?P<half>[AaPp]\.?[Mm]\.?)?\s*"
)
DATE = r"\d{4}[-/.]\d{1,2}[-/.]\d{1,2}|\d{1,2}[-/.]\d{1,2}[-/.](?:\d{4}|\d{2})"
_CELL = re.compile(rf"(?:(?P<date>{DATE})[T ,_]*)?(?:{_CLOCK}{_ZONE})?")
_COMPACT = re.compile(r"^(\d{4})(\d\d)(\d\d)(?:[T _]+(\d\d)(\d\d)(\d\d))?(?=$|\D)")
_SIX = re.compile(r"^(\d{4})[ _-](\d\d?)[ _-](\d\d?)[ _T-]+(\d\d?)[ _-](\d\d?)[ _-](\d\d?)(?=$|[.,])")
_AMOUNT = re.compile(r"(?P<number>[+-]?\d+(?:[.,]\d+)?(?:[eE][+-]?\d+)?)\s*(?P<unit>[A-Za-zµμ]+)\.?")
_SAYS_MINUTES = re.compile(r"(?<!:)\b(mm?|min):s", re.IGNORECASE)
_SAYS_HOURS = re.compile(r"\bh{1,2}:m", re.IGNORECASE)
_ZONED = re.compile(r":\d\d(?:[.,]\d+)?\s*(?:Z|UTC|GMT|[+-]\d{1,2}:?(?:\d\d)?)$")
_OFTEN = 0.3  # share of rows with the time of the row before, from which on 0:05 is no hour


class UnreadableError(Exception):
    """What a column as a whole can't be read for; its text ends a complaint."""


@dataclass
class Stamps:
    """A column of n cells as seconds.

    `seconds` (n,) count from 1970 (UTC where no zone is named) if `dated`, else from midnight or from the beginning;
    NaN where a cell is none of it. `zoned` says whether a zone is named, `calendar` in which order dates are read,
    `minutes` whether ``0:05`` is minutes and seconds; `unsure` are one line for each thing that the cells leave open,
    `nights` the rows (from 0) before which a time of day without a date passed midnight.
    """

    seconds: Floats
    dated: bool
    zoned: bool = False
    amounts: bool = False
    minutes: bool = False
    calendar: Calendar | None = None
    unsure: list[str] = field(default_factory=list)
    nights: Ints = field(default_factory=lambda: np.zeros(0, dtype=np.int64))


def read_stamps(
    cells: Sequence["pd.Series"], called: str, *, day_first: bool | None = None, minutes: bool = False
) -> Stamps:
    """Read n cells, in one column or in several that belong together; `called` is what a header says.

    `day_first` and `minutes` say what cells may leave open. Raises `UnreadableError` for a clock that ends in frames.
    """
    import pandas as pd

    kind = cells[0].dtype.kind if len(cells) == 1 else "O"
    if kind == "M":
        zoned = getattr(cells[0].dtype, "tz", None) is not None
        return Stamps(_in_seconds(pd.to_datetime(cells[0], utc=True) - _1970()), dated=True, zoned=zoned)
    if kind == "m":
        return Stamps(_in_seconds(cells[0]), dated=False)
    text = as_text(cells)
    out = _read(text, called, day_first=day_first, minutes=minutes, alone=len(cells) == 1)
    out.zoned = bool(text.head(1).str.contains(_ZONED).any())
    return out


def _read(text: "pd.Series", called: str, *, day_first: bool | None, minutes: bool, alone: bool) -> Stamps:
    """The same of cells of text, which stood in one column `alone` or in several."""
    import pandas as pd

    if alone and text.head(1).str.match(r"\d{4}-\d").any():
        stamps = pd.to_datetime(text, errors="coerce", utc=True, format="ISO8601")
        if stamps.notna().all():
            return Stamps(_in_seconds(stamps - _1970()), dated=True)
    found = text.str.extract(rf"^(?P<all>{_CELL.pattern})$")
    known = (found["date"].notna() | found["a"].notna()).to_numpy(dtype=bool)
    if not known.any():
        return _other(text)
    out = _stamps(found, called, day_first, minutes)
    rest: Any = text[~known & text.ne("").to_numpy()]
    if out.dated and len(rest):
        out.seconds[rest.index.to_numpy()] = _other(rest).seconds
    return out


def as_text(cells: Sequence["pd.Series"]) -> "pd.Series":
    """The cells of each row as one text, (n,): those with dates first, a blank between them, empty where one is."""
    columns = [_text(c) for c in cells]
    columns.sort(key=lambda c: not c.head(1).str.contains(DATE).any())
    out = columns[0].str.cat(columns[1:], sep=" ") if len(columns) > 1 else columns[0]
    out = out.reset_index(drop=True)
    out = out.str.replace(_SIX, r"\1-\2-\3 \4:\5:\6", regex=True)
    return out.str.replace(_COMPACT, _spaced, regex=True)


def _spaced(found: re.Match[str]) -> str:
    parts = found.groups()
    return "-".join(parts[:3]) + (f" {':'.join(parts[3:])}" if parts[3] else "")


def _text(column: "pd.Series") -> "pd.Series":
    import pandas as pd

    if column.dtype.kind == "M":
        whole = bool((column.dropna() == column.dropna().dt.normalize()).all())
        return column.dt.strftime("%Y-%m-%d" if whole else "%Y-%m-%d %H:%M:%S.%f").fillna("").astype(str)
    if column.dtype.kind == "m":
        return pd.Series([_clock_text(v) for v in column], index=column.index, dtype=str)
    if column.dtype.kind == "f":
        return column.map(lambda v: "" if v != v else f"{v:.0f}" if v == round(v) else repr(float(v)))
    blank = column.isna()
    return column.map(_clock_text).astype(str).str.strip().where(~blank, "")


def _clock_text(cell: Any) -> str:
    """A cell as text; a span of time as H:MM:SS."""
    if not hasattr(cell, "total_seconds"):
        return str(cell)
    if cell != cell:
        return ""
    left = round(cell.total_seconds() * 1e6)
    return f"{left // 3_600_000_000}:{left // 60_000_000 % 60:02d}:{left % 60_000_000 / 1e6:09.6f}"


def _in_seconds(spans: "pd.Series") -> Floats:
    import pandas as pd

    return np.array(spans / pd.Timedelta(seconds=1), dtype=float)


def _stamps(found: Any, called: str, day_first: bool | None, minutes: bool) -> Stamps:
    """Cells taken apart: `found` is a frame of the groups of `_CELL`."""
    dated = bool(found["date"].notna().any())
    unsure: list[str] = []
    minutes = minutes or (not dated and _in_minutes(found, called, unsure))
    time = _of_day(found, minutes)
    if not dated:
        out = Stamps(time, dated=False, minutes=minutes, unsure=unsure)
        if not minutes and not (time >= DAY_S).any():
            out.nights = np.flatnonzero(np.diff(time) < -DAY_S / 2) + 1
            for row in out.nights:
                time[row:] += DAY_S
        return out
    time = np.where(found["a"].isna() & found["date"].notna(), 0.0, time) - _zone(found["zone"])
    calendar = read_calendar(found["date"], time, day_first)
    return Stamps(calendar.days * DAY_S + time, dated=True, calendar=calendar)


def _in_minutes(found: Any, called: str, unsure: list[str]) -> bool:
    """Whether cells of two parts are minutes and seconds, not hours and minutes."""
    two = found[found["a"].notna() & found["c"].isna()]
    if two.empty or found["half"].notna().any() or _SAYS_HOURS.search(called):
        return False
    first = two["a"].astype(float).to_numpy()
    whole = len(two) < found["a"].notna().sum()
    if _SAYS_MINUTES.search(called) or two["part"].notna().any() or (first > 23).any() or whole:
        return True
    same = float((two["all"].to_numpy()[1:] == two["all"].to_numpy()[:-1]).mean()) if len(two) > 1 else 0.0
    if same >= _OFTEN and first[0] == 0:
        unsure.append(f"times such as {two['all'].iloc[-1]!r} repeat: taken as minutes and seconds")
        return True
    unsure.append(
        f"times such as {two['all'].iloc[0]!r} are taken as hours and minutes: "
        "if they are minutes and seconds, write 'unit: \"min:s\"'"
    )
    return False


def _of_day(found: Any, minutes: bool) -> Floats:
    """Seconds of the clock in each cell, (n,)."""
    a, b, c = (np.array(found[k], dtype=float) for k in "abc")
    out = a * 3600 + b * 60 + np.where(np.isnan(c), 0.0, c)
    if minutes:
        out = np.where(np.isnan(c), a * 60 + b, out)
    out = np.where((b >= 60) | (c > 60), np.nan, out)
    if found["half"].notna().any():
        half = found["half"].str[:1].str.lower().to_numpy()
        out = np.where((half == "p") & (a < 12), out + DAY_S / 2, out)
        out = np.where((half == "a") & (a == 12), out - DAY_S / 2, out)
    return out + _fraction(found)


def _fraction(found: Any) -> Floats:
    """What follows the seconds, (n,): behind a point, a comma, or a colon (ms, or hundredths)."""
    part = found["part"]
    if not part.notna().any():
        return np.zeros(len(part))
    digits = np.array(part.str.len(), dtype=float)
    number = np.array(part, dtype=float)
    colon = (found["sign"] == ":").to_numpy(dtype=bool)
    if colon.any():
        longest = float(np.nanmax(digits[colon]))
        if longest < 3 and np.nanmax(number[colon]) < 60:
            example = found["all"][colon].iloc[-1]
            raise UnreadableError(
                f"holds {example!r}: whether it ends in frames or in hundredths of a second is not known; "
                "write seconds, or h:mm:ss.ff"
            )
        digits[colon] = max(longest, 2.0)
    return np.where(part.isna(), 0.0, number / 10.0 ** np.where(np.isnan(digits), 0.0, digits))


def _zone(zone: "pd.Series") -> Floats:
    """Seconds by which clocks with a zone are ahead of UTC, (n,)."""
    out = np.zeros(len(zone))
    for text in zone.dropna().unique():
        if text[0] in "+-":
            digits = text[1:].replace(":", "")
            hours, rest = (digits[:-2], digits[-2:]) if len(digits) > 2 else (digits, "0")
            ahead = int(hours) * 3600.0 + int(rest) * 60.0
            out[(zone == text).to_numpy(dtype=bool)] = ahead if text[0] == "+" else -ahead
    return out


def _other(text: "pd.Series") -> Stamps:
    """Amounts of time with their units (``0.5 sec``), spans with days, dates with names of months."""
    import pandas as pd

    found = text.str.extract(rf"^{_AMOUNT.pattern}$")
    units = found["unit"].dropna().unique().tolist()
    scales = {u: factor(own, "s", "time") for u in units if (own := unit_of(u)) and like(own, "s")}
    if found["unit"].isin(list(scales)).mean() > 0.5:
        number = np.array(found["number"].str.replace(",", ".", regex=False), dtype=float)
        return Stamps(number * np.array(found["unit"].map(scales), dtype=float), dated=False, amounts=True)
    if text.str.contains(r"^-?\d+ days?\b").mean() > 0.5:
        return Stamps(_in_seconds(pd.to_timedelta(text, errors="coerce")), dated=False)
    shown = text.where(text.ne(""))
    stamps = pd.to_datetime(shown, errors="coerce", utc=True, format="mixed")
    return Stamps(_in_seconds(stamps - _1970()), dated=True)


def _1970() -> Any:
    import pandas as pd

    return pd.Timestamp("1970-01-01", tz="UTC")
