"""Somebody's own tables: read from many formats, what their columns mean, and a guess where nobody says it."""

from labrig.tables._absolute import said_of_absolute
from labrig.tables._clock import check_clock, is_dated, seconds, why_back
from labrig.tables._guess import Guess, guess_mapping, guess_together
from labrig.tables._join import join_tables
from labrig.tables._mapping import (
    Actuation,
    Covariate,
    Event,
    Format,
    Join,
    Mapping,
    Measured,
    Observable,
    TableFile,
    check_mapping,
    read_mapping,
)
from labrig.tables._names import take_apart
from labrig.tables._opened import opened
from labrig.tables._order import by_time, in_rows
from labrig.tables._plain import plain
from labrig.tables._plausible import check_limits, check_values
from labrig.tables._read import READ, beside, kind_of, parts_of, read_file, read_table
from labrig.tables._sniff import sniff
from labrig.tables._spelling import check_spelt
from labrig.tables._strokes import Segment, find_segments, goes_back_and_forth, held_share, is_set
from labrig.tables._table import Table, short
from labrig.tables._units import conversion, factor, is_length
from labrig.tables._unseen import unseen

__all__ = [
    "READ",
    "Actuation",
    "Covariate",
    "Event",
    "Format",
    "Guess",
    "Join",
    "Mapping",
    "Measured",
    "Observable",
    "Segment",
    "Table",
    "TableFile",
    "beside",
    "by_time",
    "check_clock",
    "check_limits",
    "check_mapping",
    "check_spelt",
    "check_values",
    "conversion",
    "factor",
    "find_segments",
    "goes_back_and_forth",
    "guess_mapping",
    "guess_together",
    "held_share",
    "in_rows",
    "is_dated",
    "is_length",
    "is_set",
    "join_tables",
    "kind_of",
    "opened",
    "parts_of",
    "plain",
    "read_file",
    "read_mapping",
    "read_table",
    "said_of_absolute",
    "seconds",
    "short",
    "sniff",
    "take_apart",
    "unseen",
    "why_back",
]
