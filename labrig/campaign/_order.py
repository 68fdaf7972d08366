"""Measurements in the order in which they came, each dated later than the one before."""

from dataclasses import replace
from typing import TypeVar

from labrig_drivers import MarkerFrame, PressureSample

_Measured = TypeVar("_Measured", MarkerFrame, PressureSample)

_STEP_S = 1e-6
_BEHIND_S = 1.0
"""What is dated so much earlier than the one before comes from another clock, and keeps its time, which shows that."""


class Order:
    """Dates what one device measures: a recording is known in the log by the first and the last time in it, so no two
    may be the same. A clock that moves in coarse steps, or a late packet, gives the same time twice.
    """

    def __init__(self) -> None:
        self._last_s = float("-inf")

    def of(self, measured: list[_Measured]) -> list[_Measured]:
        """The same, a microsecond after the one before where the time is not later."""
        return [self._next(each) for each in measured]

    def _next(self, measured: _Measured) -> _Measured:
        if 0.0 <= self._last_s - measured.time_s <= _BEHIND_S:
            measured = replace(measured, time_s=self._last_s + _STEP_S)
        self._last_s = measured.time_s
        return measured
