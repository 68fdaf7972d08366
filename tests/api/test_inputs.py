"""What is handed over wrong is refused in one clear line."""

import shutil
from copy import deepcopy
from pathlib import Path
from typing import Any, ClassVar

import pytest
import xarray as xr

import labrig
from labrig import LabrigError
from labrig.api._inputs import runs_of
from labrig.campaign import Actuate, Procedure, Record, Settle

RUN = "a run is needed, and a {} was given: a run folder's path, or what labrig.open_run gives"
MODEL = (
    "a model is needed, and a {} was given: a model.yaml's path, what labrig.Model.load gives, or a function"
)


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


def test_a_run_counts_once(lab: Path, tmp_path: Path) -> None:
    """The same folder under two names, opened or not, or a copy of it is refused: it would count twice. Two parts of
    one are two.
    """
    with pytest.raises(LabrigError, match=r"first is given twice: what it measured counts once$"):
        labrig.compare([lab / "first", lab / "." / "first"], lab / "model.yaml")
    run = labrig.open_run(lab / "first")
    shutil.copytree(lab / "first", tmp_path / "copy")
    for again in (run, labrig.open_run(lab / "first"), lab / "first", tmp_path / "copy"):
        with pytest.raises(LabrigError, match=r" is given twice: what it measured counts once$"):
            labrig.compare([run, again], lab / "model.yaml")
    parts = [run.isel(capture=slice(20)), run.isel(capture=slice(20, None))]
    assert [len(one["capture"]) for one in runs_of(parts)] == [20, 20]


def test_what_is_no_model_is_said_so(lab: Path) -> None:
    """Neither a path nor a model."""
    with pytest.raises(LabrigError) as caught:
        labrig.compare(lab / "first", 3.0)
    assert str(caught.value) == MODEL.format("float")


def test_a_learned_model_is_named_as_a_base(lab: Path) -> None:
    """A learned model that was given as an object is answered as its file is: a model file names it as its base."""
    from labrig.surrogate import ForwardModel

    learned = ForwardModel.__new__(ForwardModel)
    with pytest.raises(
        LabrigError, match=r"a learned model was given.*`base: \{kind: surrogate, file: .*to model.yaml"
    ):
        labrig.compare(lab / "first", learned)


def test_nothing_to_settle_can_be_caught(lab: Path, diagnosis: labrig.Diagnosis) -> None:
    """Where nothing is in doubt, `propose_experiment` raises what `labrig` names, so that a notebook can catch it."""
    nothing = deepcopy(diagnosis)
    nothing.summary["verdict"] = "nothing_missing"
    with pytest.raises(labrig.NothingToDoError, match="nothing to settle"):
        labrig.propose_experiment(lab / "first", lab / "model.yaml", diagnosis=nothing)


def test_targets_are_looked_for_first(lab: Path, tmp_path: Path) -> None:
    """A target that is not there is said before any other is solved."""
    (tmp_path / "a.ply").write_text("ply")
    with pytest.raises(LabrigError, match=r"b\.ply does not exist$"):
        labrig.solve_ik([tmp_path / "a.ply", tmp_path / "b.ply"], lab / "model.yaml")


def test_an_effect_to_leave_out_must_be_there(lab: Path) -> None:
    """A misspelt name would leave nothing out, and nobody would know."""
    with pytest.raises(LabrigError) as caught:
        labrig.diagnose(lab / "first", lab / "model.yaml", without=["hysterisis"])
    assert str(caught.value) == "there is no effect 'hysterisis' to leave out; did you mean hysteresis?"
    with pytest.raises(LabrigError, match=r"^without wrap: there are "):
        labrig.validate("body.ply", lab / "rig.yaml", "forward.pt", without="wrap")


@pytest.mark.parametrize(
    ("call", "said"),
    [
        (
            lambda lab: labrig.diagnose(lab / "first", lab / "model.yaml", tolerance="0.1 mm"),
            "tolerance '0.1 mm'",
        ),
        (
            lambda lab: labrig.propose_experiment(lab / "first", lab / "model.yaml", minutes="5 min"),
            "minutes '5 min'",
        ),
        (
            lambda lab: labrig.investigate(None, lab / "model.yaml", lab / "rig.yaml", budget_min="30"),
            "budget_min '30'",
        ),
    ],
)
def test_a_text_is_no_number(lab: Path, call: Any, said: str) -> None:
    """A number with its unit in a text is refused with the unit that is meant."""
    with pytest.raises(LabrigError) as caught:
        call(lab)
    assert str(caught.value).startswith(f"{said}: a number is needed, ")


def test_a_run_that_failed_says_how_it_goes_on(lab: Path, tmp_path: Path) -> None:
    """The last words of an error in the middle say how to measure the rest; those of one before all steps do not."""
    folder = tmp_path / "run"

    class Failing(Procedure):
        fails_before: int = 2
        fails: ClassVar[bool] = True

        def steps(self, rig: Any) -> Any:
            for k in range(4):
                if k == self.fails_before and self.fails and (k == 0 or (folder / "log.000.mcap").exists()):
                    raise ValueError("no more")
                yield Actuate(rig.setpoint())
                yield Settle(0.1)
                yield Record(0.5)

    with pytest.raises(LabrigError, match="no more") as early:
        labrig.run(Failing(fails_before=0), lab / "rig.yaml", out=folder)
    assert "resume=True" not in str(early.value)
    with pytest.raises(LabrigError, match="no more") as failed:
        labrig.run(Failing(), lab / "rig.yaml", out=folder)
    goes_on = f"labrig.run with resume=True, out={str(folder)!r} and the same arguments goes on"
    assert str(failed.value).endswith(f"; {goes_on}")
    before = labrig.open_run(folder).sizes["capture"]
    Failing.fails = False
    labrig.run(Failing(), lab / "rig.yaml", out=folder, resume=True)
    assert labrig.open_run(folder).sizes["capture"] == 4 > before


def test_the_diagnosis_of_another_run_plans_nothing(
    lab: Path, diagnosis: labrig.Diagnosis, tmp_path: Path
) -> None:
    """What another run leaves open says nothing of this one."""
    labrig.run("capture", lab / "rig.yaml", out=tmp_path / "other", captures=3)
    with pytest.raises(
        LabrigError, match=r"^the diagnosis is one of .*first: give the diagnosis of these runs"
    ):
        labrig.propose_experiment(tmp_path / "other", lab / "model.yaml", diagnosis=diagnosis)


def test_a_run_that_was_stopped_goes_on(lab: Path, tmp_path: Path) -> None:
    """KeyboardInterrupt in `progress` ends a run as Ctrl-C does; the same call with resume=True measures the rest,
    as its last words say; until then the run says that it is not all of it.
    """

    def stop(progress: Any) -> None:
        if progress.captures_done >= 2:
            raise KeyboardInterrupt

    given: dict[str, Any] = {"out": tmp_path / "run", "captures": 12}
    with pytest.raises(KeyboardInterrupt, match="stopped by progress") as stopped:
        labrig.run("capture", lab / "rig.yaml", progress=stop, **given)
    assert str(stopped.value).endswith(
        f"vented; labrig.run with resume=True, out={str(tmp_path / 'run')!r} and the same arguments goes on"
    )
    (said,) = labrig.open_run(tmp_path / "run").attrs["warnings"]
    before = labrig.open_run(tmp_path / "run").sizes["capture"]
    assert said.startswith(f"{before} of 12 captures: stopped by progress; labrig.run(..., out=")
    assert 2 <= before < 12
    with pytest.raises(LabrigError, match=r"captures was 12, now it is 13"):
        labrig.run("capture", lab / "rig.yaml", resume=True, out=given["out"], captures=13)
    labrig.run("capture", lab / "rig.yaml", resume=True, out=given["out"])  # captures as they were
    assert labrig.open_run(tmp_path / "run").sizes["capture"] == 12
    assert labrig.open_run(tmp_path / "run").attrs["warnings"] == []
    with pytest.raises(LabrigError, match=r"^resume: name the folder of the run to go on with"):
        labrig.run("capture", lab / "rig.yaml", resume=True, captures=12)


def test_a_faulty_progress_is_said_and_left(lab: Path, tmp_path: Path) -> None:
    """A mistake in `progress` is warned of once, and costs no capture."""
    with pytest.warns(
        RuntimeWarning, match="progress: ZeroDivisionError: .*; it is not called again"
    ) as caught:
        labrig.run("capture", lab / "rig.yaml", out=tmp_path / "run", captures=4, progress=lambda _: 1 / 0)
    assert len(caught) == 1
    assert labrig.open_run(tmp_path / "run").sizes["capture"] == 4


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


TARGET = "a surface's file (OBJ, PLY, STL, XYZ), or a list of them"
SHAPE = "a model is needed, and a int was given: its file, such as forward.pt or model.yaml"
PROCEDURE = "its name, such as capture, a file, or one that is made already"


@pytest.mark.parametrize(
    ("name", "arguments", "said"),
    [
        ("open_run", (7,), "a run is needed, and a int was given: a run folder's path, or an .mcap file's"),
        ("load_rig", (None,), "a rig is needed, and a NoneType was given: a rig.yaml's path"),
        ("runs", (7,), "a folder of runs is needed, and a int was given: its path, such as runs"),
        ("propose_experiment", (7, "model.yaml"), RUN.format("int")),
        ("improve", ([3], "model.yaml", "creep"), RUN.format("int")),
        ("run", (7, "RIG"), f"a procedure is needed, and a int was given: {PROCEDURE}"),
        ("solve_ik", (7, "forward.pt"), f"a target is needed, and a int was given: {TARGET}"),
        ("solve_ik", ([], "forward.pt"), f"a target: none was given; {TARGET}"),
        ("solve_ik", ("body.ply", 7), f"{SHAPE}, or the model"),
        (
            "train_forward",
            (7,),
            "a folder of simulations is needed, and a int was given: the path of a folder that labrig simulate made",
        ),
        (
            "train_sim2real",
            ("run", 7),
            "a forward model is needed, and a int was given: its file, or the model",
        ),
        ("validate", ("MODEL", "rig.yaml", 7), f"{SHAPE}, or the model"),
        ("validate", (7, "rig.yaml", "m.pt"), f"a target is needed, and a int was given: {TARGET}"),
        (
            "import_table",
            (7, "out"),
            "a mapping is needed, and a int was given: the path of a MAP.yaml or of a table, or a DataFrame",
        ),
        (
            "import_table",
            ("map.yaml", 7),
            "an output is needed, and a int was given: the path of the run folder to make",
        ),
        ("import_table", ("map.yaml", ""), "an output is needed: the path of the run folder to make"),
        (
            "import_table",
            ("map.yaml", "out", [7]),
            "a table is needed, and a int was given: its file (CSV, Parquet, C3D, ...), or a DataFrame",
        ),
    ],
)
def test_what_is_no_path_is_said_so(lab: Path, name: str, arguments: tuple[Any, ...], said: str) -> None:
    """Every function says in one line what it wants in place of a number or of nothing."""
    there = {"RIG": lab / "rig.yaml", "MODEL": lab / "model.yaml"}
    given = [there.get(one, one) if isinstance(one, str) else one for one in arguments]
    with pytest.raises(LabrigError) as caught:
        getattr(labrig, name)(*given)
    assert str(caught.value) == said


@pytest.mark.parametrize(
    ("setting", "said"),
    [
        ({"share": float("nan")}, "share nan: a number between 0 and 1, such as 0.7"),
        ({"share": "half"}, "share 'half': a number between 0 and 1, such as 0.7"),
        ({"seed": -1}, "seed -1: a whole number, 0 or more"),
        ({"seed": "a"}, "seed 'a': a whole number, 0 or more"),
    ],
)
def test_what_is_no_share_or_seed_is_said_so(setting: dict[str, Any], said: str) -> None:
    """Training says what a share and a seed are, before it reads anything."""
    with pytest.raises(LabrigError) as caught:
        labrig.train_forward("sims", **setting)
    assert str(caught.value) == said


def test_what_makes_a_model_is_said(diagnosis: labrig.Diagnosis) -> None:
    """`labrig.Model("model.yaml")` and `found.save()` say in one line what is meant, as anything wrong does."""
    with pytest.raises(LabrigError, match=r'labrig\.Model\.load\("model\.yaml"\) reads a model'):
        labrig.Model("model.yaml")  # type: ignore[arg-type]
    with pytest.raises(LabrigError, match=r'name the folder to write into, such as save\("diagnosis"\)'):
        diagnosis.save()
