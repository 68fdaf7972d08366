"""What `--model` stands for: a learned model, or a model file with its base and its effects."""

from collections.abc import Mapping
from pathlib import Path
from typing import Any

import numpy as np

from labrig._errors import LabrigError
from labrig.ik._evaluate import ShapeModel
from labrig.ik._memory import Remembering
from labrig.ik._models import ShellModel, SurfaceModel


def load_shape_model(path: str | Path) -> tuple[ShapeModel, Remembering | None]:
    """The model's surface, and the same with what it remembers where a model file names effects.

    `path`: what `labrig train` wrote (forward.pt, sim2real.pt), or a model.yaml whose base is a simulator or one of
    these. Raises `LabrigError` for anything else.
    """
    path = Path(path)
    if path.suffix.lower() not in (".yaml", ".yml"):
        from labrig.surrogate import load_model

        return load_model(path), None
    from labrig.model import Model

    model = Model.load(path)
    shape = _base_shape(model.file.base, model.folder, path)
    return shape, Remembering(model, shape) if model.file.effects else None


def _base_shape(base: Any, folder: Path, path: Path) -> ShapeModel:
    if base.kind == "simulator":
        return rig_shape(folder / base.rig, base.parameters)
    if base.kind == "surrogate":
        from labrig.surrogate import load_model

        return load_model(folder / base.file)
    raise LabrigError(
        f"{path}: a base of kind {base.kind} predicts markers, no surface: use a simulator or a surrogate"
    )


def rig_shape(path: Path, parameters: Mapping[str, float] | None = None) -> ShapeModel:
    """The simulator of a rig.yaml, with the rig's chambers and limits; a shell at other `parameters`, if given."""
    from labrig.physics import has_shell, of_rig_file, read_rig_file, reduced_surface, rig_shell

    rig = read_rig_file(path)
    with of_rig_file(path):
        if has_shell(rig):
            return ShellModel(rig_shell(rig, path.parent).changed(None, **(parameters or {})))
        limits = [float(c.get("max_kpa", 60.0)) for c in rig.get("chambers") or [] if isinstance(c, dict)]
        return SurfaceModel(reduced_surface(rig), np.array(limits) if limits else 60.0)
