"""Settling a doubt: what is measured on the same plant afterwards, and the table of what it took."""

from pathlib import Path
from types import SimpleNamespace
from typing import Any

import numpy as np
import pytest

from labrig import diagnosis, experiment
from labrig.bench import compared_rows, draw, settle, settle_records, settle_rows, write_settle
from labrig.bench._programmes import Plan
from labrig.experiment import propose_experiment


def test_the_plant_goes_on() -> None:
    """What is measured later has its own clock and programme, and is the same for the same seed."""
    drawn = (draw("confounded", seed) for seed in range(20))
    campaign = next(c for c in drawn if c.dataset.sizes["chamber"] == 1)
    assert campaign.later is not None

    def again(seed: int):
        plan = Plan(np.random.default_rng(0), np.array([60.0]))
        for pressure in (20.0, 50.0, 0.0):
            plan.capture(np.array([pressure]), 5.0, 4)
        return campaign.later(plan, seed)

    one, two, other = again(1), again(1), again(2)
    assert one["commanded"].values.ravel().tolist() == [20.0, 50.0, 0.0]
    assert float(one["event_time_s"].values[0]) == pytest.approx(1.0)
    assert np.array_equal(one["observed"].values, two["observed"].values)
    assert not np.array_equal(one["observed"].values, other["observed"].values)


@pytest.mark.parametrize(
    ("right_after", "settled", "captures"), [(9, True, 12), (0, True, 4), (99, False, None)]
)
def test_captures_are_counted_until_the_verdict_is_right(
    monkeypatch: pytest.MonkeyPatch, right_after: int, settled: bool, captures: int | None
) -> None:
    """A few captures at a time are measured and diagnosed, until what is hidden is named, or the minutes are used."""
    campaign = next(
        c for c in (draw("confounded", seed) for seed in range(20)) if c.dataset.sizes["chamber"] == 1
    )
    hidden = campaign.truth["effects"]

    def diagnosed(runs: Any, _: Any) -> Any:
        more = sum(run.sizes["capture"] for run in runs[1:]) if isinstance(runs, list) else -1
        right = more >= right_after
        found = {"verdict": "identified" if right else "confounded", "effects": hidden if right else []}
        return SimpleNamespace(summary={**found, "rivals": [] if right else ["leak", "drift"]})

    monkeypatch.setattr(diagnosis, "diagnose", diagnosed)
    record = settle(campaign, "even", 3, minutes=6.0)
    assert (record["settled"], record["captures"]) == (settled, captures)
    assert record["verdict"] == ("identified" if settled else "confounded")
    assert (record["minutes"] is not None) == settled


def test_what_is_proposed_is_measured(monkeypatch: pytest.MonkeyPatch) -> None:
    """The chosen set-points are those that the diagnosis of the runs so far asks for."""
    campaign = next(
        c for c in (draw("confounded", seed) for seed in range(20)) if c.dataset.sizes["chamber"] == 1
    )
    proposals, measured = [], []

    def proposed(runs: list[Any], model: Any, summary: dict[str, Any], minutes: float) -> Any:
        assert minutes == 5.0
        proposals.append(propose_experiment(runs, model, summary=summary, minutes=2))
        return proposals[-1]

    def diagnosed(runs: Any, _: Any) -> Any:
        measured.extend(runs[-1:] if isinstance(runs, list) else [])
        return SimpleNamespace(summary={"verdict": "confounded", "effects": [], "rivals": ["leak", "drift"]})

    monkeypatch.setattr(diagnosis, "diagnose", diagnosed)
    monkeypatch.setattr(experiment, "propose_experiment", proposed)
    record = settle(campaign, "adapted", 3, minutes=0.4)
    assert (record["settled"], record["rivals"]) == (False, ["leak", "drift"])
    points = [
        p for each in proposals for p in each.limits.actuation(np.array([p.share for p in each.points]).T[0])
    ]
    assert measured[0]["commanded"].values.ravel().tolist() == points[: measured[0].sizes["capture"]]


def test_the_table(tmp_path: Path) -> None:
    """What was not settled is never in medians; means are of what all settled; half a campaign is left out."""

    def record(seed: int, strategy: str, captures: int | None) -> dict:
        settled = captures is not None
        minutes = captures / 10 if captures else None
        verdict = "identified" if captures else "confounded"
        return {
            "seed": seed, "strategy": strategy, "settled": settled, "captures": captures, "minutes": minutes,
            "verdict": verdict, "truth": {"design": "one_hold" if seed == 3 else "one_level"},
        }  # fmt: skip

    records = [
        *(record(1, s, n) for s, n in (("adapted", 5), ("random", 20), ("even", 30))),
        *(record(2, s, n) for s, n in (("adapted", 10), ("random", None), ("even", 30))),
        *(record(3, s, n) for s, n in (("adapted", 20), ("random", None), ("even", 20))),
        record(4, "adapted", 4),
    ]
    _, rows = settle_rows(records)
    assert rows == [
        ["adapted", "3", "3", "2", "3", "3", "0", "10", "5.0", "1.0", "0.5"],
        ["random", "3", "1", "0", "1", "1", "0", "never", "20.0", "never", "2.0"],
        ["even", "3", "3", "0", "1", "3", "0", "30", "30.0", "3.0", "3.0"],
    ]
    head, rows = compared_rows(records, minutes=10)
    assert head[2:] == ["median", "mean", "settled by both", "their geometric mean"]
    assert [row[:2] for row in rows] == [
        ["random", "3"], ["even", "3"], ["random, one level", "2"], ["even, one level", "2"],
        ["random, one length of hold", "1"], ["even, one length of hold", "1"],
    ]  # fmt: skip
    # not settled counts as 10 min: medians 1 of 10, means 3.5 of 22; both settled one campaign, 0.5 min of 2
    assert [cell.split()[0] for cell in rows[0][2:]] == ["0.10", "0.16", "1", "0.25"]
    # 0.5, 1 and 2 min beside 3, 3 and 2
    assert [cell.split()[0] for cell in rows[1][2:]] == ["0.33", "0.44", "3", "0.38"]
    assert rows[4][2] == "0.20 (0.20 to 0.20)"
    path = tmp_path / "RESULTS.md"
    write_settle(records, path, "how")
    assert "| even, one level | 2 |" in path.read_text()
    assert "## Next experiment" in path.read_text()
    assert "| random | 3 | 1 |" in path.read_text()
    assert settle_records(tmp_path) == []
