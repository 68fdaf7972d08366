"""What the worker holds open: runs beside models, opened once, asked often. Runs in the worker's process."""

from collections import OrderedDict
from pathlib import Path
from typing import TYPE_CHECKING

from labrig._own_code import USER_FOLDER
from labrig.log import NOTES, segment_paths

if TYPE_CHECKING:
    from labrig.diagnosis import Opened, Trial

Key = tuple[str, str]
_MOST = 3
_MOST_TRIALS = 64

_opened: OrderedDict[tuple[Key, str], "Opened"] = OrderedDict()
_trials: OrderedDict[tuple[tuple[Key, str], tuple[tuple[str, ...], tuple[str, ...]], bool], "Trial"] = (
    OrderedDict()
)


def ready() -> None:
    """Import what will be needed, so that the first who asks does not wait for it."""
    import xarray

    import labrig.diagnosis
    import labrig.effects
    import labrig.physics
    import labrig.view

    labrig.effects.library()
    _ = labrig.open_run, labrig.Model, labrig.physics.ShellSurface, labrig.view.cloud, labrig.view.pictures_of
    xarray.Dataset({"nothing": ("n", [0.0])})  # looks for every kind of array that is installed


def opened(key: Key) -> "Opened":
    """The run and the model of these paths; read again when either has changed. Raises `LabrigError`."""
    import labrig
    from labrig.diagnosis import Opened

    known = (key, stamp(key))
    if known in _opened:
        _opened.move_to_end(known)
        return _opened[known]
    _opened[known] = Opened(labrig.open_run(key[0]), labrig.Model.load(key[1]))
    while len(_opened) > _MOST:
        gone, _ = _opened.popitem(last=False)
        for each in [each for each in _trials if each[0] == gone]:
            del _trials[each]
    return _opened[known]


def trial(key: Key, names: tuple[str, ...], refine: bool, beside: tuple[str, ...] = ()) -> "Trial":
    """These effects added to the model, fitted; kept, as a person goes to and fro. With `beside`, to these as they are
    where they are fitted by themselves.
    """
    asked = ((key, stamp(key)), (names, beside), refine)
    if asked not in _trials:
        others = trial(key, beside, True) if beside else None
        _trials[asked] = opened(key).add((*beside, *names), refine=refine, beside=others)
        while len(_trials) > _MOST_TRIALS:
            _trials.popitem(last=False)
    return _trials[asked]


def warm(key: Key, effect: str) -> None:
    """Find the forms of an effect before somebody asks."""
    own = opened(key)
    own.forms(own.model.library()[effect])


def names(key: Key) -> list[str]:
    """The effects that could be added: those of the library that the model has not yet."""
    model = opened(key).model
    has = {entry.name for entry in model.file.effects}
    return [name for name in model.library() if name not in has]


def stamp(key: Key) -> str:
    """Which files these are, how large and from when: those of the run, the model's, and what lies beside it, own
    effects, too.
    """
    run, model = Path(key[0]), Path(key[1])
    files = [path for _, path in segment_paths(run)] + [path for path in (run / NOTES,) if path.is_file()]
    files += sorted(
        path for path in model.parent.iterdir() if path.suffix in (".yaml", ".py", ".npz", ".pt", ".npy")
    )
    for folder in dict.fromkeys([model.resolve().parent, Path.cwd()]):
        files += sorted((folder / USER_FOLDER).glob("*.py"))
    return repr([(path.name, path.stat().st_size, path.stat().st_mtime_ns) for path in files])
