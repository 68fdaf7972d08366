"""Marker slip: from some moment on a marker is not where it was, or is not the one that it was."""

from typing import ClassVar

import numpy as np

from labrig.arrays import Floats
from labrig.bench._nature import Law, Path, Setting
from labrig.bench.exam.tools import Body, unit


def _moment_s(setting: Setting) -> float:
    """A moment by chance in the middle half of the measured rows."""
    time_s = setting.path.time_s[setting.path.row]
    return float(np.quantile(time_s, setting.random.uniform(0.25, 0.75)))


class SwappedLabels(Law):
    """The tracker mixes up two neighbouring markers from a moment on: each is reported as partly the other.

    Y. Bar-Shalom and T. E. Fortmann, Tracking and Data Association, Academic Press, 1988.
    """

    effect: ClassVar[str] = "marker_slip"
    needs: ClassVar[frozenset[str]] = frozenset({"markers"})

    def __init__(self, setting: Setting) -> None:
        super().__init__(setting)
        self._body = body = Body(setting.rig)
        self._first = int(setting.random.integers(len(body.rest)))
        away = np.linalg.norm(body.rest - body.rest[self._first], axis=1)
        away[self._first] = np.inf
        self._second = int(np.argmin(away))
        self._from_s = _moment_s(setting)

    def seen(self, path: Path, deflection: Floats, values: Floats, strength: float) -> Floats:
        """The two markers, each drawn towards the other by the strength."""
        points = self._body.points(values)
        shift = np.zeros_like(points)
        late = strength * (path.time_s >= self._from_s)[:, None]
        shift[:, self._first] = late * (points[:, self._second] - points[:, self._first])
        shift[:, self._second] = -shift[:, self._first]
        return self._body.shifted(values, shift)


class LooseningUnderLoad(Law):
    """A marker whose bond gives way at a moment: from then on it slides with the load, and a little further each time.

    A. J. Kinloch, Adhesion and Adhesives, Chapman and Hall, 1987.
    """

    effect: ClassVar[str] = "marker_slip"
    needs: ClassVar[frozenset[str]] = frozenset({"markers"})

    def __init__(self, setting: Setting) -> None:
        super().__init__(setting)
        random = setting.random
        self._body = body = Body(setting.rig)
        self._which = int(random.integers(len(body.rest)))
        seen = np.zeros(3)
        seen[np.unique(body.axis[body.marker == self._which])] = 1.0
        way = unit(random) * seen
        away = body.moved(setting.rig.settled(setting.path.kpa[setting.path.row]))
        self._way = way / (np.linalg.norm(way) or 1.0) * np.sqrt((away**2).sum(axis=2).mean())
        self._slide, self._further = random.uniform(0.1, 0.3), random.uniform(0.002, 0.008)
        self._power = random.uniform(1.0, 2.0)
        self._from_s = _moment_s(setting)

    def seen(self, path: Path, deflection: Floats, values: Floats, strength: float) -> Floats:
        """The one marker, moved along its way by the load and by the loads since its moment."""
        late = path.time_s >= self._from_s
        load = np.abs(deflection).mean(axis=1) ** self._power
        first = np.diff(path.event, prepend=path.event[0] - 1) != 0
        times = np.cumsum(np.where(late & first, np.concatenate([[0.0], load[:-1]]), 0.0))
        slid = np.where(late, self._slide * load + self._further * times, 0.0)
        shift = np.zeros((len(values), len(self._body.rest), 3))
        shift[:, self._which] = strength * slid[:, None] * self._way
        return self._body.shifted(values, shift)
