"""Procedures: what a lab user reads, copies and edits."""

from procedures._capture import Capture
from procedures._hold import Hold
from procedures._idle import Idle
from procedures._pairs import Pairs
from procedures._programme import Programme
from procedures._repeatability import Repeatability
from procedures._survey import Survey
from procedures._sweep import Sweep
from procedures._validate import Validate

__all__ = ["Capture", "Hold", "Idle", "Pairs", "Programme", "Repeatability", "Survey", "Sweep", "Validate"]
