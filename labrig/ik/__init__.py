"""Inverse kinematics: which pressures make a surface take a given shape, and where it cannot."""

from labrig.ik._baseline import BaselineResult, GradientDescent
from labrig.ik._batch import Job, Solved, solve_files, solve_job
from labrig.ik._descent import Pose
from labrig.ik._evaluate import Evaluator, ShapeModel, evaluator
from labrig.ik._load import load_shape_model
from labrig.ik._memory import Approach, Remembering
from labrig.ik._models import ShellModel, SurfaceModel
from labrig.ik._path import Plan, plan_path, solve_with_path
from labrig.ik._result import Gap, IkResult
from labrig.ik._solve import Solver, solve

__all__ = [
    "Approach",
    "BaselineResult",
    "Evaluator",
    "Gap",
    "GradientDescent",
    "IkResult",
    "Job",
    "Plan",
    "Pose",
    "Remembering",
    "ShapeModel",
    "ShellModel",
    "Solved",
    "Solver",
    "SurfaceModel",
    "evaluator",
    "load_shape_model",
    "plan_path",
    "solve",
    "solve_files",
    "solve_job",
    "solve_with_path",
]
