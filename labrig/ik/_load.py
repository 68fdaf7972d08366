"""What `--model` stands for: a learned model, or a model file with its base and its effects."""

from collections.abc import Iterator, Mapping
from functools import lru_cache
from pathlib import Path
from typing import Any

from labrig._errors import LabrigError
from labrig._yaml import read_yaml
from labrig.ik._evaluate import ShapeModel
from labrig.ik._memory import Remembering
from labrig.ik._models import ShellModel, SurfaceModel

_USUAL_KPA = {"max_kpa": 60.0, "min_kpa": 0.0}
"""Limits of a chamber where its rig says none."""


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


def state_of(path: str | Path) -> tuple[tuple[str, int, int], ...]:
    """The files that a model is read from as they are: name, time of the last change, ns, and size, bytes, of each.

    A model file's are its base, a rig and its shell, all that they name in turn, and the user's own effects. What is
    missing or no YAML is left out: whoever reads it complains.
    """
    found: dict[Path, tuple[str, int, int]] = {}
    waiting = [Path(path).resolve()]
    waiting += sorted((waiting[0].parent / "effects").glob("*.py"))
    while waiting:
        file = waiting.pop()
        if file not in found and file.is_file():
            about = file.stat()
            found[file] = str(file), about.st_mtime_ns, about.st_size
            waiting += _named_in(*found[file])
    return tuple(sorted(found.values()))


@lru_cache(maxsize=16)
def _named_in(path: str, _written_ns: int, _size: int) -> tuple[Path, ...]:
    """The files that a file of YAML names, in its own folder or below it, or as whole paths."""
    if not path.lower().endswith((".yaml", ".yml")):
        return ()
    folder = Path(path).parent
    try:
        texts = list(_texts(read_yaml(Path(path), "model")))
    except LabrigError:
        return ()
    return tuple((folder / text).resolve() for text in texts if _is_file(folder / text))


def _is_file(path: Path) -> bool:
    try:
        return path.is_file()
    except (OSError, ValueError):  # too long for a name, or with a null in it
        return False


def _texts(content: Any) -> Iterator[str]:
    if isinstance(content, str):
        yield content
    elif isinstance(content, Mapping):
        for value in content.values():
            yield from _texts(value)
    elif isinstance(content, list):
        for value in content:
            yield from _texts(value)


def _base_shape(base: Any, folder: Path, path: Path) -> ShapeModel:
    if base.kind == "simulator":
        if base.calibrated:
            raise LabrigError(
                f"{path}: calibrated {', '.join(base.calibrated)} is fitted to each run anew, and a shape has no run: "
                "give what it came to on one as `parameters` (docs/reference/model.md, base)"
            )
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
        listed = [c for c in rig.get("chambers") or [] if isinstance(c, dict)]
        high, low = ([float(c.get(key, usual)) for c in listed] or usual for key, usual in _USUAL_KPA.items())
        return SurfaceModel(reduced_surface(rig), high, low)
