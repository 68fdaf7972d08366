"""What stopping does to a verdict."""

from pathlib import Path
from types import SimpleNamespace
from typing import Any

import pytest

from labrig.bench import draw, run_stopping, stopped_rows, stopping_plan, stopping_records, write_stopping
from labrig.bench._stopped import ends_at, probabilities, surer_by
from labrig.bench._stopping import acted, first_captures, looks_at, watch

CLASSES = ["single", "single", "null", "null", "pair", "pair"]


def record(*creep: float, hidden: bool = True, acted_floors: float = 2.0) -> dict[str, Any]:
    """A campaign of which the looks gave creep these probabilities, at 12, 24, 36, ... captures."""
    looks = []
    for k, p in enumerate(creep, 1):
        verdict = "identified" if p >= 0.9 else "confounded" if p >= 0.1 else "nothing_missing"
        looks.append(
            {
                "captures": 12 * k, "minutes": 2.0 * k, "verdict": verdict, "rivals": [],
                "effects": ["creep"] if p >= 0.9 else [], "probability": {"creep": p},
                "acted": {"creep": acted_floors} if hidden else {},
            }
        )  # fmt: skip
    effects = ["creep"] if hidden else []
    verdict = "identified" if hidden else "nothing_missing"
    return {"truth": {"effects": effects, "verdict": verdict, "also": []}, "looks": looks}


def test_halves_and_classes_come_in_turn() -> None:
    """Both halves get the same classes and seeds, so that they can be compared."""
    plan = stopping_plan(6, 5, ["development", "exam"])
    assert [half for half, _, _ in plan] == ["development", "exam"] * 3
    assert [name for _, name, _ in plan] == CLASSES
    assert [seed for _, _, seed in plan] == [5, 5, 6, 6, 7, 7]


def test_looks_become_rarer_and_end_with_the_campaign() -> None:
    """The first look is at twelve captures, each next one a third later, the last one at all of them."""
    assert looks_at(30) == [12, 16, 20, 26, 30]
    assert looks_at(12) == [12]


def test_a_campaign_that_grows_knows_nothing_of_what_comes() -> None:
    """Its first captures are those of the whole, without actuations after them; what acts later has not acted."""
    campaign = draw("single", 910_000, captures=30)
    part = first_captures(campaign.dataset, 12)
    assert part.sizes["capture"] == 12
    assert float(part["event_time_s"].max()) <= float(part["time_s"].max())
    hidden = campaign.truth["effects"][0]
    whole = acted(campaign, campaign.dataset.sizes["capture"])[hidden]
    assert whole == pytest.approx(campaign.truth["amplitudes"][hidden], rel=0.5)
    assert acted(campaign, 12)[hidden] >= 0.0


def test_a_campaign_ends_where_the_rule_says() -> None:
    """With a rule that never stops it is the last look, else the first that the rule takes; the end needs no rule."""
    looked = record(0.5, 0.95, 0.96, 0.97)
    assert ends_at(looked, lambda looks, left: False) == 3
    assert ends_at(looked, lambda looks, left: looks[-1].probability["creep"] > 0.9) == 1
    assert ends_at(looked, lambda looks, left: left == 12) == 2


def test_what_is_stated_at_a_stop_is_never_nothing() -> None:
    """Where a campaign ends early no effect is stated below what stopping misses; at its end it is as diagnosed."""
    looked = record(0.0, 0.0)
    assert probabilities(looked, 0, floor=True) == [(0.01, True)]
    assert probabilities(looked, 1, floor=True) == [(0.0, True)]


def test_stopping_that_misses_what_comes_later_is_called_surer() -> None:
    """Campaigns that are stopped before their effect acts have the larger calibration error; others have the same."""
    more, low, high = surer_by([record(0.0, 0.0, 0.95) for _ in range(5)])
    assert low == more == high
    assert more == pytest.approx(0.99 - 0.05)
    assert surer_by([record(0.5, 0.5, 0.95) for _ in range(5)])[0] == 0.0


def test_the_table_counts_what_was_missed(tmp_path: Path) -> None:
    """An effect that is called out at a stop counts as missed, and apart, whether it had acted by then."""
    late = record(0.0, 0.0, 0.95, acted_floors=0.1)
    records = [late, record(0.95, 0.95, 0.95), record(0.0, 0.0, 0.0, hidden=False)]
    whole, settled, one_look = stopped_rows(records)
    assert [row[1] for row in (whole, settled, one_look)] == ["0 of 3", "3 of 3", "3 of 3"]
    assert [row[2] for row in (whole, settled, one_look)] == ["36", "24", "12"]
    assert [row[3] for row in (whole, settled, one_look)] == ["0 %", "33 %", "67 %"]
    assert [row[4].split(" (")[0] for row in (whole, settled, one_look)] == ["3 of 3", "2 of 3", "2 of 3"]
    assert [row[8].split(" (")[0] for row in (whole, settled, one_look)] == ["0 of 1", "1 of 2", "1 of 2"]
    assert [row[9] for row in (whole, settled, one_look)] == ["0", "0", "0"]
    path = tmp_path / "RESULTS.md"
    write_stopping(records, path, "how")
    assert "| until settled | 3 of 3 | 24 |" in path.read_text()


def test_what_is_done_is_not_done_again(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    """Records go to a file one by one; a second call does the campaigns that are missing."""
    todo = stopping_plan(2, 0, ["development"])
    monkeypatch.setattr("labrig.bench._stopping.watch", _quick)
    assert len(list(run_stopping(todo[:1], tmp_path))) == 1
    with (tmp_path / "stopping.jsonl").open("a") as file:
        file.write('{"key": "cut')
    assert [one["key"] for one in stopping_records(tmp_path)] == ["development:single:0"]


def _quick(half: str, name: str, seed: int) -> dict[str, Any]:
    return {"key": f"{half}:{name}:{seed}", **record(0.5)}


def test_a_campaign_is_diagnosed_as_it_grows(monkeypatch: pytest.MonkeyPatch) -> None:
    """Each look is at the first captures only, the last one at all of them, and the truth is beside them."""
    seen: list[int] = []

    def diagnosed(run: Any, model: Any, without: list[str]) -> Any:
        seen.append(run.sizes["capture"])
        summary = {"verdict": "unknown", "effects": [], "rivals": [], "units": "mm", "error": {}}
        return SimpleNamespace(summary=summary)

    monkeypatch.setattr("labrig.diagnosis.diagnose", diagnosed)
    found = watch("development", "single", 910_000, captures=16)
    assert [look["captures"] for look in found["looks"]] == seen
    assert seen == looks_at(found["truth"]["captures"])
    assert set(found["looks"][0]["acted"]) == set(found["truth"]["effects"])
