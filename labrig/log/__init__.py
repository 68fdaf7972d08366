"""The log: written durably, step by step, and read back as an `xarray.Dataset`, whatever happened to it."""

from labrig.log._find import find_runs, folders_below, run_id
from labrig.log._guessed import import_guessed
from labrig.log._import import dataset_from, import_table
from labrig.log._layout import Layout
from labrig.log._notes import NOTES, Notes, read_notes
from labrig.log._open import goes_on, marker_places, open_run
from labrig.log._recover import recover
from labrig.log._rig_dataset import RunSeries, Series, run_series
from labrig.log._runs import RunSummary, summarise
from labrig.log._segments import (
    LoadedSegment,
    is_segment,
    last_logged_s,
    load_segments,
    read_run_yaml,
    segment_path,
    segment_paths,
    sessions,
)
from labrig.log._table import layout_of, write_dataset
from labrig.log._topics import Topic
from labrig.log._writer import LogWriter, to_ns
from labrig.tables import Guess, Mapping, guess_mapping, read_mapping

__all__ = [
    "NOTES",
    "Guess",
    "Layout",
    "LoadedSegment",
    "LogWriter",
    "Mapping",
    "Notes",
    "RunSeries",
    "RunSummary",
    "Series",
    "Topic",
    "dataset_from",
    "find_runs",
    "folders_below",
    "goes_on",
    "guess_mapping",
    "import_guessed",
    "import_table",
    "is_segment",
    "last_logged_s",
    "layout_of",
    "load_segments",
    "marker_places",
    "open_run",
    "read_mapping",
    "read_notes",
    "read_run_yaml",
    "recover",
    "run_id",
    "run_series",
    "segment_path",
    "segment_paths",
    "sessions",
    "summarise",
    "to_ns",
    "write_dataset",
]
