"""How probable a name is: what evidence says, how far its formula is ahead, and what names of its kind were worth."""

import pytest
from hypothesis import given
from hypothesis import strategies as st

from labrig.diagnosis import Calibration, calibration, log_odds
from labrig.diagnosis import _constants as k
from labrig.effects import library

PLAIN = Calibration(0.5, 0.3, 1.0, {"creep": 1.0, "frame": -1.0})
CHANCES, AHEAD = st.floats(k.NEGLIGIBLE, 1), st.floats(-3, 3)


@given(CHANCES, CHANCES, AHEAD, AHEAD)
def test_more_evidence_and_a_better_formula_make_a_name_more_probable(
    p: float, q: float, ahead: float, further: float
) -> None:
    """And none makes it certain."""
    this = PLAIN.of_name("creep", p, ahead)
    assert (this - PLAIN.of_name("creep", q, ahead)) * (p - q) >= 0
    assert (this - PLAIN.of_name("creep", p, further)) * (ahead - further) >= 0
    assert 0 < this < 1


def test_a_formula_that_is_behind_the_others_is_worth_less() -> None:
    """Of the same evidence; but by how far it is behind counts to a limit: what is small beside another effect is."""
    behind, far_behind, ahead = (PLAIN.of_name("frame", 0.99, x) for x in (-1.0, -5.0, 0.5))
    assert ahead > behind + 0.1
    assert far_behind == behind


def test_names_are_worth_what_they_were_worth() -> None:
    """The same evidence says more of one name than of another; of one that was not counted, what it says on average."""
    creep, own, frame = (PLAIN.of_name(name, 0.99, 0.0) for name in ("creep", "my_own", "frame"))
    assert creep > own > frame
    assert own == pytest.approx(Calibration(0.5, 0.3, 1.0, {}).of_name("creep", 0.99, 0.0))


def test_what_is_ruled_out_stays_out() -> None:
    """What evidence makes negligible has no probability, however often such names were there."""
    assert PLAIN.of_name("creep", k.NEGLIGIBLE / 2, 1.0) == 0
    assert PLAIN.stated(k.NEGLIGIBLE / 2) == 0


@given(CHANCES, AHEAD)
def test_what_is_likely_is_never_surer_than_evidence_says(p: float, ahead: float) -> None:
    """However well such names did before: of two that evidence cannot tell apart neither is sure."""
    assert Calibration(0.0, 0.3, 1.0, {"creep": 9.0}).of_name("creep", p, ahead) <= max(p, 0.5)


def test_how_sure_a_name_can_be_beside_another_formula_as_good() -> None:
    """As sure as the strongest evidence makes it where its formula is neither ahead nor behind."""
    most = PLAIN.at_most("frame")
    assert most == PLAIN.of_name("frame", 1.0, 0.0)
    assert PLAIN.of_name("frame", 1.0, 0.5) > most > PLAIN.of_name("frame", 0.9, 0.0)


@given(st.floats(k.NEGLIGIBLE, 1 - k.NEGLIGIBLE))
def test_what_is_no_name_is_stated_with_less_of_its_odds(p: float) -> None:
    """Nearer to a half than evidence says, the same for and against."""
    assert abs(PLAIN.stated(p) - 0.5) <= abs(p - 0.5)
    assert PLAIN.stated(p) + PLAIN.stated(1 - p) == pytest.approx(1)
    assert log_odds(PLAIN.stated(p)) == pytest.approx(0.3 * log_odds(p), abs=1e-6)


def test_what_is_shipped_counts_every_effect() -> None:
    """Each effect of the library was counted; evidence counts for less than it says, a formula that is ahead for it."""
    shipped = calibration()
    assert set(shipped.effects) == set(library())
    assert 0 < shipped.odds < 1
    assert shipped.ahead > 0
