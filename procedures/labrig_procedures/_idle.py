"""Nothing happens, for long: drift."""

import numpy as np
from pydantic import Field

from labrig._ranges import rounded, within
from labrig.campaign import Actuate, Procedure, Record, RigInfo, Settle, Steps


class Idle(Procedure):
    """The same two set-points, rest and a middle one, at regular intervals: what changes is drift."""

    duration_min: float = Field(30.0, gt=0.0, description="length of the whole, min")
    every_s: float = Field(60.0, gt=0.0, description="time from one visit to the next, s")
    share: float = Field(
        0.5, ge=0.0, le=1.0, description="the set-point beside rest, as a share of the range"
    )
    settle_s: float = Field(3.0, ge=0.0, description="wait after each actuation, s")
    record_s: float = Field(1.0, gt=0.0, description="length of each recording, s")

    def set_points(self, rig: RigInfo) -> float:
        """As many as the parameters say."""
        return 2.0 * self.duration_min * 60.0 / self.every_s

    def steps(self, rig: RigInfo) -> Steps:
        """A visit of both set-points, then rest until the next one is due."""
        limits = rig.min_kpa, rig.max_kpa
        middle = rounded(*limits, within(*limits, 1.0, highest=self.share))
        visit_s = 2 * (self.settle_s + self.record_s)
        for _ in range(max(1, round(self.duration_min * 60.0 / self.every_s))):
            for setpoint, label in ((middle, "middle"), (np.zeros(len(middle)), "rest")):
                yield Actuate(setpoint)
                yield Settle(self.settle_s)
                yield Record(self.record_s, repeat=label)
            yield Settle(max(0.0, self.every_s - visit_s))
