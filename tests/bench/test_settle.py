"""Settling a doubt: what is measured on the same plant afterwards, and the table of what it took."""

from pathlib import Path

import numpy as np
import pytest

from labrig.bench import draw, settle, settle_records, settle_rows, write_settle
from labrig.bench._programmes import Plan


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


def test_a_doubt_is_settled() -> None:
    """On one hold of one force, leak or drift: the proposed programmes name it within the captures allowed."""
    record = settle(draw("confounded", 3), "chosen", 3, most=40)
    assert record["settled"]
    assert record["captures"] <= 40
    assert record["minutes"] > 0


def test_the_table(tmp_path: Path) -> None:
    """What was not settled is never in medians; means are of what all settled; half a campaign is left out."""

    def record(seed: int, strategy: str, captures: int | None) -> dict:
        settled = captures is not None
        minutes = captures / 10 if captures else None
        verdict = "identified" if captures else "confounded"
        return {
            "seed": seed, "strategy": strategy, "settled": settled, "captures": captures, "minutes": minutes,
            "verdict": verdict,
        }  # fmt: skip

    records = [
        *(record(1, s, n) for s, n in (("chosen", 10), ("random", 20), ("even", 30))),
        *(record(2, s, n) for s, n in (("chosen", 20), ("random", None), ("even", 30))),
        *(record(3, s, n) for s, n in (("chosen", 40), ("random", None), ("even", 20))),
        record(4, "chosen", 4),
    ]
    _, rows = settle_rows(records)
    assert rows == [
        ["chosen", "3", "3", "0", "20", "10.0", "2.0", "1.0"],
        ["random", "3", "1", "0", "never", "20.0", "never", "2.0"],
        ["even", "3", "3", "0", "30", "30.0", "3.0", "3.0"],
    ]
    path = tmp_path / "RESULTS.md"
    write_settle(records, path, "how")
    assert "## Next experiment" in path.read_text()
    assert "| random | 3 | 1 |" in path.read_text()
    assert settle_records(tmp_path) == []
