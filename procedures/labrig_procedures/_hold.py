"""Long holds and what remains after them: creep against drift against leak."""

from typing import Annotated

import numpy as np
from pydantic import Field

from labrig._ranges import rounded, within
from labrig.campaign import Actuate, Procedure, Record, RigInfo, Settle, Steps


class Hold(Procedure):
    """Holds of 3, 10, 60 and 300 s, each followed by a release whose recovery is recorded.

    What creeps goes on moving in the hold and comes back after the release; a leak shows in the measured pressure;
    drift does not care about either. Two pressures tell a leak from creep.
    """

    durations_s: tuple[Annotated[float, Field(gt=0.0, allow_inf_nan=False)], ...] = Field(
        (3.0, 10.0, 60.0, 300.0), min_length=1, description="lengths of the holds, s"
    )
    shares: tuple[Annotated[float, Field(ge=0.0, le=1.0)], ...] = Field(
        (0.4, 0.8), min_length=1, description="pressures, as shares of the range"
    )
    chamber: str = Field("", description="the chamber that is held; all of them if left out")
    recovery_s: float = Field(
        30.0, gt=0.0, description="how long the recovery after each release is recorded, s"
    )
    settle_s: float = Field(1.0, ge=0.0, description="part of each hold that counts as settling, s")

    def set_points(self, rig: RigInfo) -> float:
        """As many as the parameters say."""
        return 2.0 * len(self.durations_s) * len(self.shares)

    def steps(self, rig: RigInfo) -> Steps:
        """Every duration at every pressure; the whole hold is one capture."""
        chosen = slice(None) if not self.chamber else rig.chamber(self.chamber)
        limits = rig.min_kpa, rig.max_kpa
        for duration_s in self.durations_s:
            for share in self.shares:
                setpoint = np.zeros(len(rig.channels))
                setpoint[chosen] = rounded(*limits, within(*limits, 1.0, highest=share))[chosen]
                for target, held_s, label in (
                    (setpoint, duration_s, f"hold {duration_s:g} s"),
                    (np.zeros(len(rig.channels)), self.recovery_s, f"recovery after {duration_s:g} s"),
                ):
                    settle_s = min(self.settle_s, held_s / 2)
                    yield Actuate(target)
                    yield Settle(settle_s)
                    yield Record(held_s - settle_s, label=label, sag=True)
