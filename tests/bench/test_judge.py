"""What counts as right, and the figures that are made of it."""

from typing import Any

import numpy as np
import pytest

from labrig.bench import brier, calibration_error, is_right, lines, newcombe, summarise, wilson, wrong_lines
from labrig.bench._goals import alike, status
from labrig.bench._intervals import bootstrap, share
from labrig.bench._judge import called, is_false_alarm, is_near, wrongly_sure
from labrig.bench._report import sections


def _truth(verdict: str, *effects: str, of: str = "single", half: str = "development") -> dict[str, Any]:
    return {
        "verdict": verdict,
        "effects": list(effects),
        "laws": [f"{e.title()}Law" for e in effects],
        "class": of,
        "half": half,
        "seed": 0,
        "rig": "pads",
        "base_kind": "exact",
        "also": [],
    }


def _answer(verdict: str, *effects: str, rivals: tuple = (), **probabilities: float) -> dict[str, Any]:
    answer = {"verdict": verdict, "effects": list(effects), "rivals": list(rivals), "probability": 0.9}
    if probabilities:
        considered = [{"effect": e, "probability": p, "size": 1.0} for e, p in probabilities.items()]
        answer["effects_considered"] = considered
    return answer


def _record(truth: dict[str, Any], answer: dict[str, Any], seed: int = 0, **more: Any) -> dict[str, Any]:
    return {
        "key": f"{truth['half']}:{truth['class']}:{seed}",
        "truth": {**truth, "seed": seed},
        "answer": answer,
        "right": is_right(truth, answer),
        "near": is_near(truth, answer),
        "false_alarm": is_false_alarm(truth, answer),
        "wrongly_sure": sorted(wrongly_sure(truth, answer)),
        "seconds": 1.0,
        **more,
    }


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
        (_truth("unknown", "fatigue"), _answer("unknown"), True),
        (_truth("unknown", "fatigue"), _answer("identified", "coupling"), False),
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
    assert wrongly_sure(truth, _answer("multiple", "creep", "stiffening", "leak")) == {"leak"}


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


def test_a_wrong_effect_is_sure_by_its_verdict_or_by_its_probability() -> None:
    """What is only possible is not called sure, whatever the verdict, and what is hidden is not wrong."""
    truth = _truth("identified", "creep")
    assert wrongly_sure(truth, _answer("identified", "leak")) == {"leak"}
    assert wrongly_sure(truth, _answer("confounded", "leak", rivals=("drift",))) == set()
    assert wrongly_sure(truth, _answer("confounded", "leak", leak=0.6, drift=0.91)) == {"drift"}
    assert wrongly_sure(truth, _answer("identified", "creep", creep=0.99, leak=0.74)) == set()
    assert called(_answer("unknown"), 0.9) is None


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
    assert share(0, 0) is None


def test_the_interval_of_a_difference_is_newcombes() -> None:
    """Method 10 gives the values of Newcombe's own table (1998, table II)."""
    assert newcombe(56, 70, 48, 80) == pytest.approx((0.0524, 0.3339), abs=1e-4)
    assert newcombe(10, 10, 0, 10) == pytest.approx((0.6075, 1.0), abs=1e-4)


def test_resampling_gives_the_interval_of_a_mean() -> None:
    """The bootstrap interval of a mean is about two standard errors to each side, and the same each time."""
    values = list(np.random.default_rng(0).normal(5.0, 1.0, 400))
    low, high = bootstrap(values, lambda of: float(np.mean(of)))
    assert (low, high) == bootstrap(values, lambda of: float(np.mean(of)))
    assert high - low == pytest.approx(4 * 0.05, rel=0.15)


def test_a_goal_is_met_only_by_the_bad_end_of_its_interval() -> None:
    """Where only the figure itself keeps the bound the goal is open, and where that does not, missed."""
    good, fair, bad = (share(k, 200) for k in (198, 184, 170))
    assert [status(">=", 0.9, f) for f in (good, fair, bad) if f] == ["met", "open", "missed"]
    few, some, many = (share(k, 200) for k in (0, 3, 30))
    assert [status("<=", 0.04, f) for f in (few, some, many) if f] == ["met", "open", "missed"]
    assert status(">=", 0.85, {"value": 0.9, "low": 0.88, "high": 1.0, "few": True}) == "open"
    assert alike({"value": 0.02, "low": -0.01, "high": 0.05}) == "met"
    assert alike({"value": -0.02, "low": -0.08, "high": 0.03}) == "open"
    assert alike({"value": -0.06, "low": -0.08, "high": 0.03}) == "missed"


def _mixed() -> list[dict[str, Any]]:
    """Ten singles (two wrong), two pairs (one half right), two nulls (one alarm), two outside (one recalled)."""
    out = []
    for k in range(10):
        good = k < 8
        answer = _answer("identified", "creep" if good else "leak", creep=0.95 if good else 0.2, leak=0.05)
        fresh = {"fresh": {"drop": 0.9 + 0.01 * k}, "drop": 0.97} if good else {"drop": 0.5}
        bic = {"baselines": {"bic": {"answer": answer, "right": False, "false_alarm": False}}}
        out.append(_record(_truth("identified", "creep"), answer, k, **fresh, **bic))
    pair = _truth("multiple", "creep", "frame", of="pair")
    out.append(_record(pair, _answer("multiple", "creep", "frame", creep=0.99, frame=0.99), 0))
    out.append(_record(pair, _answer("identified", "creep", creep=0.99, frame=0.3), 1))
    null = _truth("nothing_missing", of="null")
    out.append(_record(null, _answer("nothing_missing", creep=0.01), 0))
    out.append(_record(null, _answer("identified", "creep", creep=0.92), 1))
    outside = _truth("unknown", "fatigue", of="outside")
    out.append(_record(outside, _answer("unknown", creep=0.1), 0))
    out.append(_record(outside, _answer("confounded", "drift", rivals=("creep",), drift=0.5), 1))
    return out


def test_figures_add_up() -> None:
    """Shares of verdicts, of true effects and of wrong names count what they say they count."""
    own = summarise(_mixed())["halves"]["development"]
    totals = own["totals"]

    def count(figure: dict[str, Any]) -> tuple[int, int]:
        assert figure["low"] <= figure["value"] <= figure["high"]
        return figure["count"], figure["of"]

    assert count(own["classes"]["single"]["right"]) == (8, 10)
    assert count(own["classes"]["null"]["false_alarms"]) == (1, 2)
    assert own["classes"]["single"]["false_alarms"] is None
    assert own["classes"]["single"]["baselines"]["bic"]["right"] == 0.0
    assert own["classes"]["single"]["fresh_drop"]["campaigns"] == 8
    assert [w["key"] for w in own["classes"]["single"]["wrong"]] == [
        "development:single:8",
        "development:single:9",
    ]
    assert count(totals["right"]) == (11, 16)
    assert count(totals["true_sure"]) == (11, 14)
    assert count(totals["true_possible"]) == (14, 14)
    assert count(totals["wrong_sure"]) == (3, 16)
    assert count(totals["unknown_recall"]) == (1, 2)
    assert totals["verdict_ece"]["value"] == pytest.approx(0.9 - 11 / 16)
    assert totals["fresh_drop_p10"]["value"] == pytest.approx(np.percentile(0.9 + 0.01 * np.arange(8), 10))
    assert totals["fresh_drop_p10"]["few"]
    trials = [(0.95, 1)] * 8 + [(0.2, 1)] * 2 + [(0.05, 0)] * 10
    trials += [(0.99, 1)] * 3 + [(0.3, 1), (0.01, 0), (0.92, 0), (0.1, 0), (0.5, 0)]
    p, true = np.array(trials).T
    assert totals["effect_brier"]["value"] == pytest.approx(np.mean((p - true) ** 2))
    assert own["confusion"]["creep"] == {"creep": 8, "leak": 2}


def test_tables_by_part_count_effects_and_campaigns() -> None:
    """By law each hidden effect is judged for itself; by rig and base campaigns are counted."""
    own = summarise(_mixed())["halves"]["development"]
    laws = {tuple(part["name"]): part for part in own["laws"]}
    assert list(laws) == [("creep", "CreepLaw"), ("frame", "FrameLaw"), ("outside", "FatigueLaw")]
    assert (laws["frame", "FrameLaw"]["true_sure"]["count"], laws["frame", "FrameLaw"]["right"]["of"]) == (
        1,
        2,
    )
    assert laws["creep", "CreepLaw"]["true_sure"]["of"] == 12
    assert [(p["name"], p["right"]["of"]) for p in own["rigs"]] == [(["pads"], 16)]
    assert [(p["name"], p["right"]["count"]) for p in own["bases"]] == [(["exact"], 11)]
    goals = {goal["what"]: goal["status"] for goal in own["goals"]}
    assert goals["single: right"] == goals["null: false alarms"] == "missed"
    assert goals["true effects called sure or possible"] == "open"


def test_answers_without_probabilities_have_no_figures_of_them() -> None:
    """Nothing is made up of effects whose probability an answer does not give."""
    totals = summarise([_record(_truth("identified", "creep"), _answer("identified", "creep"))])["halves"][
        "development"
    ]["totals"]
    assert totals["true_sure"] is None
    assert totals["effect_ece"] is None
    assert totals["wrong_sure"]["count"] == 0


def test_the_exam_keeps_to_totals() -> None:
    """Of the exam nothing is said by law, rig, base or campaign, unless it is to be revealed."""
    exam = [{**r, "truth": {**r["truth"], "half": "exam"}} for r in _mixed()]
    hidden = summarise(exam)
    assert {"laws", "rigs", "bases", "confusion"}.isdisjoint(hidden["halves"]["exam"])
    assert not any("wrong" in entry for entry in hidden["halves"]["exam"]["classes"].values())
    assert wrong_lines(hidden) == []
    titles = [title for title, _, _ in sections(hidden)]
    assert titles == [
        "exam: 16 campaigns",
        "exam: goals",
        "exam: by hidden effect, where it can be named",
        "exam: the same with other methods",
    ]
    assert len(wrong_lines(summarise(exam, reveal=True))) == 5


def test_the_halves_stand_side_by_side() -> None:
    """The difference of right verdicts has Newcombe's interval, over classes that both halves have."""
    exam = [
        _record({**_truth("identified", "creep"), "half": "exam"}, _answer("identified", "creep"), k)
        for k in range(5)
    ]
    summary = summarise([*_mixed(), *exam])
    difference = {entry["what"]: entry for entry in summary["difference"]}
    assert list(difference) == ["all", "single"]
    assert difference["all"]["development"]["of"] == 10
    assert difference["all"]["difference"]["value"] == pytest.approx(0.8 - 1.0)
    low, high = newcombe(8, 10, 5, 5)
    assert difference["single"]["difference"] == {"value": pytest.approx(-0.2), "low": low, "high": high}
    assert difference["all"]["status"] == "missed"
    title, _, rows = sections(summary)[-1]
    assert title == "right verdicts: development minus exam"
    assert rows[1][5] == "-20.0"
    assert any(line.startswith("exam: probability of verdicts: ECE 0.100") for line in lines(summary))
