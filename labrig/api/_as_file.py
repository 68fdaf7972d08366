"""A model as a file: what is handed over as an object is written to a folder that is gone afterwards."""

import tempfile
from collections.abc import Iterator
from contextlib import contextmanager
from pathlib import Path
from typing import TYPE_CHECKING

from labrig._paths import path_of
from labrig.api._inputs import AnyPath

if TYPE_CHECKING:
    from labrig.model import Model
    from labrig.surrogate import ForwardModel, Trained, TrainedWarp, WarpedModel

    ShapeModelGiven = AnyPath | Model | Trained | TrainedWarp | ForwardModel | WarpedModel

WANTED = "its file, such as forward.pt or model.yaml, or the model"


@contextmanager
def as_file(given: "ShapeModelGiven") -> "Iterator[Path]":
    """The file of a model of a surface: its path, what `labrig.Model.load` gives, or what was just learnt.

    Processes read models from files. Raises `LabrigError` for anything else, and for a model whose base is a function
    that exists only in this session.
    """
    if isinstance(given, str | Path):
        yield Path(given)
        return
    from labrig.model import Model
    from labrig.surrogate import ForwardModel, Trained, TrainedWarp, WarpedModel, save_model

    if isinstance(given, Model) and given.path is not None:
        yield given.path
        return
    with tempfile.TemporaryDirectory(prefix="labrig-model-", ignore_cleanup_errors=True) as folder:
        if isinstance(given, Trained | TrainedWarp):
            given = given.model
        if isinstance(given, ForwardModel | WarpedModel):
            path = Path(folder) / "model.pt"
            save_model(given, path)
        elif isinstance(given, Model):
            path = Path(folder) / "model.yaml"
            given.save(path)
        else:
            path = path_of(given, "a model", WANTED)
        yield path
