"""What counts as right, and the figures that are made of it."""

import numpy as np
import pytest

from labrig.bench import brier, calibration_error, is_right, summarise, wilson
from labrig.bench._judge import is_false_alarm, is_near


def _truth(verdict: str, *effects: str) -> dict:
    return {"verdict": verdict, "effects": list(effects), "class": "single-2"}


def _answer(verdict: str, *effects: str, rivals: tuple = ()) -> dict:
    return {"verdict": verdict, "effects": list(effects), "rivals": list(rivals), "probability": 0.9}


@pytest.mark.parametrize(
    ("truth", "answer", "right"),
    [
        (_truth("identified", "creep"), _answer("identified", "creep"), True),
        (_truth("identified", "creep"), _answer("identified", "leak"), False),
        (_truth("identified", "creep"), _answer("multiple", "creep", "leak"), False),
        (_truth("identified", "creep"), _answer("confounded", "creep", rivals=("leak",)), False),
        (_truth("multiple", "creep", "frame"), _answer("multiple", "frame", "creep"), True),
        (_truth("multiple", "creep", "frame"), _answer("identified", "frame"), False),
        (_truth("nothing_missing"), _answer("underpowered"), True),
        (_truth("nothing_missing"), _answer("confounded", "creep", rivals=("leak",)), False),
        (_truth("confounded", "leak"), _answer("confounded", "creep", rivals=("leak",)), True),
        (_truth("confounded", "leak"), _answer("confounded", "creep", rivals=("drift",)), False),
        (_truth("confounded", "leak"), _answer("identified", "leak"), False),
        (_truth("unknown", "kink"), _answer("unknown"), True),
        (_truth("unknown", "kink"), _answer("identified", "coupling"), False),
    ],
)
def test_only_the_whole_truth_is_right(truth: dict, answer: dict, right: bool) -> None:
    """Verdict and names must both be those of the truth; an effect among rivals counts only where it should."""
    assert is_right(truth, answer) is right


def test_a_wrong_law_of_the_base_may_be_named_beside_the_effect() -> None:
    """Only what the base really has wrong may stand beside the hidden effect, and never in its place."""
    truth = {**_truth("identified", "creep"), "also": ["stiffening", "tension"]}
    assert is_right(truth, _answer("identified", "creep"))
    assert is_right(truth, _answer("multiple", "creep", "stiffening"))
    assert not is_right(truth, _answer("multiple", "creep", "leak"))
    assert not is_right(truth, _answer("identified", "stiffening"))


def test_a_false_alarm_is_a_claim_about_nothing() -> None:
    """Any named or unknown cause in a null is an alarm; a wrong name elsewhere is not."""
    assert is_false_alarm(_truth("nothing_missing"), _answer("unknown"))
    assert not is_false_alarm(_truth("nothing_missing"), _answer("nothing_missing"))
    assert not is_false_alarm(_truth("identified", "creep"), _answer("identified", "leak"))


def test_near_means_that_the_truth_is_among_the_names() -> None:
    """Rivals count, in either of the forms in which they may be written."""
    truth = _truth("identified", "creep")
    assert is_near(truth, _answer("confounded", "leak", rivals=("creep",)))
    assert is_near(truth, {**_answer("confounded", "leak"), "rivals": [["creep"], ["drift"]]})
    assert is_near(truth, {**_answer("confounded", "leak"), "rivals": [{"effect": "creep"}]})
    assert not is_near(truth, _answer("identified", "leak"))


def test_calibration_of_a_coin_and_of_a_boaster() -> None:
    """Probabilities that come true have no calibration error; sure and wrong half of the time has one of a half."""
    outcome = [True, False] * 50
    assert calibration_error([0.5] * 100, outcome) == pytest.approx(0.0)
    assert calibration_error([1.0] * 100, outcome) == pytest.approx(0.5)
    assert brier([1.0] * 100, outcome) == pytest.approx(0.5)
    assert brier([0.5] * 100, outcome) == pytest.approx(0.25)


def test_the_interval_of_a_share_covers_it() -> None:
    """Wilson's interval has its textbook value, and stays within zero and one."""
    assert wilson(8, 10) == pytest.approx((0.490, 0.943), abs=1e-3)
    low, high = wilson(0, 20)
    assert low == pytest.approx(0.0, abs=1e-12)
    assert 0.0 < high < 0.2


def test_a_summary_counts_by_class() -> None:
    """Shares, verdicts, drops and the confusion matrix add up over the records."""
    random = np.random.default_rng(0)
    records = []
    for k in range(10):
        good = k < 8
        answer = _answer("identified", "creep" if good else "leak")
        records.append(
            {
                "key": f"single-2:{k}",
                "truth": _truth("identified", "creep"),
                "answer": answer,
                "right": good,
                "near": good,
                "false_alarm": False,
                "seconds": 1.0,
                "drop": float(random.uniform(0.9, 1.0)),
                "fresh": {"drop": 0.95},
                "baselines": {"bic": {"answer": answer, "right": False, "false_alarm": False}},
            }
        )
    rivals = {"verdict": "confounded", "effects": ["creep"], "rivals": ["drift"], "probability": 0.95}
    open_one = {
        "truth": _truth("confounded", "creep"),
        "answer": rivals,
        "right": True,
        "fresh": {"drop": 0.1},
    }
    summary = summarise([*records, {**records[0], **open_one, "key": "confounded:0"}])
    assert summary["fresh_drop"] == {
        "campaigns": 8,
        "median": 0.95,
        "p10": 0.95,
    }  # what is open adds nothing yet
    summary = summarise(records)
    entry = summary["classes"]["single-2"]
    assert entry["right"] == 0.8
    assert entry["reached"] is False
    assert entry["fresh_drop"] == {"campaigns": 8, "median": 0.95, "p10": 0.95}
    assert entry["baselines"]["bic"]["right"] == 0.0
    assert [w["key"] for w in entry["wrong"]] == ["single-2:8", "single-2:9"]
    assert summary["confusion"] == {"creep": {"creep": 8, "leak": 2}}
    assert summary["calibration"]["ece"] == pytest.approx(0.1)
