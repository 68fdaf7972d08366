"""Chambers one at a time against two at a time: coupling."""

import itertools
from typing import Literal

import numpy as np
from pydantic import Field

from labrig._ranges import rounded, within
from labrig.campaign import Actuate, Procedure, Record, RigInfo, Settle, Steps


class Pairs(Procedure):
    """Each chamber alone, then chambers in pairs: what a pair does beyond the sum of its two is coupling."""

    which: Literal["neighbours", "all"] = Field(
        "all", description="neighbours in the rig's order, or every pair"
    )
    share: float = Field(0.7, gt=0.0, le=1.0, description="pressure, as a share of each chamber's range")
    rounds: int = Field(1, ge=1, description="how often everything is done")
    settle_s: float = Field(3.0, ge=0.0, description="wait after each actuation, s")
    record_s: float = Field(1.0, gt=0.0, description="length of each recording, s")

    def set_points(self, rig: RigInfo) -> float:
        """As many as the parameters say."""
        return 2.0 * self.rounds * len(rig.channels)

    def steps(self, rig: RigInfo) -> Steps:
        """In an order that is drawn anew in each round, from rest each time, so that history is the same."""
        names = rig.chamber_names
        pairs = itertools.pairwise(names) if self.which == "neighbours" else itertools.combinations(names, 2)
        groups = [(), *[(name,) for name in names], *pairs]
        rng = rig.rng()
        limits = rig.min_kpa, rig.max_kpa
        high = rounded(*limits, within(*limits, 1.0, highest=self.share))
        for _ in range(self.rounds):
            for index in rng.permutation(len(groups)):
                group = groups[index]
                yield Actuate(np.zeros(len(names)))
                yield Settle(self.settle_s)
                yield Actuate([high[i] if name in group else 0.0 for i, name in enumerate(names)])
                yield Settle(self.settle_s)
                yield Record(self.record_s, repeat="+".join(group) or "rest")
