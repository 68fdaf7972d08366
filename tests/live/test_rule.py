"""When a campaign has said enough."""

from dataclasses import replace
from typing import Any

import pytest

from labrig import LabrigError
from labrig.live import Look, Rule

SETTLED = Rule.parse("settled")
LEFT, SPENT_S = 20, 60.0


def look(captures: int, **probability: float) -> Look:
    """A look in which effects have these probabilities."""
    sure = tuple(name for name, p in probability.items() if p >= 0.75)
    open_ = any(0.1 <= p < 0.75 for p in probability.values())
    verdict = "confounded" if open_ else "identified" if sure else "nothing_missing"
    return Look(captures, captures / 10, verdict, sure, dict(probability), 0.8, 0.3, 0.1, 0.1, "mm")


def stops(rule: Rule, *looks: Look, left: int = LEFT) -> str | None:
    """What the rule says of looks."""
    return rule.stop(looks, left, SPENT_S, looks[-1].captures if looks else 4)


def test_a_settled_verdict_that_stands_while_the_campaign_doubles_ends_it() -> None:
    """Every effect sure or out, the same from half of the captures on, is enough; the reason says what is sure."""
    looks = [look(8, creep=0.5), *(look(n, creep=0.9 + n / 1000, leak=0.01) for n in (12, 16, 20, 24))]
    assert stops(SETTLED, *looks[:-1]) is None
    assert stops(SETTLED, *looks) == (
        "settled: sure of creep 0.92; all other effects are out (each of them 1 % for what was not seen yet)"
    )


def perhaps(captures: int, by_evidence: float, **probability: float) -> Look:
    """A look of which the evidence says so much of the first effect."""
    said = look(captures, **probability)
    return replace(said, by_evidence=dict.fromkeys(list(probability)[:1], by_evidence))


def test_one_name_that_no_evidence_would_make_surer_ends_it() -> None:
    """Where such names are right in six of ten cases, more captures do not change that: what is left is said. It goes
    on where the evidence itself is not sure yet, where another is possible, or where a look does not say how it knows.
    """
    frame = [perhaps(n, 0.99, frame=0.58, leak=0.01) for n in (12, 16, 20, 24)]
    assert stops(SETTLED, *frame[:-1]) is None
    assert stops(SETTLED, *frame) == (
        "settled: perhaps frame (0.58, or an effect that labrig does not know); all other effects are out "
        "(each of them 1 % for what was not seen yet)"
    )
    assert stops(SETTLED, *(perhaps(n, 0.8, frame=0.58) for n in (12, 16, 20, 24)), left=1000) is None
    assert stops(SETTLED, *(perhaps(n, 0.99, frame=0.58, leak=0.2) for n in (12, 24)), left=1000) is None
    assert stops(SETTLED, *(look(n, frame=0.58) for n in (12, 24)), left=1000) is None


def test_a_name_that_is_left_is_not_given_up_before_it_has_stood() -> None:
    """What no longer moves is the answer then: no other set-points are proposed for it."""
    frame = [look(20, frame=0.5), *(perhaps(n, 0.99, frame=0.58) for n in range(24, 44, 4))]
    assert stops(SETTLED, *frame, left=4) is None


def test_at_a_stop_no_effect_is_less_probable_than_what_stopping_misses() -> None:
    """What is stated at a stop is what was found, and for what is out the share that was there all the same."""
    assert SETTLED.at_a_stop(look(24, creep=0.95, leak=0.0)) == {"creep": 0.95, "leak": 0.01}


@pytest.mark.parametrize(
    "looks",
    [
        [look(24, creep=0.95)],
        [look(12, creep=0.95), look(18, creep=0.95), look(24, creep=0.7)],
        [look(12, creep=0.95, leak=0.0), look(24, creep=0.05, leak=0.95)],
        [look(12, creep=0.02), look(18, creep=0.95), look(24, creep=0.95)],
        [Look(n, 1, "underpowered", (), {"creep": 0.0}) for n in (12, 24)],
    ],
    ids=["one look", "still open", "another name", "nothing, then something", "too few to say"],
)
def test_less_than_that_does_not_end_it(looks: list[Look]) -> None:
    """One sure look, an open one, two that differ, or too few numbers are no reason to stop."""
    assert stops(SETTLED, *looks) is None


def test_at_the_end_of_the_plan_there_is_nothing_left_to_decide() -> None:
    """Where the plan has no captures left it ends by itself."""
    assert stops(SETTLED, look(8, creep=0.95), look(16, creep=0.96), left=0) is None


def test_what_is_left_to_learn_may_not_be_worth_the_minutes() -> None:
    """An effect that stays open at a pace which the plan could never make good ends it; a longer plan goes on."""
    stuck = [look(4 * k, creep=0.5 + 0.01 * (k % 2), leak=0.4 + 0.01 * (k % 2)) for k in range(2, 8)]
    why = stops(SETTLED, *stuck, left=10)
    assert why is not None
    assert why.startswith("not worth the minutes: creep and leak may take 141 captures more")
    assert stops(SETTLED, *stuck, left=1000) is None


def test_a_verdict_that_still_moves_is_not_given_up() -> None:
    """As long as the open effects move towards a bound, the campaign goes on."""
    moving = [look(4 * k, creep=p) for k, p in enumerate((0.3, 0.4, 0.5, 0.6, 0.7), 2)]
    assert stops(SETTLED, *moving, left=10) is None


def test_an_error_in_another_unit() -> None:
    """`error=300um` is met by 0.3 mm in two looks; `error=0.2mm` is not."""
    looks = look(8, creep=0.5), look(12, creep=0.5)
    assert stops(Rule.parse("error=300um"), *looks) == "near enough: the held-out error is 0.3 mm"
    assert stops(Rule.parse("error=300 um"), looks[0]) is None
    assert stops(Rule.parse("error=0.2mm"), *looks) is None


def test_a_budget_ends_it_before_it_is_passed() -> None:
    """With 4 captures in 60 s, 70 s are too few for a fifth and 80 s are enough; no look is needed for that."""
    assert stops(Rule.parse(budget="70s")) == "out of time: the next capture would end after 1.17 min"
    assert stops(Rule.parse(budget="80s")) is None
    assert Rule.parse(budget="45").budget_s == Rule.parse(budget="45min").budget_s == 2700.0


@pytest.mark.parametrize(
    ("words", "says"),
    [
        ({"until": "sure"}, "--until sure: write settled, or an error such as error=0.2mm"),
        ({"until": "error=0.2"}, "--until error=0.2: say the unit too, such as error=0.2mm"),
        ({"until": "error=mm"}, "--until error mm: write an amount with its unit, such as error=0.2mm"),
        ({"until": "error=1furlongs2"}, "--until error 1furlongs2: write an amount with its unit"),
        ({"budget": "-3min"}, "--budget -3min: write an amount with its unit, such as 45min"),
        ({"budget": "3kPa"}, "--budget: unit 'kPa' can't be converted to s"),
    ],
)
def test_a_rule_that_cannot_be_read_is_one_line(words: dict[str, Any], says: str) -> None:
    """What is wrong with --until or --budget is said with an example."""
    with pytest.raises(LabrigError) as caught:
        Rule.parse(**words)
    assert str(caught.value).startswith(says)


def test_a_look_keeps_what_it_said() -> None:
    """A look goes through JSON unchanged, and what is left to gain ends at the floor or the ceiling."""
    before = look(8, creep=0.5)
    assert Look.from_dict(before.to_dict()) == before
    assert before.left == pytest.approx(0.2)
