"""Which column of a foreign table is its clock, and in what unit."""

import re
from collections.abc import Mapping
from typing import Any

import numpy as np

from labrig.arrays import Floats
from labrig.tables import _names as names
from labrig.tables._names import Name
from labrig.tables._table import Table
from labrig.tables._units import like

_DATE = re.compile(r"\d{1,4}[-/.]\d{1,2}[-/.]\d{1,4}|\d{1,2}:\d{2}")
_NO_TIME = names.CAPTURE | names.PRESSURE | names.COMMANDED | names.INPUT


def are_dates(table: Table, column: Any) -> bool:
    """Whether a column holds dates or times of day."""
    import pandas as pd

    values = table.frame[column]
    if values.dtype.kind == "M":
        return True
    sample = values.dropna().head(20)
    if not len(sample) or not all(_DATE.search(str(v)) for v in sample):
        return False
    return bool(pd.to_datetime(sample.astype(str), errors="coerce", format="mixed", utc=True).notna().all())


def find_time(
    parsed: list[Name], values: Mapping[str, Floats], remarks: list[str]
) -> tuple[Name, str] | None:
    """The clock and its unit, of columns with these `values`; other clocks are taken out of `parsed`, and `remarks` say
    what was assumed.
    """
    able = [n for n in parsed if n.unit is None or like(n.unit, "s")]
    called = [n for n in able if n.words[:1] and (n.words[0] in names.TIME or n.words[-1] in names.TIME)]
    called += [n for n in able if not n.words and n.unit in {"s", "ms", "us", "ns", "min"}]
    rising = [n for n in called if _rises(values[n.column])]
    first_may = able[:1] == parsed[:1] and not any(n.has(_NO_TIME) for n in parsed[:1])
    if not rising and parsed and first_may and _rises(values[parsed[0].column]):
        first = values[parsed[0].column]
        if len(first) > 2 and np.std(np.diff(first)) < 0.2 * np.mean(np.diff(first)):
            rising = [parsed[0]]
            remarks.append(f"column {parsed[0].column!r} rises evenly: taken for the time")
    if not rising:
        if called:
            remarks.append(f"column {called[0].column!r} is called a time but goes back: left out")
        remarks.append("no column is a time: rows are taken as 1 s apart; say so under 'time:' if not")
        return None
    chosen = rising[0]
    for other in rising[1:]:
        remarks.append(f"column {other.column!r} is a clock as well and is left out")
        parsed.remove(other)
    unit = chosen.unit
    if unit is None or unit not in {"s", "ms", "us", "ns", "min", "hour", "h"}:
        unit = _time_unit(values[chosen.column])
        remarks.append(f"the unit of the time {chosen.column!r} is not said: taken as {unit}")
    return chosen, unit


def _rises(values: Floats) -> bool:
    """Whether values only go up, but for places where they begin anew."""
    if not np.isfinite(values).all() or len(values) < 2:
        return False
    step = np.diff(values)
    return bool((step > 0).any() and (step < 0).sum() <= max(0, len(step) // 50) and (step >= 0).mean() > 0.9)


def _time_unit(values: Floats) -> str:
    """By its size where it counts from 1970, else by the distance of its rows: no rig logs at 10 kHz and more."""
    for size, unit in ((1e17, "ns"), (1e14, "us"), (1e11, "ms")):
        if values[0] > size:
            return unit
    step = float(np.median(np.diff(values))) if len(values) > 1 else 1.0
    whole = bool(np.all(values == np.round(values)))
    if whole and step >= 1e5:
        return "ns" if step >= 1e6 * 5 else "us"
    return "ms" if whole and step >= 5 and float(np.ptp(values)) >= 2000 else "s"
