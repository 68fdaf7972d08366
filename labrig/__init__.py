"""labrig: run a soft-robotics rig, log its campaigns, and find the physics its model is missing.

    import labrig

    run = labrig.open_run("runs/first")                    # what a rig measured, or
    run = labrig.import_table("map.yaml", "runs/mine")     # a table of your own
    found = labrig.diagnose(run, "model.yaml")             # what does the model lack?
    found.effects                                          # every effect, how probable and how large
    better = labrig.improve(run, "model.yaml", found.sure) # add it, fitted
    better.model.save("improved.yaml")

Runs, models and rigs are taken as paths or opened. The public names are imported when they are first used, so that
``import labrig`` stays quick.
"""

from importlib import import_module
from typing import TYPE_CHECKING, Any

from labrig._errors import LabrigError, NothingToDoError

if TYPE_CHECKING:
    from labrig.api._check import check
    from labrig.api._compare import Comparison, ModelComparison, compare
    from labrig.api._diagnose import Diagnosis, diagnose
    from labrig.api._history import History, history
    from labrig.api._ik import solve_ik
    from labrig.api._improve import Improvement, improve
    from labrig.api._investigate import Investigation, investigate
    from labrig.api._learn import train_forward, train_sim2real
    from labrig.api._predict import predict
    from labrig.api._propose import Proposal, propose_experiment
    from labrig.api._rule_out import rule_out
    from labrig.api._run import run
    from labrig.api._table import import_table
    from labrig.api._validate import Validation, validate
    from labrig.catalogue import runs
    from labrig.log import open_run
    from labrig.model import Model
    from labrig.rig import load_rig
    from labrig_drivers import DeviceError

__version__ = "0.24.0"

_LAZY = {
    "Comparison": "labrig.api._compare",
    "DeviceError": "labrig_drivers",
    "Diagnosis": "labrig.api._diagnose",
    "History": "labrig.api._history",
    "Improvement": "labrig.api._improve",
    "Investigation": "labrig.api._investigate",
    "Model": "labrig.model",
    "ModelComparison": "labrig.api._compare",
    "Proposal": "labrig.api._propose",
    "Validation": "labrig.api._validate",
    "check": "labrig.api._check",
    "compare": "labrig.api._compare",
    "diagnose": "labrig.api._diagnose",
    "history": "labrig.api._history",
    "import_table": "labrig.api._table",
    "improve": "labrig.api._improve",
    "investigate": "labrig.api._investigate",
    "load_rig": "labrig.rig",
    "open_run": "labrig.log",
    "predict": "labrig.api._predict",
    "propose_experiment": "labrig.api._propose",
    "rule_out": "labrig.api._rule_out",
    "run": "labrig.api._run",
    "runs": "labrig.catalogue",
    "solve_ik": "labrig.api._ik",
    "train_forward": "labrig.api._learn",
    "train_sim2real": "labrig.api._learn",
    "validate": "labrig.api._validate",
}

__all__ = [
    "Comparison",
    "DeviceError",
    "Diagnosis",
    "History",
    "Improvement",
    "Investigation",
    "LabrigError",
    "Model",
    "ModelComparison",
    "NothingToDoError",
    "Proposal",
    "Validation",
    "__version__",
    "check",
    "compare",
    "diagnose",
    "history",
    "import_table",
    "improve",
    "investigate",
    "load_rig",
    "open_run",
    "predict",
    "propose_experiment",
    "rule_out",
    "run",
    "runs",
    "solve_ik",
    "train_forward",
    "train_sim2real",
    "validate",
]


def __getattr__(name: str) -> Any:
    if name in _LAZY:
        return getattr(import_module(_LAZY[name]), name)
    raise AttributeError(f"module 'labrig' has no attribute {name!r}")


def __dir__() -> list[str]:
    return sorted(__all__)
