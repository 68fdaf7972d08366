"""The morning's check: the short programme that shows whether a rig is still what it was."""

import numpy as np
from pydantic import Field

from labrig._ranges import rounded, within
from labrig.arrays import Floats
from labrig.campaign import Actuate, Procedure, Record, RigInfo, Settle, Steps

_GOLDEN = 0.6180339887498949


class Check(Procedure):
    """At rest, a few set-points again and again, and one long hold: under five minutes, and the same every day.

    At rest the zero of each pressure sensor and the place of each marker show; in the repeats the noise; in the hold
    leaks and creep. Nothing is drawn by chance, so that two checks differ by the rig alone.
    """

    rests: int = Field(2, ge=1, description="recordings at rest before anything is filled")
    points: int = Field(4, ge=1, description="different set-points")
    visits: int = Field(4, ge=2, description="visits of each set-point, all with the same history")
    highest: float = Field(
        0.7, gt=0.0, le=1.0, description="highest set-point, as a share of the way from vented to the limit"
    )
    hold_share: float = Field(
        0.6, gt=0.0, le=1.0, description="pressure of the hold, as such a share; no more than `highest`"
    )
    hold_s: float = Field(90.0, gt=1.0, description="length of the hold, s")
    recovery_s: float = Field(30.0, gt=1.0, description="how long the recovery after the hold is recorded, s")
    settle_s: float = Field(3.0, ge=0.0, description="wait after each actuation, s")
    record_s: float = Field(1.0, gt=0.0, description="length of each recording, s")

    def set_points(self, rig: RigInfo) -> float:
        """As many as the parameters say."""
        return self.rests + float(self.points) * self.visits

    def steps(self, rig: RigInfo) -> Steps:
        """Rest, the set-points in the same order in every round, the hold, and what remains after it."""
        vented = np.zeros(len(rig.channels))
        for _ in range(self.rests):
            yield Actuate(vented)
            yield Settle(self.settle_s)
            yield Record(self.record_s, repeat="rest", label="rest")
        points = self.setpoints(rig)
        for _ in range(self.visits):
            for number, point in enumerate(points, 1):
                yield Actuate(point)
                yield Settle(self.settle_s)
                yield Record(self.record_s, repeat=f"p{number}")
        share = min(self.hold_share, self.highest)
        limits = rig.min_kpa, rig.max_kpa
        held = rounded(*limits, within(*limits, 1.0, highest=share))
        for target, length_s, label in ((held, self.hold_s, "hold"), (vented, self.recovery_s, "recovery")):
            settle_s = min(self.settle_s, length_s / 2)
            yield Actuate(target)
            yield Settle(settle_s)
            yield Record(length_s - settle_s, label=label, sag=True)

    def setpoints(self, rig: RigInfo) -> Floats:
        """The set-points, kPa, (points, C): each chamber at levels that fill its range, in an order of its own."""
        chamber = np.arange(len(rig.channels))
        number = np.arange(1, self.points + 1)[:, None]
        share = (number / self.points + chamber * _GOLDEN) % 1.0
        limits = rig.min_kpa, rig.max_kpa
        return rounded(*limits, within(*limits, share, highest=self.highest))
