"""Whether what a model names can be had, asked before anything is measured for it."""

from labrig._errors import LabrigError
from labrig.model._file import OdeBase, PythonBase
from labrig.model._model import Model
from labrig.model._python import function_of, load_function


def check_base(model: Model, name: str) -> None:
    """Raise `LabrigError`, with the model's `name`, for a base whose files or functions are not there.

    Nothing is evaluated: what a function makes of a run is not known before.
    """
    spec, folder = model.file.base, model.folder
    if isinstance(spec, PythonBase) and spec.given is not None:
        return
    for field in ("file", "rig"):
        file = getattr(spec, field, None)
        if file is not None and not (folder / file).is_file():
            raise LabrigError(f"{name}: base: {field}: there is no file {folder / file}")
    if isinstance(spec, PythonBase):
        function_of(spec, folder)
    elif isinstance(spec, OdeBase):
        for function in (spec.rate, spec.output):
            load_function(folder / spec.file, function)
