"""Clocks in several columns: seconds and nanoseconds, a time and its milliseconds, year to second."""

import re
from collections.abc import Mapping
from dataclasses import dataclass
from typing import Any

import numpy as np

from labrig.arrays import Floats
from labrig.tables import _names as names
from labrig.tables._names import Name
from labrig.tables._table import DATE


@dataclass(frozen=True)
class Clock:
    """The columns of a clock with their unit, one for all or one each, and whether dates begin with the day; with a
    rate its column counts frames, or the rows are counted, so many a second. With `sort` the rows of the file are not
    in its order.
    """

    columns: tuple[str, ...]
    unit: str | list[str]
    day_first: bool | None = None
    rate_hz: float | None = None
    sort: bool = False

    def entry(self, keys: list[Any]) -> dict[str, Any]:
        """What a mapping says of it, `keys` being its columns there."""
        if self.rate_hz is not None:
            return {**({"column": keys[0]} if keys else {}), "rate_hz": self.rate_hz}
        out: dict[str, Any] = {"column": keys if len(keys) > 1 else keys[0], "unit": self.unit}
        if self.day_first is not None:
            out["day_first"] = self.day_first
        return {**out, "sort": True} if self.sort else out


_FINER = (
    (re.compile(r"(?:(?<=[^a-z])|^)(?:nanosec|nanosecs|nsec|nsecs|nanoseconds?|ns)$"), "ns", 1e9),
    (re.compile(r"(?:(?<=[^a-z])|^)(?:microsec|usec|usecs|microseconds?|us|µs)$"), "us", 1e6),
    (re.compile(r"(?:(?<=[^a-z])|^)(?:msec|msecs|millis|milliseconds?|ms)$"), "ms", 1e3),
)
_WHOLE = re.compile(r"(?:(?<=[^a-z])|^)(?:sec|secs|seconds?|s)$")
_SIX = (
    {"year", "years"},
    {"month", "months"},
    {"day", "days"},
    {"hour", "hours", "hr"},
    {"minute", "minutes", "min"},
    {"second", "seconds", "sec"},
)
OF_A_DATE = frozenset().union(*_SIX)
"""What columns of a date's parts are called."""


def finer(parsed: list[Name], values: Mapping[str, Floats], whole_s: Floats) -> tuple[Name, str] | None:
    """The column that counts the parts of each second of a clock in whole seconds (n,), and its unit."""
    if np.isnan(whole_s).any() or (whole_s != np.round(whole_s)).any():
        return None
    for n in parsed:
        for pattern, unit, most in _FINER:
            if pattern.search(_plain(n.column)) and _fits(values[n.column], most, whole_s):
                return n, unit
    return None


def seconds_and_parts(parsed: list[Name], values: Mapping[str, Floats]) -> Clock | None:
    """A column of whole seconds and one of their parts, such as ``sec`` and ``nanosec`` of one stamp."""
    for n in parsed:
        for pattern, unit, most in _FINER:
            if not (found := pattern.search(_plain(n.column))):
                continue
            owner = _plain(n.column)[: found.start()]
            for base in _bases(parsed, owner):
                own = values[base.column]
                if base is not n and (own == np.round(own)).all() and _fits(values[n.column], most, own):
                    return Clock((base.column, n.column), ["s", unit])
    return None


def year_to_second(parsed: list[Name]) -> Clock | None:
    """Six columns from the year to the second."""
    found = []
    for called in _SIX:
        own = next((n for n in parsed if re.sub(r"[^a-z]", "", n.column.lower()) in called), None)
        if own is None:
            return None
        found.append(own.column)
    return Clock(tuple(found), DATE)


def counts_parts(name: Name) -> bool:
    """Whether a column is called the parts of a second."""
    return any(pattern.search(_plain(name.column)) for pattern, _, _ in _FINER)


def _plain(column: str) -> str:
    return column.lower().rstrip(" )]}").replace("(", " ").replace("[", " ")


def _bases(parsed: list[Name], owner: str) -> list[Name]:
    """Columns of seconds of the same owner, then those that are called a time."""
    same = [
        n for n in parsed if (f := _WHOLE.search(_plain(n.column))) and _plain(n.column)[: f.start()] == owner
    ]
    timed = [
        n
        for n in parsed
        if n.words[:1] and (n.words[0] in names.TIME or n.words[-1] in names.TIME) and n.unit in (None, "s")
    ]
    return [*same, *timed]


def _fits(part: Floats, most: float, whole_s: Floats) -> bool:
    """Whether whole numbers (n,) begin anew with each second, so that both together only go up."""
    if not (np.isfinite(part).all() and np.isfinite(whole_s).all()) or len(part) < 2:
        return False
    if (part != np.round(part)).any() or part.min() < 0 or part.max() >= most or not np.ptp(part):
        return False
    step = np.diff(whole_s - whole_s[0] + part / most)
    back = (np.diff(part) < 0) & (np.diff(whole_s) > 0)
    return bool((step >= 0).all() and (step > 0).any() and back.any())
