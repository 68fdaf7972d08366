"""Diagnosis: the noise floor, where a model fails, what it lacks, and how sure that is."""

from labrig.diagnosis._calibration import Calibration, log_odds, shipped
from labrig.diagnosis._calibration import shipped as calibration
from labrig.diagnosis._candidates import change_of, square_of
from labrig.diagnosis._ceiling import STATIC, covariates, kernel
from labrig.diagnosis._constants import POSSIBLE, SURE
from labrig.diagnosis._diagnose import considered, diagnose
from labrig.diagnosis._explanation import Explanation
from labrig.diagnosis._falls import Fall
from labrig.diagnosis._floor import Floor, noise_floor
from labrig.diagnosis._forecast import Explained, Outlook
from labrig.diagnosis._formula import forms_of
from labrig.diagnosis._gone import gone_at_most
from labrig.diagnosis._improve import compare, improve
from labrig.diagnosis._observations import Counted, Observations, observe
from labrig.diagnosis._opened import Opened, Trial
from labrig.diagnosis._outliers import clean
from labrig.diagnosis._present import whole_change
from labrig.diagnosis._problem import Prepared, prepared, rows_from
from labrig.diagnosis._ranking import drop_of
from labrig.diagnosis._result import Result, Signature, VersusResult
from labrig.diagnosis._verdict import Considered
from labrig.diagnosis._versus import versus

__all__ = [
    "POSSIBLE",
    "STATIC",
    "SURE",
    "Calibration",
    "Considered",
    "Counted",
    "Explained",
    "Explanation",
    "Fall",
    "Floor",
    "Observations",
    "Opened",
    "Outlook",
    "Prepared",
    "Result",
    "Signature",
    "Trial",
    "VersusResult",
    "calibration",
    "change_of",
    "clean",
    "compare",
    "considered",
    "covariates",
    "diagnose",
    "drop_of",
    "forms_of",
    "gone_at_most",
    "improve",
    "kernel",
    "log_odds",
    "noise_floor",
    "observe",
    "prepared",
    "rows_from",
    "shipped",
    "square_of",
    "versus",
    "whole_change",
]
