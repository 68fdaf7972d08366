"""The noise floor: the same set-points again and again, reached from above and from below."""

import numpy as np
from pydantic import Field

from labrig.campaign import Actuate, Procedure, Record, RigInfo, Settle, Steps


class Repeatability(Procedure):
    """Set-points reached from above and from below, interleaved over the session.

    Visits with the same approach differ by noise alone; approaches differ by what remembers (hysteresis); early and
    late visits differ by what drifts. Each set-point has one repeat label for all of its visits.
    """

    points: int = Field(4, ge=1, description="different set-points")
    visits: int = Field(5, ge=1, description="visits of each set-point from each side")
    reach: float = Field(
        0.25, gt=0.0, le=0.5, description="how far above and below it begins, as a share of the range"
    )
    settle_s: float = Field(3.0, ge=0.0, description="wait after each actuation, s")
    record_s: float = Field(1.0, gt=0.0, description="length of each recording, s")

    def set_points(self, rig: RigInfo) -> float:
        """As many as the parameters say."""
        return 4.0 * self.points * self.visits

    def steps(self, rig: RigInfo) -> Steps:
        """In every round each set-point from both sides, in an order that is drawn anew."""
        rng = rig.rng()
        span = rig.max_kpa - rig.min_kpa
        share = rng.uniform(self.reach, 1.0 - self.reach, (self.points, len(rig.channels)))
        points = np.round(rig.min_kpa + share * span, 3)
        for _ in range(self.visits):
            for choice in rng.permutation(2 * self.points):
                point, side = points[choice // 2], 1.0 if choice % 2 else -1.0
                yield Actuate(np.clip(point + side * self.reach * span, rig.min_kpa, rig.max_kpa))
                yield Settle(self.settle_s)
                yield Actuate(point)
                yield Settle(self.settle_s)
                yield Record(
                    self.record_s, repeat=f"p{choice // 2 + 1}", label="above" if side > 0 else "below"
                )
