"""A model that is handed over as an object is read from a file, as processes need it."""

from dataclasses import replace
from pathlib import Path

import pytest

import labrig
from labrig import LabrigError
from labrig.api._as_file import as_file
from labrig.api._validate import _kept_file
from labrig.effects import write_template
from labrig.physics import load_shell, simulate
from labrig.surrogate import load_model


def test_a_model_of_a_file_is_that_file(lab: Path) -> None:
    """Nothing is written where the model stands in a file already."""
    for given in (lab / "model.yaml", str(lab / "model.yaml"), labrig.Model.load(lab / "model.yaml")):
        with as_file(given) as path:
            assert path == lab / "model.yaml"


def test_a_changed_model_is_written_with_what_it_names(lab: Path, tmp_path: Path) -> None:
    """Its rig and its own effects are found from the file's folder, which is gone afterwards."""
    (tmp_path / "rig.yaml").write_bytes((lab / "rig.yaml").read_bytes())
    (tmp_path / "model.yaml").write_text(
        "base: {kind: simulator, rig: rig.yaml}\n"
        "effects: [{name: swelling, form: simple, parameters: {amplitude: {value: 0.1}}}]\n"
    )
    write_template("swelling", tmp_path)
    changed = replace(labrig.Model.load(tmp_path / "model.yaml"), path=None)
    with as_file(changed) as path:
        assert path.parent not in (lab, tmp_path)
        read = labrig.Model.load(path)
        assert [entry.name for entry in read.file.effects] == ["swelling"]
        assert (read.folder / read.file.base.rig).resolve() == tmp_path / "rig.yaml"  # type: ignore[union-attr]
    assert not path.parent.exists()


def test_a_function_stands_in_no_file() -> None:
    """A model of a notebook's function, and what is no model at all, are refused in one line."""
    with pytest.raises(LabrigError, match="exists only in this session"), as_file(labrig.Model.of(abs)):
        pass
    with pytest.raises(LabrigError, match=r"or the model$"), as_file(7):  # type: ignore[arg-type]
        pass


def test_a_model_that_was_just_learnt_is_kept_beside_a_validation(tmp_path: Path) -> None:
    """A report asks it again, so it is a file for as long as the run; another file of that name is not replaced."""
    simulate(load_shell("membrane4").changed(count=(8, 8)), tmp_path / "sims", 20, workers=1)
    trained = labrig.train_forward(tmp_path / "sims")
    path = _kept_file(trained, tmp_path / "runs" / "first")
    assert path == tmp_path / "runs" / "first-model.pt"
    assert load_model(path).chamber_names == trained.model.chamber_names
    with pytest.raises(LabrigError, match="is there already"):
        _kept_file(trained.model, tmp_path / "runs" / "first")
    with pytest.raises(LabrigError, match="save it first"):
        _kept_file(labrig.Model.of(abs), tmp_path / "runs" / "second")


def test_a_validation_that_did_not_begin_leaves_no_model(lab: Path, tmp_path: Path) -> None:
    """After a rig or a target of no use the same folder can be named again."""
    simulate(load_shell("membrane4").changed(count=(8, 8)), tmp_path / "sims", 20, workers=1)
    trained = labrig.train_forward(tmp_path / "sims")
    (tmp_path / "a.xyz").write_text("0 0 0\n")
    for _ in range(2):
        with pytest.raises(LabrigError, match="is 0 across"):
            labrig.validate(tmp_path / "a.xyz", lab / "rig.yaml", trained, out=tmp_path / "first")
    assert not (tmp_path / "first-model.pt").exists()
