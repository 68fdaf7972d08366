"""Diagnosis: the noise floor, where a model fails, what it lacks, and how sure that is."""

from labrig.diagnosis._diagnose import diagnose
from labrig.diagnosis._experiment import Experiment, Limits, plan_next, propose_experiment
from labrig.diagnosis._improve import compare, improve
from labrig.diagnosis._opened import Fall, Opened, Trial
from labrig.diagnosis._present import whole_change
from labrig.diagnosis._problem import prepare, rows_from
from labrig.diagnosis._result import Result, Signature, plain, write_json
from labrig.diagnosis._versus import versus

__all__ = [
    "Experiment",
    "Fall",
    "Limits",
    "Opened",
    "Result",
    "Signature",
    "Trial",
    "compare",
    "diagnose",
    "improve",
    "plain",
    "plan_next",
    "prepare",
    "propose_experiment",
    "rows_from",
    "versus",
    "whole_change",
    "write_json",
]
