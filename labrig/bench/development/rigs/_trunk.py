"""A hydraulic trunk of two segments, each bent by three bellows, with markers along its skin."""

import numpy as np

from labrig.arrays import Floats
from labrig.bench._nature import Rig
from labrig.bench.development.rigs._common import chambers, markers

_PIECES = 20


class Trunk(Rig):
    """Two segments of a curvature that grows towards the thinner end, not constant along them.

    I. D. Walker, Continuous backbone "continuum" robot manipulators, ISRN Robotics, 2013. The lines of the far bellows
    run through the near segment and bend it back a little; all bellows of a segment together make it longer, and
    stiffer against each of them.
    """

    kind = "trunk"

    def __init__(self, random: np.random.Generator) -> None:
        self.chambers = chambers(6)
        self.high_kpa = random.uniform(150, 400) * random.uniform(0.93, 1.07, 6)
        count = int(random.integers(14, 23))
        self.marker_names, self.observables = markers(count)
        self.noise = float(random.uniform(0.12, 0.25))
        self._length_mm = random.uniform(150, 260) / (2 * _PIECES)
        around = np.tile(np.arange(3) * 2 * np.pi / 3, 2) + np.repeat(random.uniform(0, 2 * np.pi, 2), 3)
        bend_rad = np.deg2rad(random.uniform(35, 65, 6)) / _PIECES
        self._bend = bend_rad[:, None] * np.stack([np.cos(around), np.sin(around)], axis=1)
        self._back = random.uniform(0.1, 0.3)
        self._firm = random.uniform(0.15, 0.45)
        self._longer = random.uniform(0.01, 0.05, 2)
        self._thinner = 1 + random.uniform(0.1, 0.6) * np.linspace(-1, 1, 2 * _PIECES)
        self._late = random.uniform(0.2, 1.0, 6)
        self._at = np.sort(random.choice(np.arange(2, 2 * _PIECES + 1), count, replace=False))
        side = np.arange(count) * np.deg2rad(137) + random.uniform(0, 2 * np.pi)
        radius_mm = random.uniform(14, 22) * np.linspace(1.0, 0.7, count)
        self._skin_mm = radius_mm[:, None] * np.stack([np.cos(side), np.sin(side), 0 * side], axis=1)
        self.rest_mm = self.shape(np.zeros((1, 6))).reshape(count, 3)

    def deflection(self, kpa: Floats) -> Floats:
        load = kpa / self.high_kpa
        return (1 + self._late) * load / (1 + self._late * np.abs(load))

    def shape(self, deflection: Floats) -> Floats:
        near, far = deflection[:, :3], deflection[:, 3:]
        bends = [segment @ rows for segment, rows in ((near, self._bend[:3]), (far, self._bend[3:]))]
        firm = [1 + self._firm * (np.sqrt(1 + s**2) - 1).sum(axis=1, keepdims=True) for s in (near, far)]
        bends = [bends[0] / firm[0] - self._back * bends[1] / firm[1], bends[1] / firm[1]]
        longer = [1 + self._longer[k] * s.sum(axis=1) for k, s in enumerate((near, far))]
        frame = np.broadcast_to(np.eye(3), (len(deflection), 3, 3))
        at, nodes = np.zeros((len(deflection), 3)), []
        for piece in range(2 * _PIECES):
            own = piece // _PIECES
            turn = _turn(bends[own] * self._thinner[piece])
            frame = frame @ turn
            at = at + self._length_mm * longer[own][:, None] * frame[:, :, 2]
            nodes.append((at, frame))
        points = [nodes[k - 1][0] + nodes[k - 1][1] @ self._skin_mm[m] for m, k in enumerate(self._at)]
        return np.stack(points, axis=1).reshape(len(deflection), -1)


def _turn(bend: Floats) -> Floats:
    """Rotations (T, 3, 3) that lean the z-axis towards (x, y) = `bend` (T, 2), by its length in rad."""
    angle = np.hypot(bend[:, 0], bend[:, 1])
    s, c = np.sinc(angle / np.pi), 0.5 * np.sinc(angle / (2 * np.pi)) ** 2
    x, y = bend.T
    rows = [
        [1 - c * x * x, -c * x * y, s * x],
        [-c * x * y, 1 - c * y * y, s * y],
        [-s * x, -s * y, np.cos(angle)],
    ]
    return np.stack([np.stack(row, axis=1) for row in rows], axis=1)
