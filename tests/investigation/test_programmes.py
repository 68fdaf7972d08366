"""What an investigation measures next."""

from pathlib import Path
from types import SimpleNamespace
from typing import Any

import pytest

from labrig import LabrigError, experiment
from labrig.investigation import Reporter, Settings, State
from labrig.investigation import _programmes as programmes
from labrig.investigation._bench import Bench
from labrig.investigation._work import Work
from labrig.rig import parse_rig

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
    return Work(State(asked, rounds=rounds), bench, SimpleNamespace(), Reporter())  # type: ignore[arg-type]


@pytest.mark.parametrize(
    ("verdict", "rounds", "drop", "asked"),
    [
        ("confounded", ["capture"], None, "confounded"),
        ("identified", ["capture"], None, "identified"),
        ("identified", ["capture", "experiment"], None, None),
        ("identified", ["capture", "experiment", "confirmation"], 0.5, "unknown"),
        ("identified", ["capture", "confirmation"], 0.5, "unknown"),
        ("identified", ["capture", "confirmation"], 0.9, "identified"),
        ("unknown", ["capture", "experiment"], None, "unknown"),
        ("unknown", ["capture", "experiment", "experiment"], None, None),
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
    """What is possible, once; where least is known, if nothing has a name or a name did not hold on fresh captures."""
    calls = []

    def propose(*_: Any, summary: dict[str, Any], **__: Any) -> None:
        calls.append(summary["verdict"])
        raise LabrigError("enough")

    monkeypatch.setattr(experiment, "propose_experiment", propose)
    monkeypatch.setattr(State, "opened", lambda _: [])
    work = work_in(tmp_path, [{"programme": p, "verdict": verdict} for p in rounds])
    if drop is not None:
        work.state.confirmation = {"drop": drop, "effects": ["leak"]}
    result: Any = SimpleNamespace(summary={"verdict": verdict, "effects": ["leak"]})
    assert programmes.experiment(work, result, 10.0) is None
    assert calls == ([asked] if asked else [])


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
