"""Markers and scans together: what a simulator's warp to the real rig is learned from."""

import numpy as np
from pydantic import Field

from labrig.campaign import Actuate, Record, RigInfo, Scan, Settle, Steps
from labrig_procedures._capture import Capture


class Survey(Capture):
    """Captures as `capture` makes them, some of them scanned as well, after their markers were recorded.

    The scanned set-points are all different, and spread over the session.
    """

    scans: int = Field(
        10, ge=0, description="set-points that are scanned as well; all of them, if they are fewer"
    )
    scan_timeout_s: float = Field(120.0, gt=0.0, description="longest wait for a scan, s")

    def steps(self, rig: RigInfo) -> Steps:
        """Actuate, settle, record, and scan."""
        programme = self.programme(rig)
        scanned = self._scanned([pressure_kpa for pressure_kpa, _ in programme])
        for number, (pressure_kpa, repeat) in enumerate(programme):
            yield Actuate(pressure_kpa)
            yield Settle(self.settle_s)
            yield Record(self.record_s, repeat=repeat)
            if number in scanned:
                yield Scan(self.scan_timeout_s)

    def _scanned(self, points: list[tuple[float, ...]]) -> set[int]:
        """The numbers of the captures that are scanned: first visits, evenly spread."""
        visits: dict[tuple[float, ...], int] = {}
        for number, point in enumerate(points):
            visits.setdefault(point, number)
        first = list(visits.values())
        count = min(self.scans, len(first))
        return (
            {first[k] for k in np.linspace(0, len(first) - 1, count).round().astype(int)} if count else set()
        )
