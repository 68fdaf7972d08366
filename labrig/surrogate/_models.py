"""Learned models saved and loaded: forward models, and those with a sim-to-real correction."""

from pathlib import Path
from typing import Any

import numpy as np

from labrig._errors import LabrigError
from labrig.surrogate._file import Arrays, read_file, write_file
from labrig.surrogate._forward import ForwardModel
from labrig.surrogate._pack import Unpacking, pack_forward, pack_warped, unpack_forward, unpack_warped
from labrig.surrogate._warped import WarpedModel

_KINDS = {"forward": "a forward model", "warped": "a model with a sim-to-real correction"}


def save_model(model: ForwardModel | WarpedModel, path: str | Path) -> None:
    """Write a model, in one piece or not at all; raises `LabrigError` for one with numbers that are not finite."""
    arrays: Arrays = {}
    if isinstance(model, ForwardModel):
        facts: dict[str, Any] = {"kind": "forward", "model": pack_forward(model, arrays)}
    else:
        facts = {"kind": "warped", "model": pack_warped(model, arrays)}
    single = {name: np.array(facts["model"].get(name, 0.0)) for name in ("noise_mm", "factor", "c_per_mm2")}
    _check_finite(arrays | single, path)
    write_file(path, facts, arrays)


def _check_finite(arrays: Arrays, path: str | Path) -> None:
    for name, values in arrays.items():
        if not np.isfinite(values).all():
            raise LabrigError(
                f"{path}: was not written: the model's {name} has numbers that are not finite; it was learned from too "
                "little, or from numbers that are none: train it on more captures, or by another method"
            )


def load_model(path: str | Path) -> ForwardModel | WarpedModel:
    """Read a model of either kind, without running anything that is in the file.

    Raises `LabrigError` for a file that is missing, foreign, damaged, or of a newer labrig.
    """
    facts, arrays = read_file(path)
    kind, model = facts.get("kind"), facts.get("model")
    if kind not in _KINDS or not isinstance(model, dict):
        raise LabrigError(f"{path}: is damaged (there is no model of kind {kind!r})")
    part = Unpacking(Path(path), model, arrays)
    return unpack_forward(part) if kind == "forward" else unpack_warped(part)


def save_forward(model: ForwardModel, path: str | Path) -> None:
    """Write a forward model, in one piece or not at all."""
    save_model(model, path)


def load_forward(path: str | Path) -> ForwardModel:
    """Read a forward model; raises `LabrigError` as `load_model`, and for a model of the other kind."""
    model = load_model(path)
    if not isinstance(model, ForwardModel):
        raise LabrigError(f"{path}: is {_KINDS['warped']}; {_KINDS['forward']} is needed")
    return model
