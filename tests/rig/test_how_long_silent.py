"""How long a device is silent, whatever its clock says."""

from labrig.rig import Silence


def test_a_date_ahead_of_the_clock_hides_no_silence() -> None:
    """A device whose clock runs ahead is missed as soon as any other: what it says counts as said now."""
    silence = Silence(100.0)
    silence.hear(100.9, 100.0)
    assert silence.lasts_s(101.5) == 1.5
