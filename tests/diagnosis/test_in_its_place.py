"""What may be there in place of a name: whose formula fits as well, within its bounds."""

from labrig.diagnosis._verdict import Considered, Verdict, in_its_place, taken_back


def sure_of(name: str, probability: float) -> Verdict:
    """A verdict that is sure of one of three names."""
    others = [Considered(other, 0.0) for other in ("creep", "drift", "leak") if other != name]
    return Verdict("identified", (name,), probability, considered=(Considered(name, probability), *others))


def chances(verdict: Verdict) -> dict[str, float]:
    """The probability of each effect that has any."""
    return {c.effect: round(c.probability, 6) for c in verdict.considered if c.probability > 0}


def test_what_fits_within_its_bounds_takes_the_place_of_what_does_not() -> None:
    """Others are together as probable as not, and the name keeps the rest: a doubt, in which one other comes first;
    where there is none the verdict is as it was.
    """
    sure = sure_of("drift", 0.96)
    assert in_its_place(sure, ["drift"], []) == sure
    one = in_its_place(sure, ["drift"], ["creep"])
    assert (one.verdict, one.effects, one.rivals) == ("confounded", (), ("creep", "drift"))
    assert chances(one) == {"creep": 0.5, "drift": 0.46}
    assert chances(in_its_place(sure, ["drift"], ["creep", "leak"])) == {
        "drift": 0.46,
        "creep": 0.25,
        "leak": 0.25,
    }


def test_what_was_taken_back_leaves_its_place() -> None:
    """A lag that is turned round is not there; what does the same within its bounds is as probable as not, and no
    words of what carries the error are left.
    """
    back = taken_back(sure_of("drift", 0.96), {"drift": "what is ahead"})
    assert (back.verdict, back.carried_by, back.taken_back) == ("unknown", "what is ahead", ("drift",))
    found = in_its_place(back, back.taken_back, ["creep"])
    assert (found.verdict, found.rivals, found.carried_by) == ("confounded", ("creep",), "")
    assert chances(found) == {"creep": 0.5}
