"""The catalogue: all runs below a folder as a table, with what people and diagnoses say of them."""

from labrig.catalogue._before import Before, used_before
from labrig.catalogue._frame import runs, write_parquet
from labrig.catalogue._index import INDEX
from labrig.catalogue._list import UNREADABLE, list_runs, newest_first
from labrig.catalogue._notes import note, rule_out, tag
from labrig.catalogue._row import COLUMNS, Row
from labrig.log import Notes, read_notes

__all__ = [
    "COLUMNS",
    "INDEX",
    "UNREADABLE",
    "Before",
    "Notes",
    "Row",
    "list_runs",
    "newest_first",
    "note",
    "read_notes",
    "rule_out",
    "runs",
    "tag",
    "used_before",
    "write_parquet",
]
