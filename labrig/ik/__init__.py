"""Inverse kinematics: which pressures make a surface take a given shape, and where it cannot."""

from labrig.ik._baseline import BaselineResult, GradientDescent
from labrig.ik._descent import Pose
from labrig.ik._evaluate import Evaluator, ShapeModel, evaluator
from labrig.ik._memory import Path, Remembering
from labrig.ik._models import ShellModel, SurfaceModel
from labrig.ik._path import Plan, plan_path, solve_with_path
from labrig.ik._result import Gap, IkResult
from labrig.ik._solve import Solver, solve

__all__ = [
    "BaselineResult",
    "Evaluator",
    "Gap",
    "GradientDescent",
    "IkResult",
    "Path",
    "Plan",
    "Pose",
    "Remembering",
    "ShapeModel",
    "ShellModel",
    "Solver",
    "SurfaceModel",
    "evaluator",
    "plan_path",
    "solve",
    "solve_with_path",
]
