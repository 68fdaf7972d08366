"""From a DataStream frame to labrig's marker arrays: names, axes, units, and why a marker is not there."""

from collections.abc import Mapping, Sequence
from typing import Literal

import numpy as np
from numpy.typing import NDArray

from labrig_drivers._cgstream import CgObject
from labrig_drivers._cgstream_objects import Subject
from labrig_drivers._cgstream_session import CgFrame
from labrig_drivers._protocols import MarkerStatus

Up = Literal["y", "z"]


class MarkerTable:
    """Places a frame's labelled markers in the order of `names`.

    `subject` restricts the search to one subject of the server; without it the first subject that has the
    name counts. `rename` gives the server's name for a marker where it differs. `up` is the axis that
    points up in what is returned; `mm_per_unit` is 1 for a server that speaks mm, as Vicon's do.
    """

    def __init__(
        self,
        names: Sequence[str],
        subject: str | None = None,
        rename: Mapping[str, str] | None = None,
        up: Up = "z",
        mm_per_unit: float = 1.0,
    ) -> None:
        self._wanted = [(rename or {}).get(name, name) for name in names]
        self._subject = subject
        self._up = up
        self._mm_per_unit = mm_per_unit
        self._subjects: Mapping[int, Subject] | None = None
        self._index: dict[tuple[int, int], int] = {}
        self._known = np.zeros(len(names), bool)
        self._keys: bytes | None = None
        self._rows: NDArray[np.intp] = np.zeros(0, np.intp)
        self._places: NDArray[np.intp] = np.zeros(0, np.intp)

    def place(self, frame: CgFrame) -> tuple[NDArray[np.float64], NDArray[np.int8]]:
        """Positions, mm, (M, 3), NaN unless seen, and `MarkerStatus`, (M,).

        A marker that the server sends no data for (its type is not subscribed, or no subject has it) is
        NOT_SUBSCRIBED; one that the server knows and the frame leaves out, or gives no finite position, is
        OCCLUDED.
        """
        position = np.full((len(self._wanted), 3), np.nan)
        status = np.full(len(self._wanted), MarkerStatus.NOT_SUBSCRIBED, np.int8)
        if CgObject.LABELED_RECONS not in frame.types:
            return position, status
        if frame.statics.subjects is not self._subjects:
            self._learn(frame.statics.subjects)
        status[self._known] = MarkerStatus.OCCLUDED
        rows, places = self._match(frame.labeled)
        if len(rows) == 0:
            return position, status
        seen = self.to_mm(frame.labeled["position"][rows], frame.statics.y_up)
        finite = np.isfinite(seen).all(axis=1)
        if not finite.all():
            seen, places = seen[finite], places[finite]
        position[places] = seen
        status[places] = MarkerStatus.SEEN
        return position, status

    def to_mm(self, position: NDArray[np.float64], y_up: bool) -> NDArray[np.float64]:
        """Positions (N, 3) of the server, turned to this table's up axis, mm."""
        position = np.asarray(position, np.float64) * self._mm_per_unit
        if y_up and self._up == "z":
            return position[:, (0, 2, 1)] * (1.0, -1.0, 1.0)
        if not y_up and self._up == "y":
            return position[:, (0, 2, 1)] * (1.0, 1.0, -1.0)
        return position

    def _learn(self, subjects: Mapping[int, Subject]) -> None:
        self._subjects = subjects
        self._keys = None
        self._index = {}
        self._known[:] = False
        for place, wanted in enumerate(self._wanted):
            for subject in subjects.values():
                if self._subject is not None and subject.name != self._subject:
                    continue
                number = next((n for n, name in subject.markers.items() if name == wanted), None)
                if number is not None:
                    self._index[subject.id, number] = place
                    self._known[place] = True
                    break

    def _match(self, labeled: NDArray[np.void]) -> tuple[NDArray[np.intp], NDArray[np.intp]]:
        # The same markers are seen in most frames, so the last answer is kept.
        keys = labeled["subject"].tobytes() + labeled["marker"].tobytes()
        if keys != self._keys:
            pairs = zip(labeled["subject"].tolist(), labeled["marker"].tolist(), strict=True)
            found = {
                self._index[pair]: row for row, pair in enumerate(pairs) if pair in self._index
            }  # a marker that is sent twice: the last one counts
            self._places = np.fromiter(found.keys(), np.intp, len(found))
            self._rows = np.fromiter(found.values(), np.intp, len(found))
            self._keys = keys
        return self._rows, self._places
