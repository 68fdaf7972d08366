"""labrig.investigate, as a notebook calls it, on a simulated rig that hides a leak."""

from pathlib import Path
from typing import Any

import pytest
import yaml

import labrig
from labrig import LabrigError
from labrig.investigation import Reporter, _bench
from tests.rigs import RIG


def make_lab(folder: Path, hidden: str = "leak") -> None:
    """rig.yaml with something sealed, and a model that does not know it."""
    from labrig_drivers.simulated import hide, seal

    (folder / "rig.yaml").write_text(yaml.safe_dump(RIG), encoding="utf-8")
    (folder / "model.yaml").write_text(
        "base: {kind: simulator, rig: rig.yaml}\neffects: []\n", encoding="utf-8"
    )
    seal(folder, hide(hidden, seed=1))


@pytest.fixture(scope="module")
def told() -> list[str]:
    """What the investigation said."""
    return []


@pytest.fixture(scope="module")
def found(tmp_path_factory: pytest.TempPathFactory, told: list[str]) -> labrig.Investigation:
    """What came of a run that was there already, and two minutes on the rig, where few effects are asked about."""
    folder = tmp_path_factory.mktemp("lab")
    make_lab(folder)
    labrig.run("capture", folder / "rig.yaml", out=folder / "first", captures=16)
    run, model = labrig.open_run(folder / "first"), labrig.Model.load(folder / "model.yaml")
    whole = model.library()
    with pytest.MonkeyPatch.context() as patch:
        few = {name: whole[name] for name in ("leak", "creep", "delay", "drift", "regulator")}
        patch.setattr(labrig.Model, "library", lambda self: few)
        return labrig.investigate(
            run, model, folder / "rig.yaml", out=folder / "asked", budget_min=2, reporter=told.append
        )


@pytest.mark.slow
def test_it_begins_with_the_runs_that_are_given(found: labrig.Investigation) -> None:
    """The first round is theirs and takes no time on the rig; what follows is measured, within the budget."""
    rounds = found.rounds
    assert rounds["programme"][0] == "given"
    assert rounds["minutes"][0] == 0
    assert rounds["captures"][0] == 16
    assert rounds["run"][0] == str(found.folder.parent / "first")
    assert len(rounds) > 1
    assert 0 < found.minutes <= 2
    assert not (found.folder / "run-1").exists()
    assert labrig.open_run(rounds["run"][1]).sizes["capture"] == rounds["captures"][1]


def test_what_it_found_is_read_as_tables(found: labrig.Investigation) -> None:
    """The hidden leak is named, confirmed on captures recorded after the verdict, and in the new model."""
    assert (found.state, found.verdict) == ("settled", found.rounds["verdict"].iloc[-1])
    assert "leak" in found.sure
    assert set(found.sure) == set(found.effects["effect"][found.effects["call"] == "sure"])
    assert found.error["model"] < found.error["base"]
    assert found.confirmation is not None
    assert found.confirmation["after"] < found.confirmation["before"]
    model = found.model
    assert model is not None
    assert [entry.name for entry in model.file.effects] == found.sure
    fresh = found.rounds["run"].iloc[-1]
    old = found.folder.parent / "model.yaml"
    assert labrig.compare(fresh, model).error["model"] < labrig.compare(fresh, old).error["model"]


def test_what_is_shown_is_short(found: labrig.Investigation) -> None:
    """Two lines in a terminal, and a table of rounds in a notebook, with the same sentence."""
    assert repr(found).startswith(f"Investigation: settled, {found.verdict}. {found.conclusion}\n")
    assert len(repr(found)) < 500
    assert found.conclusion in found._repr_html_()
    assert len(found._repr_html_()) < 10_000


def test_each_round_is_told(found: labrig.Investigation, told: list[str]) -> None:
    """A function such as print hears of every round and of every verdict, in order."""
    rounds = [line for line in told if line.startswith("round ")]
    assert [line.split(":")[0] for line in rounds] == [f"round {n}" for n in found.rounds["round"]]
    assert rounds[0] == "round 1: given"
    after = [line.strip() for line in told if line.startswith("  ")]
    captures = found.rounds["captures"].cumsum()
    assert after[::2] == [f"diagnosing {n} captures" for n in captures]
    assert [line.split(":")[0] for line in after[1::2]] == list(found.rounds["verdict"])


def test_its_pictures_can_be_drawn(found: labrig.Investigation) -> None:
    """Each by its name, with the numbers of the table; a name that is none says which there are."""
    assert found.pictures == ["rounds", "error"]
    lines = found.plot().to_dict()["data"]
    assert list(lines[0]["y"]) == pytest.approx(list(found.rounds["error"]))
    assert list(lines[0]["x"])[-1] == pytest.approx(found.minutes, abs=1e-3)
    assert found.plot("error").to_dict()["data"][0]["x"][0] == "base"
    with pytest.raises(LabrigError, match="no picture 'errors'; there are rounds, error"):
        found.plot("errors")


def test_it_can_be_saved_elsewhere_and_read_again(found: labrig.Investigation, tmp_path: Path) -> None:
    """The reports with links that hold, and the new model, which works there; not the runs, nor over itself."""
    page = found.save(tmp_path / "kept")
    for each in found.summary["rounds"]:
        assert f'href="{each["report"]}"' in page.read_text(encoding="utf-8")
        assert (page.parent / each["report"]).is_file()
    assert not list(page.parent.glob("run-*"))
    again = labrig.Investigation.load(tmp_path / "kept")
    assert (again.state, again.sure) == (found.state, found.sure)
    assert again.model is not None
    fresh = found.rounds["run"].iloc[-1]
    assert labrig.compare(fresh, again.model).error == labrig.compare(fresh, found.model).error
    with pytest.raises(LabrigError, match="this is where the investigation lies"):
        found.save(found.folder)


def test_interrupted_in_python_it_goes_on(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch, few_effects: Any
) -> None:
    """Ctrl-C in the first run: said how to go on; a state that was lost with the power does not matter."""
    monkeypatch.chdir(tmp_path)
    few_effects("leak", "creep", "drift", "regulator")
    make_lab(tmp_path, "nothing")

    class Stopping(Reporter):
        def diagnosed(self, number: int, summary: Any) -> None:
            raise KeyboardInterrupt("enough for today")

    with pytest.raises(KeyboardInterrupt) as caught:
        labrig.investigate(
            None, "model.yaml", "rig.yaml", out="asked", budget_min=4, highest=0.8, reporter=Stopping()
        )
    said = "enough for today; 1 round is in asked; to resume: "
    assert str(caught.value) == said + "labrig.investigate(..., out='asked', resume=True)"
    assert labrig.Investigation.load("asked").state == "interrupted"
    (tmp_path / "asked" / "investigation.json").unlink()

    def never(*_: Any, **__: Any) -> None:
        raise AssertionError("the first run was complete: nothing has to be measured again")

    monkeypatch.setattr(_bench, "run", never)
    monkeypatch.setattr(_bench, "resume", never)
    found = labrig.investigate(None, "model.yaml", "rig.yaml", out="asked", budget_min=4, resume=True)
    assert (found.state, found.verdict, list(found.rounds["run"])) == (
        "settled",
        "nothing_missing",
        [str(Path("asked/run-1"))],
    )
    assert found.model is None


@pytest.mark.slow
def test_no_round_goes_higher_than_it_was_allowed(tmp_path: Path, few_effects: Any) -> None:
    """Two states leave the verdict open: the experiment that settles it and the confirmation keep to the highest."""
    few_effects("hysteresis", "friction")
    make_lab(tmp_path, "hysteresis")
    up = {"pressure_kpa": {"c1": 21, "c2": 18, "c3": 15, "c4": 22}, "hold_s": 4, "repeat": "up"}
    points = [up, {"hold_s": 4, "repeat": "rest"}]
    labrig.run("programme", tmp_path / "rig.yaml", out=tmp_path / "first", rounds=8, points=points)
    made: list[str] = []

    class Stopping(Reporter):
        def round_started(self, number: int, programme: str, minutes: float) -> None:
            made.append(programme)

        def diagnosed(self, number: int, summary: Any) -> None:
            if made[-1] == "confirmation":
                raise KeyboardInterrupt("enough")

    files = (tmp_path / name for name in ("first", "model.yaml", "rig.yaml"))
    with pytest.raises(KeyboardInterrupt, match="enough"):
        labrig.investigate(*files, out=tmp_path / "asked", budget_min=5, highest=0.4, reporter=Stopping())
    assert made == ["given", "experiment", "confirmation"]
    runs = [labrig.open_run(tmp_path / "asked" / f"run-{number}") for number in (2, 3)]
    assert all(0 < float(run["commanded"].max()) <= 24.0 for run in runs)


@pytest.mark.parametrize(
    ("runs", "changes", "said"),
    [
        (None, {"budget_min": 0}, "budget_min 0: must be larger than 0"),
        (None, {"budget_min": float("inf")}, "budget_min inf: the time on the rig has an end, in minutes"),
        (None, {"highest": 2}, "highest 2: a share of the limit is above 0 and at most 1"),
        (7, {}, "a run is needed, and a int was given: a run folder's path, or what labrig.open_run gives"),
        (None, {"rig": 3}, "a rig is needed, and a int was given: a rig.yaml's path, or what labrig.load_rig gives"),
        (None, {"model": []}, "a model is needed, and a list was given: a model.yaml's path, what labrig.Model.load "
         "gives, or a function"),
        (None, {"out": "file"}, "file is a file; name a folder"),
        (None, {"resume": True}, "asked holds no investigation: there is no investigation.json that can be read"),
        (None, {"reporter": 3}, "a reporter is needed, and a int was given: print, or a labrig.investigation.Reporter"),
    ],
)  # fmt: skip
def test_what_is_wrong_is_said_before_anything_moves(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch, runs: Any, changes: dict[str, Any], said: str
) -> None:
    """One line for each wrong value, and no folder is left."""
    monkeypatch.chdir(tmp_path)
    make_lab(tmp_path)
    Path("file").write_text("")
    asked: dict[str, Any] = {"model": "model.yaml", "rig": "rig.yaml", "out": "asked", **changes}
    with pytest.raises(LabrigError) as caught:
        labrig.investigate(runs, **asked)
    assert str(caught.value) == said
    assert not Path("asked").exists()


def test_runs_of_another_rig_are_refused(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    """A rig with other chambers than the run's is named with them."""
    monkeypatch.chdir(tmp_path)
    make_lab(tmp_path)
    labrig.run("capture", "rig.yaml", out="first", captures=4, repeated=0)
    rig = labrig.load_rig("rig.yaml")
    other = rig.model_copy(update={"chambers": rig.chambers[:3]})
    with pytest.raises(LabrigError) as caught:
        labrig.investigate("first", "model.yaml", other, out="asked")
    assert str(caught.value) == "rig bench: its chambers (c1, c2, c3) are not those of first (c1, c2, c3, c4)"
