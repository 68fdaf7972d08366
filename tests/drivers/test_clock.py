"""Clocks never run backward, whatever somebody does to the computer's."""

import time

import pytest

from labrig_drivers import RealClock, SimulatedClock


def test_setting_the_computers_clock_moves_nothing(monkeypatch: pytest.MonkeyPatch) -> None:
    """An hour back on the wall: the run's time goes on, and the wall's time says what the wall says."""
    clock = RealClock()
    before_s = clock.now_s()
    real = time.time
    monkeypatch.setattr(time, "time", lambda: real() - 3600.0)
    assert 0.0 <= clock.now_s() - before_s < 60.0
    assert clock.wall_s() < before_s - 3000.0


def test_two_clocks_with_one_offset_agree() -> None:
    """A clock of another process is the same clock when it has the same offset."""
    first = RealClock()
    second = RealClock(first.offset_s)
    early, middle, late = first.now_s(), second.now_s(), first.now_s()
    assert early <= middle <= late


@pytest.mark.parametrize("clock", [RealClock(), SimulatedClock()])
def test_a_clock_goes_on_from_a_later_time_and_never_from_an_earlier(
    clock: RealClock | SimulatedClock,
) -> None:
    """What was logged lies in the past of a run that is resumed."""
    then_s = clock.now_s() + 100.0
    clock.advance_to(then_s)
    assert 0.0 <= clock.now_s() - then_s < 60.0
    now_s = clock.now_s()
    clock.advance_to(then_s - 1000.0)
    assert clock.now_s() >= now_s
