"""Diagnosis: the noise floor, where a model fails, what it lacks, and how sure that is."""

from labrig.diagnosis._candidates import Candidate, Fit, fit
from labrig.diagnosis._ceiling import STATIC, covariates, kernel
from labrig.diagnosis._diagnose import diagnose
from labrig.diagnosis._formula import forms_of
from labrig.diagnosis._improve import compare, improve
from labrig.diagnosis._opened import Fall, Opened, Trial
from labrig.diagnosis._present import whole_change
from labrig.diagnosis._problem import prepare, rows_from
from labrig.diagnosis._result import Result, Signature, plain, write_json
from labrig.diagnosis._streams import Streams
from labrig.diagnosis._versus import versus

__all__ = [
    "STATIC",
    "Candidate",
    "Fall",
    "Fit",
    "Opened",
    "Result",
    "Signature",
    "Streams",
    "Trial",
    "compare",
    "covariates",
    "diagnose",
    "fit",
    "forms_of",
    "improve",
    "kernel",
    "plain",
    "prepare",
    "rows_from",
    "versus",
    "whole_change",
    "write_json",
]
