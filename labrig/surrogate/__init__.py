"""Learned models: the forward model and its sim-to-real correction; both run without torch."""

from typing import TYPE_CHECKING

from labrig._lazy import lazy
from labrig.surrogate._forward import ForwardModel
from labrig.surrogate._models import load_forward, load_model, save_forward, save_model
from labrig.surrogate._warped import WarpedModel

if TYPE_CHECKING:
    from labrig.surrogate._captures import Frames, Shot, frames_of, shots_of
    from labrig.surrogate._train_forward import Measured, Trained, measure_errors, train_forward
    from labrig.surrogate._train_warp import METHODS, TrainedWarp, WarpMethod, train_warp
    from labrig.surrogate._training_set import TrainingSet, training_set

_LAZY = {
    "METHODS": "_train_warp",
    "Frames": "_captures",
    "Measured": "_train_forward",
    "Shot": "_captures",
    "Trained": "_train_forward",
    "TrainedWarp": "_train_warp",
    "TrainingSet": "_training_set",
    "frames_of": "_captures",
    "WarpMethod": "_train_warp",
    "measure_errors": "_train_forward",
    "shots_of": "_captures",
    "train_forward": "_train_forward",
    "train_warp": "_train_warp",
    "training_set": "_training_set",
}

__all__ = [
    "METHODS",
    "ForwardModel",
    "Frames",
    "Measured",
    "Shot",
    "Trained",
    "TrainedWarp",
    "TrainingSet",
    "WarpMethod",
    "WarpedModel",
    "frames_of",
    "load_forward",
    "load_model",
    "measure_errors",
    "save_forward",
    "save_model",
    "shots_of",
    "train_forward",
    "train_warp",
    "training_set",
]

__getattr__ = lazy(__name__, _LAZY)
