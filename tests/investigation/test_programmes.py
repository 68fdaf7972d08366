"""What an investigation measures next."""

from pathlib import Path
from types import SimpleNamespace
from typing import Any

import pytest

from labrig import LabrigError, experiment
from labrig.catalogue import rule_out
from labrig.effects import library
from labrig.investigation import Reporter, Settings, State, _loop
from labrig.investigation import _programmes as programmes
from labrig.investigation._bench import Bench
from labrig.investigation._reporter import names_in
from labrig.investigation._rounds import given_round, measured_round
from labrig.investigation._work import Work
from labrig.log import write_dataset
from labrig.rig import parse_rig
from labrig_procedures import Programme
from tests.conftest import Lab

RIG = {
    "name": "bench",
    "chambers": [{"name": f"c{n}", "max_kpa": 60} for n in range(1, 5)],
    "pressure": {"kind": "simulated"},
    "mocap": {"kind": "simulated"},
    "simulated": {"surface": "membrane"},
}


def work_in(folder: Path, rounds: list[dict[str, Any]], **settings: Any) -> Work:
    """An investigation that has come so far; its rig is simulated, its model is never asked."""
    asked = Settings(rig="rig.yaml", model="model.yaml", out=folder, **settings)
    bench = Bench(parse_rig(RIG, "rig.yaml", folder))
    model: Any = SimpleNamespace(library=library)
    return Work(State(asked, rounds=rounds), bench, model, Reporter())


def said_of(verdict: str) -> dict[str, Any]:
    """What a diagnosis says: leak is sure, or one of two that are possible, or the only one that is."""
    rivals = {"perhaps": ["leak"], "confounded": ["leak", "creep"]}.get(verdict, [])
    word = "confounded" if verdict == "perhaps" else verdict
    return {"verdict": word, "effects": [] if rivals else ["leak"], "rivals": rivals, "probability": 0.7}


@pytest.mark.parametrize(
    ("verdict", "rounds", "drop", "asked"),
    [
        ("confounded", ["capture"], None, "confounded"),
        ("confounded", ["capture", "experiment"], None, "confounded"),
        ("identified", ["capture"], None, "identified"),
        ("identified", ["capture", "experiment"], None, None),
        ("identified", ["capture", "experiment", "confirmation"], 0.5, "unknown"),
        ("identified", ["capture", "confirmation"], 0.5, "unknown"),
        ("identified", ["capture", "confirmation"], 0.9, "identified"),
        ("unknown", ["capture", "experiment"], None, "unknown"),
        ("unknown", ["capture", "experiment", "experiment"], None, None),
        ("perhaps", ["capture"], None, "confounded"),
        ("perhaps", ["capture", "experiment"], None, None),
        ("perhaps", ["capture", "confirmation"], 0.5, "unknown"),
    ],
)
def test_what_the_next_programme_is_asked_to_settle(
    tmp_path: Path,
    monkeypatch: pytest.MonkeyPatch,
    verdict: str,
    rounds: list[str],
    drop: float | None,
    asked: str | None,
) -> None:
    """What is possible, once; where least is known, if nothing has a name or a name did not hold on fresh captures; and
    what is only possible, but the only name that is left, is asked as often as what is sure.
    """
    calls = []
    said = said_of(verdict)

    def propose(*_: Any, summary: dict[str, Any], **__: Any) -> None:
        calls.append(summary["verdict"])
        raise LabrigError("enough")

    monkeypatch.setattr(experiment, "propose_experiment", propose)
    monkeypatch.setattr(State, "opened", lambda _: [])
    work = work_in(tmp_path, [{"programme": p, **said} for p in rounds])
    if drop is not None:
        work.state.confirmation = {"drop": drop, "effects": ["leak"]}
    result: Any = SimpleNamespace(summary=said)
    assert programmes.experiment(work, result, 10.0) is None
    assert calls == ([asked] if asked else [])


@pytest.mark.parametrize(
    ("verdict", "held", "state", "sentence"),
    [
        (
            "identified",
            True,
            "settled",
            "Leak: with it the error falls from 2 to 0.5 mm on captures recorded after ",
        ),
        (
            "perhaps",
            True,
            "open",
            "Perhaps leak (70 %, or an effect that labrig does not know): with it the error falls from 2 to 0.5 mm on ",
        ),
        (
            "identified",
            False,
            "open",
            "Leak is the best name, but on fresh captures the error falls from 2 only ",
        ),
        (
            "perhaps",
            False,
            "open",
            "Leak is the best name, but on fresh captures the error falls from 2 only ",
        ),
    ],
)
def test_what_is_only_possible_is_added_and_said_to_be(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch, verdict: str, held: bool, state: str, sentence: str
) -> None:
    """The model is improved with the only name that is left, and whether that one is there stays open."""
    asked: list[list[str]] = []

    def improve(runs: Any, model: Any, names: list[str], *, force: bool) -> Any:
        asked.append(names)
        improved = SimpleNamespace(save=lambda path: path.write_text("effects: []", encoding="utf-8"))
        return SimpleNamespace(improved=improved, waterfall=[])

    monkeypatch.setattr("labrig.diagnosis.improve", improve)
    monkeypatch.setattr(State, "opened", lambda _: [])
    work = work_in(tmp_path, [])
    work.state.units = "mm"
    work.state.confirmation = {
        "drop": 0.9,
        "effects": ["leak"],
        "before": 2.0,
        "after": 0.5,
        "floor": 0.1,
        "run": "",
    }
    _loop._improved(work, SimpleNamespace(summary=said_of(verdict)), held)  # type: ignore[arg-type]
    assert asked == [["leak"]]
    assert work.state.state == state
    assert work.state.conclusion.startswith(sentence)
    assert ("To be sure: close every leak" in work.state.conclusion) == (verdict == "perhaps")
    assert Path(work.state.model).is_file()


def test_the_first_campaign_fits_the_budget(tmp_path: Path) -> None:
    """More time is more captures, up to sixty; the time that is kept for the fresh programme is not spent."""
    captures = {}
    for budget_min in (10.0, 20.0, 500.0):
        work = work_in(tmp_path, [], budget_min=budget_min)
        reserve_min = work.bench.minutes(programmes.fresh_programme(work))
        first: Any = programmes.first_campaign(work, reserve_min)
        assert work.bench.minutes(first) + reserve_min < budget_min
        captures[budget_min] = first.captures
    assert captures[10.0] < captures[20.0] <= captures[500.0] == programmes.MOST


def test_a_budget_that_is_too_small_names_one_that_does(tmp_path: Path) -> None:
    """The number in the message is enough, and one less is not."""
    work = work_in(tmp_path, [], budget_min=1.0)
    with pytest.raises(LabrigError, match="a budget of 1 min is too little") as caught:
        programmes.first_campaign(work, 0.5)
    least = float(str(caught.value).split("give it ")[1].split()[0])
    programmes.first_campaign(work_in(tmp_path, [], budget_min=least), 0.5)
    with pytest.raises(LabrigError):
        programmes.first_campaign(work_in(tmp_path, [], budget_min=least - 1), 0.5)


def test_an_experiment_keeps_to_the_highest_that_is_allowed(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    """What is proposed is looked for within that share of the way to either limit."""
    asked = []

    def propose(*_: Any, limits: Any, **__: Any) -> None:
        asked.append(limits)
        raise LabrigError("enough")

    monkeypatch.setattr(experiment, "propose_experiment", propose)
    monkeypatch.setattr(State, "opened", lambda _: [])
    work = work_in(tmp_path, [], highest=0.4)
    chambers = [*RIG["chambers"][:3], {"name": "c4", "min_kpa": -30, "max_kpa": 60}]  # type: ignore[index]
    work.bench.config = parse_rig({**RIG, "chambers": chambers}, "rig.yaml", tmp_path)
    programmes.experiment(work, SimpleNamespace(summary=said_of("confounded")), 10.0)  # type: ignore[arg-type]
    assert asked[0].high.tolist() == [24.0] * 4
    assert asked[0].low.tolist() == [0.0, 0.0, 0.0, -12.0]


def test_a_programme_above_the_highest_is_refused_before_anything_moves(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    """Whoever wrote it; what is just as high as is allowed is measured."""
    measured = []

    def measure(*_: Any) -> None:
        measured.append(True)
        raise LabrigError("enough")

    monkeypatch.setattr(Bench, "measure", measure)
    work = work_in(tmp_path, [], highest=0.4)
    high, allowed = (
        Programme.model_validate({"points": [{"pressure_kpa": {"c1": 10, "c2": kpa}}]}) for kpa in (25, 24)
    )
    with pytest.raises(LabrigError) as caught:
        measured_round(work, "experiment", high)
    assert str(caught.value) == (
        "nothing was moved: the programme goes to 25 kPa in c2, and 24 kPa is allowed there (highest 0.4)"
    )
    assert not measured
    with pytest.raises(LabrigError, match="enough"):
        measured_round(work, "experiment", allowed)


@pytest.mark.parametrize(
    ("effects", "rivals", "carried_by", "words"),
    [
        (["leak"], [], None, "leak"),
        (["leak"], ["creep", "drift"], None, "leak, or creep, drift"),
        ([], ["creep"], None, "perhaps creep"),
        ([], [], "history", "history"),
        ([], [], None, "no effect"),
    ],
)
def test_a_round_says_its_names(
    effects: list[str], rivals: list[str], carried_by: str | None, words: str
) -> None:
    """What is sure, what may be beside it or instead, and what carries an error without a name."""
    assert names_in({"effects": effects, "rivals": rivals, "carried_by": carried_by}) == words


def test_what_was_ruled_out_in_a_given_run_is_said(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    """What an investigation measures counts as with the suspect: of a run that was measured without it that is said."""
    for name in ("first", "second"):
        lab = Lab(tmp_path, captures=8)
        write_dataset(lab.dataset(lab.predict(lab.u)), tmp_path / name, run_yaml={})
    rule_out(tmp_path / "second", "contact")
    work = work_in(tmp_path / "out", [], runs=(tmp_path / "first", tmp_path / "second"))
    work.state.folder.mkdir()
    monkeypatch.setattr("labrig.investigation._rounds.diagnosed", lambda work: None)
    given_round(work)
    assert work.state.warnings == [
        f"{(tmp_path / 'second').as_posix()} was measured without contact, and what is measured here counts as with "
        "it: put it back before"
    ]
