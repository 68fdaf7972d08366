"""How probable a name is: what evidence says, how large its share is, and what names of its kind were worth."""

import pytest
from hypothesis import given
from hypothesis import strategies as st

from labrig.diagnosis import Calibration, calibration, log_odds
from labrig.diagnosis import _constants as k
from labrig.effects import library

PLAIN = Calibration(-0.5, 0.3, 1.5, {"creep": 1.0, "frame": -1.0})
SHARES, CHANCES = st.floats(0, 1), st.floats(k.NEGLIGIBLE, 1)


@given(CHANCES, CHANCES, SHARES, SHARES)
def test_more_evidence_and_a_larger_share_make_a_name_more_probable(
    p: float, q: float, share: float, more: float
) -> None:
    """And neither makes it certain."""
    assert (PLAIN.of_name("creep", p, share) - PLAIN.of_name("creep", q, share)) * (p - q) >= 0
    assert (PLAIN.of_name("creep", p, share) - PLAIN.of_name("creep", p, more)) * (share - more) >= 0
    assert 0 < PLAIN.of_name("creep", p, share) < 1


def test_a_small_share_is_worth_less() -> None:
    """Of the same evidence: what would hardly be missed is often the misfit of something else."""
    assert PLAIN.of_name("frame", 0.99, 0.9) > PLAIN.of_name("frame", 0.99, 0.3) + 0.1


def test_names_are_worth_what_they_were_worth() -> None:
    """The same evidence says more of one name than of another; of one that was not counted, what it says on average."""
    creep, own, frame = (PLAIN.of_name(name, 0.99, 0.9) for name in ("creep", "my_own", "frame"))
    assert creep > own > frame
    assert own == pytest.approx(Calibration(-0.5, 0.3, 1.5, {}).of_name("creep", 0.99, 0.9))


def test_a_good_record_counts_as_far_as_there_is_evidence() -> None:
    """A name that was mostly right is no likelier than another where evidence speaks against both; a bad record counts
    always.
    """
    creep, own, frame = (PLAIN.of_name(name, 0.02, 0.9) for name in ("creep", "my_own", "frame"))
    assert own < creep < own + 0.01
    assert frame < own - 0.1


def test_what_is_ruled_out_stays_out() -> None:
    """What evidence makes negligible has no probability, however often such names were there."""
    assert PLAIN.of_name("creep", k.NEGLIGIBLE / 2, 1.0) == 0
    assert PLAIN.stated(k.NEGLIGIBLE / 2) == 0


@given(CHANCES, SHARES, CHANCES, CHANCES)
def test_what_is_gone_where_it_was_ruled_out_is_more_probable(
    p: float, share: float, gone: float, more: float
) -> None:
    """The more so, the more evidence says that it is gone; what says nothing changes nothing; what stays is not it."""
    change = PLAIN.of_name("frame", p, share, gone) - PLAIN.of_name("frame", p, share, more)
    assert change * (gone - more) >= 0
    assert PLAIN.of_name("frame", p, share, 0.5) == PLAIN.of_name("frame", p, share)
    assert PLAIN.of_name("frame", p, share, k.NEGLIGIBLE) < k.POSSIBLE


def test_a_bad_record_is_no_hindrance_to_what_is_gone() -> None:
    """A name that set-points never make sure is sure once what looked like it went with it."""
    assert calibration().of_name("frame", 0.999, 1.0) < k.SURE
    assert calibration().of_name("frame", 0.999, 1.0, 0.999) >= k.SURE
    assert calibration().of_name("frame", 0.999, 1.0, 0.001) < k.POSSIBLE


@given(CHANCES, SHARES)
def test_what_is_likely_is_never_surer_than_evidence_says(p: float, share: float) -> None:
    """However well such names did before: of two that evidence cannot tell apart neither is sure."""
    assert Calibration(0.0, 0.3, 1.5, {"creep": 9.0}).of_name("creep", p, share) <= max(p, 0.5)


@given(st.floats(k.NEGLIGIBLE, 1 - k.NEGLIGIBLE))
def test_what_is_no_name_is_stated_with_less_of_its_odds(p: float) -> None:
    """Nearer to a half than evidence says, the same for and against."""
    assert abs(PLAIN.stated(p) - 0.5) <= abs(p - 0.5)
    assert PLAIN.stated(p) + PLAIN.stated(1 - p) == pytest.approx(1)
    assert log_odds(PLAIN.stated(p)) == pytest.approx(0.3 * log_odds(p), abs=1e-6)


def test_what_is_shipped_counts_every_effect() -> None:
    """Each effect of the library was counted; evidence counts for less than it says, and so does a small share."""
    shipped = calibration()
    assert set(shipped.effects) == set(library())
    assert 0 < shipped.odds < 1
    assert shipped.share > 0
