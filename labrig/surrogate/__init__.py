"""What learns: the forward model from simulations, and its fix from what a rig showed; both run without torch."""

from importlib import import_module
from typing import TYPE_CHECKING, Any

from labrig.surrogate._forward import ForwardModel
from labrig.surrogate._models import load_forward, load_model, save_forward, save_model
from labrig.surrogate._warped import WarpedModel

if TYPE_CHECKING:
    from labrig.surrogate._train_forward import Trained, measure_errors, train_forward
    from labrig.surrogate._training_set import TrainingSet, training_set

_LAZY = {
    "Trained": "_train_forward",
    "TrainingSet": "_training_set",
    "measure_errors": "_train_forward",
    "train_forward": "_train_forward",
    "training_set": "_training_set",
}

__all__ = [
    "ForwardModel",
    "Trained",
    "TrainingSet",
    "WarpedModel",
    "load_forward",
    "load_model",
    "measure_errors",
    "save_forward",
    "save_model",
    "train_forward",
    "training_set",
]


def __getattr__(name: str) -> Any:
    if name in _LAZY:
        return getattr(import_module(f"labrig.surrogate.{_LAZY[name]}"), name)
    raise AttributeError(f"module 'labrig.surrogate' has no attribute {name!r}")
