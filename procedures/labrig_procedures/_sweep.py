"""One chamber up and down, the others held."""

import numpy as np
from pydantic import Field

from labrig._ranges import rounded, within
from labrig.campaign import Actuate, Procedure, Record, RigInfo, Settle, Steps


class Sweep(Procedure):
    """One chamber goes up and down in even steps; going down on the way that it came up shows play and hysteresis."""

    chamber: str = Field("", description="the chamber that is swept; the rig's first if left out")
    levels: int = Field(9, ge=2, description="pressures from the lowest to the highest")
    cycles: int = Field(2, ge=1, description="how often it goes up and down")
    lowest: float = Field(
        0.0, ge=0.0, le=1.0, description="lower end, as a share of the way from vented to the limit"
    )
    highest: float = Field(1.0, ge=0.0, le=1.0, description="upper end, as such a share")
    others: float = Field(
        0.0, ge=0.0, le=1.0, description="where the other chambers are held, as such a share"
    )
    settle_s: float = Field(3.0, ge=0.0, description="wait after each actuation, s")
    record_s: float = Field(1.0, gt=0.0, description="length of each recording, s")

    def set_points(self, rig: RigInfo) -> float:
        """As many as the parameters say."""
        return 2.0 * self.levels * self.cycles

    def steps(self, rig: RigInfo) -> Steps:
        """Up, and down again without stopping twice at the top."""
        chosen = rig.chamber(self.chamber or rig.chamber_names[0])
        others = within(rig.min_kpa, rig.max_kpa, 1.0, highest=self.others)
        up = np.linspace(0.0, 1.0, self.levels)
        for share in np.concatenate(
            [np.concatenate([up, up[-2::-1]])] + [np.r_[up[1:], up[-2::-1]]] * (self.cycles - 1)
        ):
            swept = within(rig.min_kpa, rig.max_kpa, share, self.lowest, self.highest)
            setpoint = others.copy()
            setpoint[chosen] = swept[chosen]
            setpoint = rounded(rig.min_kpa, rig.max_kpa, setpoint)
            yield Actuate(setpoint)
            yield Settle(self.settle_s)
            yield Record(self.record_s, repeat=f"{rig.chamber_names[chosen]}={setpoint[chosen]:g}")
