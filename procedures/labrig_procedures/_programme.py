"""A list of set-points, one after the other: what `labrig next` writes, or what a person types."""

import numpy as np
from pydantic import BaseModel, ConfigDict, Field

from labrig.campaign import Actuate, Note, Procedure, Record, RigInfo, Settle, Steps


class Point(BaseModel):
    """One set-point of a programme."""

    model_config = ConfigDict(extra="forbid", frozen=True, coerce_numbers_to_str=True)

    pressure_kpa: dict[str, float] = Field(
        default_factory=dict, description="pressures by chamber, kPa; chambers left out are vented"
    )
    hold_s: float = Field(4.0, gt=0.0, description="how long it is held once it is reached, s")
    settle_s: float = Field(1.0, ge=0.0, description="part of the hold before the recording, s")
    record: bool = Field(True, description="false: only held")
    repeat: str = Field("", description="points with the same text are repeats of one set-point")
    label: str = Field("", description="what the point is for")
    note: str = Field("", description="a line for the log before it")
    by_hand: bool = Field(False, description="needs a person first, who does what the note says")


class Programme(Procedure):
    """Set-points in the order of a file, each held and recorded: what `labrig next` writes.

    The whole hold is one capture. Points that need a person are left out unless somebody is there (`by_hand`).
    """

    points: tuple[Point, ...] = Field(
        (Point.model_validate({"label": "rest"}),), description="the set-points, in order", min_length=1
    )
    rounds: int = Field(1, ge=1, description="how often the whole list is done")
    by_hand: bool = Field(False, description="somebody is there: do the points that need a person too")
    person_s: float = Field(60.0, gt=0.0, description="time for the person, vented, before such a point, s")

    def set_points(self, rig: RigInfo) -> float:
        """As many as the parameters say."""
        return float(self.rounds) * len(self.points)

    def steps(self, rig: RigInfo) -> Steps:
        """Note, actuate, settle, record."""
        for _ in range(self.rounds):
            for point in self.points:
                if not point.by_hand or self.by_hand:
                    yield from self._point(point, rig)

    def _point(self, point: Point, rig: RigInfo) -> Steps:
        if point.note:
            yield Note(point.note)
        if point.note and point.by_hand:
            yield Actuate(np.zeros(len(rig.channels)), label="time for a person")
            yield Settle(self.person_s)
        target = np.zeros(len(rig.channels))
        for chamber, pressure_kpa in point.pressure_kpa.items():
            target[rig.chamber(chamber)] = pressure_kpa
        settle_s = min(point.settle_s, point.hold_s / 2) if point.record else point.hold_s
        yield Actuate(target, label=point.label)
        yield Settle(settle_s)
        if point.record:
            yield Record(point.hold_s - settle_s, repeat=point.repeat, label=point.label, sag=True)
