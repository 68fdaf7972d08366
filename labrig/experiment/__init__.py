"""The next experiment: the pressure programme that tells what a diagnosis leaves open apart, best per minute."""

from labrig.experiment._again import Again, again
from labrig.experiment._experiment import Experiment
from labrig.experiment._file import write_procedure
from labrig.experiment._plan import Limits, as_rows
from labrig.experiment._propose import plan_next, propose_experiment
from labrig.experiment._rig import check_rig, limits_of, on_rig

__all__ = [
    "Again",
    "Experiment",
    "Limits",
    "again",
    "as_rows",
    "check_rig",
    "limits_of",
    "on_rig",
    "plan_next",
    "propose_experiment",
    "write_procedure",
]
