"""Blind benchmark: campaigns with hidden effects from a separate plant, and how well they are named."""

from labrig.bench._bases import make_base, own_error
from labrig.bench._calibrate import UNLEARNT, calibration_plan, run_calibrate, surprise, write_calibration
from labrig.bench._classes import CLASSES
from labrig.bench._draw import Campaign, draw
from labrig.bench._files import write_campaign, write_model
from labrig.bench._halves import HALVES, PORTIONS, half_of, make_rig
from labrig.bench._intervals import newcombe, wilson
from labrig.bench._judge import brier, calibration_error, is_right
from labrig.bench._learn import learn_all, write_spectra
from labrig.bench._record import times_there, track_records, write_track_records
from labrig.bench._report import lines, tables, write_report, write_results, wrong_lines
from labrig.bench._ruled_out import (
    Tried,
    ruled_out_plan,
    ruled_out_rows,
    run_ruled_out,
    write_ruled_out,
)
from labrig.bench._run import plan, read_records, run_blind, run_one
from labrig.bench._settle import run_settle, settle, settle_records
from labrig.bench._settled import compared_rows, settle_rows, write_settle
from labrig.bench._speed import speed_table, time_diagnosis, write_speed
from labrig.bench._stopped import HEAD, stopped_rows, write_stopping
from labrig.bench._stopping import run_stopping, stopping_plan, stopping_records
from labrig.bench._summary import summarise

__all__ = [
    "CLASSES",
    "HALVES",
    "HEAD",
    "PORTIONS",
    "UNLEARNT",
    "Campaign",
    "Tried",
    "brier",
    "calibration_error",
    "calibration_plan",
    "compared_rows",
    "draw",
    "half_of",
    "is_right",
    "learn_all",
    "lines",
    "make_base",
    "make_rig",
    "newcombe",
    "own_error",
    "plan",
    "read_records",
    "ruled_out_plan",
    "ruled_out_rows",
    "run_blind",
    "run_calibrate",
    "run_one",
    "run_ruled_out",
    "run_settle",
    "run_stopping",
    "settle",
    "settle_records",
    "settle_rows",
    "speed_table",
    "stopped_rows",
    "stopping_plan",
    "stopping_records",
    "summarise",
    "surprise",
    "tables",
    "time_diagnosis",
    "times_there",
    "track_records",
    "wilson",
    "write_calibration",
    "write_campaign",
    "write_model",
    "write_report",
    "write_results",
    "write_ruled_out",
    "write_settle",
    "write_spectra",
    "write_speed",
    "write_stopping",
    "write_track_records",
    "wrong_lines",
]
