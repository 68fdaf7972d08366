"""What cannot be meant is refused in one line, before anything is read, written or moved."""

from pathlib import Path
from typing import Any

import numpy as np
import pytest

import labrig
from labrig import LabrigError
from labrig.campaign import Actuate, Procedure, Settle
from labrig.effects import as_a_run


def refused(function: Any, *given: Any, **named: Any) -> str:
    """What a call that cannot be meant is told."""
    with pytest.raises(LabrigError) as caught:
        function(*given, **named)
    assert "\n" not in str(caught.value)
    return str(caught.value)


def test_a_model_replaces_models_alone(lab: Path, tmp_path: Path) -> None:
    """A rig, a folder and a folder that is not there are refused, and stay as they are; a model is replaced."""
    model, rig = labrig.Model.load(lab / "model.yaml"), tmp_path / "rig.yaml"
    rig.write_text("name: mine\n", encoding="utf-8")
    assert refused(model.save, rig) == f"{rig} exists and is no model file: choose another name"
    assert rig.read_text(encoding="utf-8") == "name: mine\n"
    assert (
        refused(model.save, tmp_path)
        == f"{tmp_path} is a folder: name the file, such as {tmp_path / 'model.yaml'}"
    )
    nowhere = tmp_path / "none" / "model.yaml"
    assert refused(model.save, nowhere) == f"{nowhere}: the folder {nowhere.parent} does not exist"
    (tmp_path / "model.yaml").write_text("base: {kind: static}\nof_another_release: 1\n", encoding="utf-8")
    for _ in range(2):
        model.save(tmp_path / "model.yaml")
    assert labrig.Model.load(tmp_path / "model.yaml").file.base.kind == "simulator"
    assert {entry.name for entry in tmp_path.iterdir()} == {"rig.yaml", "model.yaml"}


def test_a_file_is_no_folder(lab: Path, tmp_path: Path) -> None:
    """Results and runs are not written where a file has the name."""
    file = tmp_path / "file"
    file.write_text("", encoding="utf-8")
    found = labrig.compare(lab / "first", lab / "model.yaml")
    assert (
        refused(found.save, file) == f"save: {file} is a file, where a folder is needed; choose another name"
    )
    said = refused(labrig.run, "capture", lab / "rig.yaml", out=file)
    assert said == f"out: {file} is a file, where a run's folder is needed; choose another name"


def test_a_dimension_that_is_gone(lab: Path) -> None:
    """One capture taken out by a number alone is no run; the message says how its dimension stays."""
    run = labrig.open_run(lab / "first")
    assert "has no `capture`: sel(capture=[0]) keeps it" in refused(
        labrig.compare, run.isel(capture=0), lab / "model.yaml"
    )


@pytest.mark.parametrize("name", ["position_mm", "measured"])
def test_what_is_infinite_was_not_measured(lab: Path, name: str) -> None:
    """A number that is infinite is named with its capture: no noise, no floor and no hint is drawn from it."""
    run = labrig.open_run(lab / "first").copy(deep=True)
    run[name].values[3].flat[0] = np.inf
    assert f"`{name}` is infinite in capture 3: NaN is what was not measured" in refused(
        labrig.compare, run, lab / "model.yaml"
    )


def test_metres_are_no_millimetres(lab: Path) -> None:
    """Positions whose attribute says another unit are refused; those that say nothing, or mm, are taken."""
    run = labrig.open_run(lab / "first")
    metres = run.assign(position_mm=(run["position_mm"] / 1000).assign_attrs(units="m"))
    assert "`position_mm` is said to be in m: it has to be in mm" in refused(
        labrig.compare, metres, lab / "model.yaml"
    )
    as_a_run(run.assign(position_mm=run["position_mm"].drop_attrs()))
    as_a_run(run.assign(position_mm=run["position_mm"].assign_attrs(units="millimeter")))


def test_a_run_without_captures(lab: Path, tmp_path: Path) -> None:
    """A run that ended before its first capture says so, alone and beside another."""
    run = labrig.open_run(lab / "first")
    for given in (run.isel(capture=slice(0)), [run, run.isel(capture=slice(0))]):
        assert "no captures; nothing can be compared" in refused(labrig.compare, given, lab / "model.yaml")


def test_numbers_and_conditions(lab: Path) -> None:
    """A number in quotes, a condition that is a number: one line says what is wanted."""
    assert refused(labrig.runs, lab, where=3).startswith("a condition is needed, and a int was given: ")
    share = refused(labrig.investigate, None, lab / "model.yaml", lab / "rig.yaml", highest="0.85")
    assert share == "highest '0.85': a number is needed, a share of the limit"


def test_a_session_may_be_a_number(lab: Path) -> None:
    """Sessions that are only counted are named by their number, too."""
    ruled = labrig.rule_out(labrig.open_run(lab / "first"), "contact", sessions=0)
    assert set(ruled["ruled_out"].values) == {"contact"}


def test_a_run_of_another_release_is_not_resumed(lab: Path, tmp_path: Path) -> None:
    """A parameter that the run was begun with, and that the procedure does not have now, is named, and whose it is."""
    folder = labrig.run("capture", lab / "rig.yaml", out=tmp_path / "run", captures=3)
    written = folder / "run.yaml"
    text = written.read_text(encoding="utf-8")
    written.write_text(text.replace("parameters:\n", "parameters:\n  gone: 1\n"), encoding="utf-8")
    said = refused(labrig.run, "capture", lab / "rig.yaml", out=folder, resume=True)
    assert said == (
        f"cannot resume {folder}: it was begun with gone, which procedure capture does not have now; start a new run"
    )


def test_another_run_in_the_folder_does_not_go_on_so(lab: Path, tmp_path: Path) -> None:
    """A call that is refused for the run that lies there, half done, is not told that it would go on."""

    def stop(progress: Any) -> None:
        if progress.captures_done >= 1:
            raise KeyboardInterrupt

    with pytest.raises(KeyboardInterrupt):
        labrig.run("capture", lab / "rig.yaml", out=tmp_path / "run", captures=12, progress=stop)
    assert "goes on" not in refused(labrig.run, "hold", lab / "rig.yaml", out=tmp_path / "run")


def test_a_run_that_recorded_nothing_is_named_by_its_folder(lab: Path, tmp_path: Path) -> None:
    """A run whose procedure took no capture is told so where it is named by its path."""

    class Nothing(Procedure):
        def steps(self, rig: Any) -> Any:
            yield Actuate(rig.setpoint())
            yield Settle(0.1)

    folder = labrig.run(Nothing(), lab / "rig.yaml", out=tmp_path / "run")
    assert refused(labrig.compare, folder, lab / "model.yaml").endswith(
        "no captures; nothing can be compared"
    )
