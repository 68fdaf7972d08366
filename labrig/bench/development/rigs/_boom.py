"""An arm of two to four rotary bellows on a base that gives way under its moment."""

import numpy as np
from scipy.spatial.transform import Rotation

from labrig.arrays import Floats
from labrig.bench._nature import Rig
from labrig.bench.development.rigs._common import chambers, markers


class Boom(Rig):
    """Rigid links on rotary bellows; the base leans by the moment of the arm, so that a far reach sinks.

    M. W. Spong, S. Hutchinson, M. Vidyasagar, Robot Modeling and Control, Wiley, 2006. The first joint turns the arm
    about the vertical, the others lift it.
    """

    kind = "boom"

    def __init__(self, random: np.random.Generator) -> None:
        count = int(random.integers(2, 5))
        self.chambers = chambers(count)
        self.high_kpa = random.uniform(80, 250) * random.uniform(0.93, 1.07, count)
        each = int(random.integers(2, 4))
        self.marker_names, self.observables = markers(2 + each * count)
        self.noise = float(random.uniform(0.1, 0.2))
        self._turn_rad = np.deg2rad(random.uniform(25, 60, count)) * random.choice([-1.0, 1.0], count)
        self._start_rad = np.deg2rad(np.append(random.uniform(-20, 20), random.uniform(-50, 30, count - 1)))
        self._length_mm = random.uniform(60, 110) * random.uniform(0.8, 1.1, count)
        self._high_mm = random.uniform(50, 90)
        weight = np.linspace(1.0, 0.5, count)
        self._weight = weight / weight.sum()
        self._leans = np.deg2rad(random.uniform(1.0, 4.0)) / self._length_mm.sum()  # rad for each mm of reach
        self._spots_mm = np.column_stack(
            [
                (np.arange(each) + 0.7) / (each + 0.4),
                random.uniform(8, 15, (each, 2)) * np.array([1.0, 0.6]),
            ]
        )
        self._base_mm = np.array([[35.0, 20.0, 12.0], [-30.0, 25.0, 12.0]]) + random.normal(0, 4, (2, 3))
        self._power = random.uniform(0.7, 1.5, count)
        self.rest_mm = self.shape(np.zeros((1, count))).reshape(-1, 3)

    def deflection(self, kpa: Floats) -> Floats:
        load = kpa / self.high_kpa
        return load * ((0.05 + np.abs(load)) / 1.05) ** (self._power - 1)

    def shape(self, deflection: Floats) -> Floats:
        turn = self._start_rad + deflection * self._turn_rad
        yaw = turn[:, 0]
        lift = np.cumsum(turn[:, 1:], axis=1)
        lift = np.hstack(
            [np.full((len(turn), 1), self._start_rad[0]), lift]
        )  # of each link; the first is fixed
        flat = np.stack([np.cos(yaw), np.sin(yaw), 0 * yaw], axis=1)[:, None]
        beside = np.stack([-np.sin(yaw), np.cos(yaw), 0 * yaw], axis=1)[:, None]
        up = np.array([0.0, 0.0, 1.0])
        along = np.cos(lift)[..., None] * flat + np.sin(lift)[..., None] * up  # (T, links, 3)
        square = -np.sin(lift)[..., None] * flat + np.cos(lift)[..., None] * up
        steps = self._length_mm[:, None] * along
        start = np.cumsum(steps, axis=1) - steps + self._high_mm * up
        spots = (
            start[:, :, None]
            + self._spots_mm[:, 0, None] * steps[:, :, None]
            + self._spots_mm[:, 1, None] * beside[:, :, None]
            + self._spots_mm[:, 2, None] * square[:, :, None]
        ).reshape(len(turn), -1, 3)
        centre = np.einsum("tlx,l->tx", start + 0.5 * steps, self._weight)
        moment = self._leans * np.stack([-centre[:, 1], centre[:, 0], 0 * yaw], axis=1)
        base = np.broadcast_to(self._base_mm, (len(turn), 2, 3))
        points = np.concatenate([base, spots], axis=1)
        leant = Rotation.from_rotvec(moment).as_matrix()
        return np.einsum("txy,tmy->tmx", leant, points).reshape(len(turn), -1)
