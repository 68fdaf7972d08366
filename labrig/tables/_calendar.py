"""Which of the numbers of a date is the day: one order for the whole column."""

from dataclasses import dataclass
from typing import TYPE_CHECKING

import numpy as np

from labrig.arrays import Floats

if TYPE_CHECKING:
    import pandas as pd

_ORDERS = ("mdy", "dmy", "ymd")
_DAY_S = 86400.0
_ALIKE_S = 0.5


@dataclass
class Calendar:
    """Days since 1970, (n,), NaN where there is no such day, and the order they were read in.

    `order` is `mdy` or `dmy` (or `ymd`, for years of two digits) for dates with slashes or dashes, empty where their
    writing says it: 2026-05-04, 04.05.2026. `sure` is false where another order would do alike.
    """

    days: Floats
    order: str
    sure: bool
    example: str


def read_calendar(dates: "pd.Series", time_s: Floats, day_first: bool | None) -> Calendar:
    """The dates of n cells; `time_s` (n,) is the time of day of each.

    Of month first and day first the one holds in which fewer rows go back, then the one that takes less time in all,
    then month first.
    """
    code, unique = dates.factorize()
    said = np.array([_says_it(text) for text in unique])
    if said.all():
        return Calendar(_days(unique, "dmy", code), "", True, "")
    example = str(unique[int(np.argmin(said))])
    if day_first is not None:
        order = "dmy" if day_first else "mdy"
        return Calendar(_days(unique, order, code), order, True, example)
    read = {order: _days(unique, order, code) for order in _ORDERS}
    rank = {order: _rank(days[code >= 0] * _DAY_S + time_s[code >= 0]) for order, days in read.items()}
    best = min(rank.values())
    alike = [
        order
        for order, own in rank.items()
        if own[:2] == best[:2] and own[2] <= best[2] + _ALIKE_S and np.isfinite(own[2])
    ]
    order = alike[0] if alike else "mdy"
    return Calendar(read[order], order, len(alike) == 1, example)


def _says_it(text: str) -> bool:
    return text[:4].isdigit() or "." in text


def _rank(seconds: Floats) -> tuple[int, int, float]:
    """How badly rows (n,) would follow each other: days that don't exist, steps back, the whole span."""
    missing = int(np.isnan(seconds).sum())
    if missing == len(seconds):
        return missing, 0, float("inf")
    return missing, int((np.diff(seconds) < 0).sum()), float(np.nanmax(seconds) - np.nanmin(seconds))


def _days(unique: "pd.Index", order: str, code: np.ndarray) -> Floats:
    import pandas as pd

    parts = pd.Series(unique).str.extract(r"(\d+)[-/.](\d+)[-/.](\d+)").astype(float).to_numpy()
    written = [("ymd" if t[:4].isdigit() else "dmy" if "." in t else order) for t in unique]
    place = np.array([[w.index(k) for k in "ymd"] for w in written]).reshape(-1, 3)
    year, month, day = np.take_along_axis(parts, place, axis=1).T
    year = np.where(year < 70, year + 2000, np.where(year < 100, year + 1900, year))
    known = pd.to_datetime(pd.DataFrame({"year": year, "month": month, "day": day}), errors="coerce")
    days = np.array((known - pd.Timestamp("1970-01-01")) / pd.Timedelta(days=1), dtype=float)
    return np.where(code >= 0, days[code], np.nan)
