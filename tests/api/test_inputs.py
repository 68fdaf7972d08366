"""What is handed over wrong is refused in one clear line."""

from pathlib import Path
from typing import Any

import pytest
import xarray as xr

import labrig
from labrig import LabrigError

RUN = "a run is needed, and a {} was given: a run folder's path, or what labrig.open_run gives"
MODEL = "a model is needed, and a {} was given: a model.yaml's path, or what labrig.Model.load gives"


@pytest.mark.parametrize(
    ("runs", "text"),
    [
        (7, RUN.format("int")),
        (None, RUN.format("NoneType")),
        ([None], RUN.format("NoneType")),
        ({"run": 1}, RUN.format("dict")),
        ([], "no run was given: name a run folder, or what labrig.open_run gives"),
        (xr.Dataset(), "the Dataset is no run: it has no `commanded`; labrig.open_run makes one"),
    ],
)
@pytest.mark.parametrize("function", [labrig.compare, labrig.diagnose])
def test_what_is_no_run_is_said_so(function: Any, runs: Any, text: str) -> None:
    """A number, nothing, a table of something else: one line that says what is wanted."""
    with pytest.raises(LabrigError) as caught:
        function(runs, "model.yaml")
    assert str(caught.value) == text


def test_what_is_no_model_is_said_so(lab: Path) -> None:
    """Neither a path nor a model."""
    with pytest.raises(LabrigError) as caught:
        labrig.compare(lab / "first", 3.0)
    assert str(caught.value) == MODEL.format("float")


def test_one_name_is_no_list_of_letters(lab: Path) -> None:
    """improve(run, model, "crep") speaks of crep, not of c."""
    with pytest.raises(LabrigError, match="'crep'"):
        labrig.improve(lab / "first", lab / "model.yaml", "crep")
    with pytest.raises(LabrigError, match="an effect to add: none was named"):
        labrig.improve(lab / "first", lab / "model.yaml", [])
    with pytest.raises(LabrigError, match="an effect to add is needed, and a int was given"):
        labrig.improve(lab / "first", lab / "model.yaml", 3)


def test_a_run_with_wrong_parameters_moves_nothing(lab: Path, tmp_path: Path) -> None:
    """A procedure that is none, a parameter that is none, a rig that is none: before anything is connected."""
    wrong: Any = (
        (("captur", lab / "rig.yaml"), {}, "there is no procedure 'captur'"),
        (("capture", lab / "rig.yaml"), {"captures": 0}, "procedure capture: captures"),
        (("capture", lab / "rig.yaml"), {"captres": 3}, "captres"),
        (("capture", 4), {}, "a rig is needed, and a int was given"),
    )
    for arguments, parameters, text in wrong:
        with pytest.raises(LabrigError, match=text):
            labrig.run(*arguments, out=tmp_path / "run", **parameters)
    assert not (tmp_path / "run").exists()
