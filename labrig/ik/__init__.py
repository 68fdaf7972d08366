"""Inverse kinematics: which pressures make a surface take a given shape, and where it cannot."""

from labrig.ik._baseline import BaselineResult, GradientDescent
from labrig.ik._descent import Pose
from labrig.ik._evaluate import Evaluator, ShapeModel, evaluator
from labrig.ik._models import ShellModel, SurfaceModel
from labrig.ik._result import Gap, IkResult
from labrig.ik._solve import Solver, solve

__all__ = [
    "BaselineResult",
    "Evaluator",
    "Gap",
    "GradientDescent",
    "IkResult",
    "Pose",
    "ShapeModel",
    "ShellModel",
    "Solver",
    "SurfaceModel",
    "evaluator",
    "solve",
]
