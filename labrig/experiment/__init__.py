"""The next experiment: the pressure programme that tells what a diagnosis leaves open apart, best per minute."""

from labrig.experiment._plan import Limits
from labrig.experiment._propose import Experiment, plan_next, propose_experiment

__all__ = ["Experiment", "Limits", "plan_next", "propose_experiment"]
