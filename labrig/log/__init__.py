"""The log: written durably, step by step, and read back as an `xarray.Dataset`, whatever happened to it."""

from labrig.log._layout import Layout
from labrig.log._open import open_run
from labrig.log._rig_dataset import RunSeries, Series, run_series
from labrig.log._segments import (
    LoadedSegment,
    load_segments,
    read_run_yaml,
    segment_path,
    segment_paths,
    sessions,
)
from labrig.log._table import layout_of, write_dataset
from labrig.log._topics import Topic
from labrig.log._writer import LogWriter, to_ns

__all__ = [
    "Layout",
    "LoadedSegment",
    "LogWriter",
    "RunSeries",
    "Series",
    "Topic",
    "layout_of",
    "load_segments",
    "open_run",
    "read_run_yaml",
    "run_series",
    "segment_path",
    "segment_paths",
    "sessions",
    "to_ns",
    "write_dataset",
]
