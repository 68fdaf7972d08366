"""Models: model.yaml, its base, its effects, and what they predict."""

from labrig.model._at_rest import transients
from labrig.model._bases import BaseModel, build_base, jacobian, solo_deflection
from labrig.model._check import check_base
from labrig.model._file import (
    MOST_DEGREES,
    EffectEntry,
    FittedOn,
    ModelFile,
    StaticBase,
    Value,
    model_text,
    read_model_file,
    write_model_file,
)
from labrig.model._model import Model, Predictor, as_fitted, base_context, evaluate, find_variant
from labrig.model._robust import robust_fit

__all__ = [
    "MOST_DEGREES",
    "BaseModel",
    "EffectEntry",
    "FittedOn",
    "Model",
    "ModelFile",
    "Predictor",
    "StaticBase",
    "Value",
    "as_fitted",
    "base_context",
    "build_base",
    "check_base",
    "evaluate",
    "find_variant",
    "jacobian",
    "model_text",
    "read_model_file",
    "robust_fit",
    "solo_deflection",
    "transients",
    "write_model_file",
]
