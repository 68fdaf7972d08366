"""The history of a rig: what each of its runs says, since when it is another, and whether a model still fits it."""

from labrig.age._age import ALPHA, read_rows, rows_of_rig, summary_of
from labrig.age._change import Change, Series, changes
from labrig.age._read import RunReadings
from labrig.age._reading import GROUPS, Reading
from labrig.age._warn import lasting, warning

__all__ = [
    "ALPHA",
    "GROUPS",
    "Change",
    "Reading",
    "RunReadings",
    "Series",
    "changes",
    "lasting",
    "read_rows",
    "rows_of_rig",
    "summary_of",
    "warning",
]
