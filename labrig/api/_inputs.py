"""What people hand over: paths or things that are opened already; what is neither is refused in one line."""

from collections.abc import Sequence
from numbers import Real
from pathlib import Path
from typing import TYPE_CHECKING, Any

from labrig._errors import LabrigError
from labrig._paths import wrong

if TYPE_CHECKING:
    from xarray import Dataset

    from labrig.model import Model
    from labrig.rig import RigConfig

AnyPath = str | Path


def runs_of(given: Any) -> "list[Dataset]":
    """One or several runs, as paths or as `labrig.open_run` gives them.

    Raises `LabrigError` for an empty list, for the same run twice, for anything else, and where a run cannot be read.
    """
    several = list(given) if isinstance(given, list | tuple) else [given]
    if not several:
        raise LabrigError("no run was given: name a run folder, or what labrig.open_run gives")
    opened = [_run(one) for one in several]
    known = [_known_by(run) for run in opened]
    for run, key in zip(opened, known, strict=True):
        if known.count(key) > 1:
            what = run.attrs.get("run", "a run")
            raise LabrigError(f"{what} is given twice: what it measured counts once")
    return opened


def _known_by(run: "Dataset") -> tuple[Any, ...]:
    """What a run is recognised by, or a part of one, however it was opened and wherever its folder was copied to."""
    if "run_id" not in run.attrs or not run["time_s"].size:
        return (id(run),)
    return run.attrs["run_id"], run.sizes, float(run["time_s"].min())


def _run(given: Any) -> "Dataset":
    from labrig.effects import as_a_run
    from labrig.log import open_run

    if isinstance(given, str | Path):
        if Path(given).suffix in (".yaml", ".yml") and Path(given).is_file():
            raise LabrigError(f"{given} is no run: name the run's folder first, then the model")
        return open_run(given)
    if type(given).__name__ == "Dataset" and hasattr(given, "data_vars"):
        if "commanded" not in given:
            raise LabrigError("the Dataset is no run: it has no `commanded`; labrig.open_run makes one")
        return as_a_run(given, whole=False)
    raise wrong("a run", given, "a run folder's path, or what labrig.open_run gives")


def model_of(given: Any) -> "Model":
    """A model, as a path, as `labrig.Model.load` gives it or a function; raises `LabrigError` for anything else."""
    from labrig.model import Model

    if isinstance(given, Model):
        return given
    if isinstance(given, str | Path):
        return Model.load(given)
    if callable(given):
        return Model.of(given)
    from labrig.surrogate import ForwardModel, Trained, TrainedWarp, WarpedModel

    if isinstance(given, ForwardModel | WarpedModel | Trained | TrainedWarp):
        raise LabrigError(
            'a learned model was given, which a model file names as its base: save it (trained.save("learned.pt")), '
            'write `base: {kind: surrogate, file: learned.pt}` to model.yaml, and give "model.yaml"'
        )
    raise wrong("a model", given, "a model.yaml's path, what labrig.Model.load gives, or a function")


def rig_of(given: Any) -> "RigConfig":
    """A rig, as a path or as `labrig.load_rig` gives it; raises `LabrigError` for anything else."""
    from labrig.rig import RigConfig, load_rig

    if isinstance(given, RigConfig):
        return given
    if isinstance(given, str | Path):
        return load_rig(given)
    raise wrong("a rig", given, "a rig.yaml's path, or what labrig.load_rig gives")


def number(given: Any, what: str, unit: str) -> float:
    """A number; raises `LabrigError` for anything else, such as a text with its unit."""
    if isinstance(given, bool) or not isinstance(given, Real):
        raise LabrigError(f"{what} {given!r}: a number is needed, {unit}")
    return float(given)


def positive(given: Any, what: str, unit: str) -> float:
    """A number larger than 0; raises `LabrigError` for anything else."""
    if not (found := number(given, what, unit)) > 0:
        raise LabrigError(f"{what} {found:g}: must be larger than 0")
    return found


def names_of(given: Any, what: str) -> list[str]:
    """One name or several; raises `LabrigError` for anything else, and for none."""
    names = [given] if isinstance(given, str) else list(given) if isinstance(given, Sequence) else None
    if names is None or not all(isinstance(name, str) for name in names):
        raise wrong(what, given, 'its name, such as "creep", or a list of names')
    if not names:
        raise LabrigError(f'{what}: none was named; give a name, such as "creep", or a list of names')
    return names
