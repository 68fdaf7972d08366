"""Diagnosis: the noise floor, where a model fails, what it lacks, and how sure that is."""

from labrig.diagnosis._candidates import Candidate, Fit, fit
from labrig.diagnosis._ceiling import STATIC, covariates, kernel
from labrig.diagnosis._diagnose import diagnose
from labrig.diagnosis._formula import forms_of
from labrig.diagnosis._improve import compare, improve
from labrig.diagnosis._problem import prepare, rows_from
from labrig.diagnosis._result import Result, Signature, write_json
from labrig.diagnosis._streams import Streams

__all__ = [
    "STATIC",
    "Candidate",
    "Fit",
    "Result",
    "Signature",
    "Streams",
    "compare",
    "covariates",
    "diagnose",
    "fit",
    "forms_of",
    "improve",
    "kernel",
    "prepare",
    "rows_from",
    "write_json",
]
