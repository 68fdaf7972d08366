"""Inverse kinematics: which pressures make a surface take a given shape, and where it cannot."""

from labrig.ik._baseline import BaselineResult, GradientDescent
from labrig.ik._batch import Job, Solved, solve_files, solve_job
from labrig.ik._descent import Pose
from labrig.ik._evaluate import Evaluator, ShapeModel, evaluator
from labrig.ik._file import write_solved
from labrig.ik._gaps import Gap
from labrig.ik._load import load_shape_model
from labrig.ik._memory import Approach, Remembering
from labrig.ik._models import ShellModel, SurfaceModel
from labrig.ik._outcome import Attempt, Outcome, outcomes
from labrig.ik._path import Plan, plan_path, solve_with_path
from labrig.ik._placed import Placed, placed
from labrig.ik._refine import Refinement
from labrig.ik._result import IkResult
from labrig.ik._solve import Solver, solve
from labrig.ik._trial import WHOLE, Trial, make_trials

__all__ = [
    "WHOLE",
    "Approach",
    "Attempt",
    "BaselineResult",
    "Evaluator",
    "Gap",
    "GradientDescent",
    "IkResult",
    "Job",
    "Outcome",
    "Placed",
    "Plan",
    "Pose",
    "Refinement",
    "Remembering",
    "ShapeModel",
    "ShellModel",
    "Solved",
    "Solver",
    "SurfaceModel",
    "Trial",
    "evaluator",
    "load_shape_model",
    "make_trials",
    "outcomes",
    "placed",
    "plan_path",
    "solve",
    "solve_files",
    "solve_job",
    "solve_with_path",
    "write_solved",
]
