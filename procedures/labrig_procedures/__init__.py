"""Procedures: what a lab user reads, copies and edits."""

from labrig_procedures._capture import Capture
from labrig_procedures._check import Check
from labrig_procedures._hold import Hold
from labrig_procedures._idle import Idle
from labrig_procedures._pairs import Pairs
from labrig_procedures._programme import Programme
from labrig_procedures._repeatability import Repeatability
from labrig_procedures._survey import Survey
from labrig_procedures._sweep import Sweep
from labrig_procedures._validate import Validate

__all__ = [
    "Capture",
    "Check",
    "Hold",
    "Idle",
    "Pairs",
    "Programme",
    "Repeatability",
    "Survey",
    "Sweep",
    "Validate",
]
