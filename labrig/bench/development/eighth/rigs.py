"""Rigs of the eighth portion: a mattress, a tripod of bellows, a press, a lung, and one that curls."""

import numpy as np

from labrig.arrays import Floats
from labrig.bench._nature import Observable, Rig
from labrig.bench.development.rigs._common import chambers, markers


class Mattress(Rig):
    """A mattress: cells in rows lift a cover, which spreads each lift to its neighbours and is drawn in by slopes.

    A. D. Kerr, Elastic and viscoelastic foundation models, J. Applied Mechanics 31, 1964, on membranes upon springs.
    Cells level off as their tops get taut, but not much.
    """

    kind = "mattress"

    def __init__(self, random: np.random.Generator) -> None:
        wide, long = int(random.integers(2, 4)), int(random.integers(3, 5))
        count, across, down = wide * long, int(random.integers(4, 6)), int(random.integers(7, 10))
        self.chambers = chambers(count)
        self.high_kpa = random.uniform(4, 12) * random.uniform(0.95, 1.05, count)
        self.marker_names, self.observables = markers(across * down)
        self.noise = float(random.uniform(0.15, 0.4))
        cell_mm = random.uniform(90, 140)
        rows, lines = np.meshgrid(np.arange(wide), np.arange(long), indexing="ij")
        self._cells_mm = cell_mm * (np.column_stack([rows.ravel(), lines.ravel()]) + 0.5)
        grid = np.meshgrid(np.linspace(0.15, 0.85, across), np.linspace(0.1, 0.9, down), indexing="ij")
        spots = np.column_stack([grid[0].ravel() * wide, grid[1].ravel() * long]) * cell_mm
        self._spots_mm = spots + random.normal(0, 0.04 * cell_mm, spots.shape)
        self._lift_mm = random.uniform(50, 90) * random.uniform(0.9, 1.1, count)
        self._spread_mm = cell_mm * random.uniform(0.5, 0.75)
        self._high_mm = random.uniform(60, 100)
        self._half_mm = random.uniform(3, 8)  # from the cover's middle to its top
        self._taut = random.uniform(0.1, 0.3, count)
        self.rest_mm = self.shape(np.zeros((1, count))).reshape(-1, 3)

    def deflection(self, kpa: Floats) -> Floats:
        load = kpa / self.high_kpa
        return load * (1 + self._taut) / (1 + self._taut * np.abs(load))

    def shape(self, deflection: Floats) -> Floats:
        apart = self._spots_mm[:, None] - self._cells_mm
        felt = np.exp(-np.sum(apart**2, axis=2) / (2 * self._spread_mm**2)) * self._lift_mm
        lift = deflection @ felt.T
        slope = -np.einsum("tc,mc,mcx->tmx", deflection, felt, apart) / self._spread_mm**2
        steep = np.sqrt(1 + np.sum(slope**2, axis=2, keepdims=True))
        aside = self._spots_mm - self._half_mm * slope / steep
        up = self._high_mm + lift[..., None] + self._half_mm / steep
        return np.concatenate([aside, up], axis=2).reshape(len(deflection), -1)


class Tripod(Rig):
    """A tripod: three bellows, drawn in by vacuum and let out by pressure, carry a plate with pins between them.

    J.-P. Merlet, Parallel Robots, Kluwer, 2000, on plates on three legs. Metal bellows are nearly linear.
    """

    kind = "tripod"

    def __init__(self, random: np.random.Generator) -> None:
        count, seen = 3, int(random.integers(5, 10))
        self.chambers = chambers(count)
        self.high_kpa = random.uniform(25, 60) * random.uniform(0.95, 1.05, count)
        self._low_kpa = -self.high_kpa * random.uniform(0.4, 1.0)
        self.marker_names, self.observables = markers(seen)
        self.noise = float(random.uniform(0.02, 0.06))
        self._wide_mm, self._high_mm = random.uniform(25, 45), random.uniform(40, 80)
        around = 2 * np.pi * np.arange(count) / count + random.normal(0, 0.08, count)
        self._legs = np.column_stack([np.cos(around), np.sin(around)])
        self._reach_mm = random.uniform(8, 16) * random.uniform(0.9, 1.1, count)
        pins = random.uniform(0, 2 * np.pi) + 2 * np.pi * np.arange(seen) / seen
        out_mm = self._wide_mm * random.uniform(0.5, 1.4, seen)
        up_mm = random.uniform(0, 25, seen)
        self._pins_mm = np.column_stack([out_mm * np.cos(pins), out_mm * np.sin(pins), up_mm])
        self._hardens = random.uniform(0.0, 0.06, count)
        self.rest_mm = self.shape(np.zeros((1, count))).reshape(-1, 3)

    @property
    def low_kpa(self) -> Floats:
        return self._low_kpa

    def deflection(self, kpa: Floats) -> Floats:
        load = kpa / self.high_kpa
        return load * (1 + self._hardens) / (1 + self._hardens * np.abs(load))

    def shape(self, deflection: Floats) -> Floats:
        legs_mm = deflection * self._reach_mm
        middle_mm = legs_mm.mean(axis=1)
        slope = 2 / 3 * legs_mm @ self._legs / self._wide_mm  # of the plate along x and y
        size = np.linalg.norm(slope, axis=1, keepdims=True)
        angle = np.arctan(size)
        axis = np.column_stack([slope[:, 1], -slope[:, 0], 0 * size]) / np.maximum(size, 1e-12)
        pins = self._pins_mm
        across = np.cross(axis[:, None], pins)
        along = np.einsum("tx,mx->tm", axis, pins)[..., None] * axis[:, None]
        cosine, sine = np.cos(angle)[..., None], np.sin(angle)[..., None]
        turned = np.where(size[..., None] > 1e-9, cosine * pins + sine * across + (1 - cosine) * along, pins)
        turned[:, :, 2] += self._high_mm + middle_mm[:, None]
        return turned.reshape(len(deflection), -1)


class Press(Rig):
    """A press: one or two bags push a die down between posts, and load cells under it tell how hard.

    J. E. Shigley, Mechanical Engineering Design, McGraw-Hill, 1963. The die first lifts off the springs that hold it, a
    little; then force goes with pressure. The posts give way, so that two bags together press a little less.
    """

    kind = "press"

    def __init__(self, random: np.random.Generator) -> None:
        count, seen = int(random.integers(1, 3)), int(random.integers(2, 4))
        self.chambers = chambers(count)
        self.high_kpa = random.uniform(150, 400) * random.uniform(0.95, 1.05, count)
        self.observables = tuple(Observable(f"cell{k + 1}", "N") for k in range(seen))
        self.noise = float(random.uniform(0.3, 0.8))
        self._force_n = random.uniform(150, 400, (count, 1)) * random.dirichlet(np.full(seen, 6.0), count)
        self._weight_n = random.uniform(2, 10, seen)
        self._gives = random.uniform(0.02, 0.08)
        self._springs, self._soft = random.uniform(0.03, 0.12, count), random.uniform(0.05, 0.15)

    def deflection(self, kpa: Floats) -> Floats:
        load = kpa / self.high_kpa
        return self._pressed(load) / self._pressed(np.ones_like(self._springs))

    def _pressed(self, load: Floats) -> Floats:
        return load - self._springs * np.tanh(load / self._soft)

    def shape(self, deflection: Floats) -> Floats:
        force = deflection @ self._force_n
        return self._weight_n + force / np.sqrt(
            1 + self._gives * np.square(deflection.sum(axis=1, keepdims=True))
        )


class Lung(Rig):
    """A lung: lobes of foam in a box fill along S-shaped curves, and meters tell the volume of each, and the whole.

    J. G. Venegas, R. S. Harris, B. A. Simon, A comprehensive equation for the pulmonary pressure-volume curve, Journal
    of Applied Physiology 84, 1998. A full lobe takes some room from its neighbours.
    """

    kind = "lung"

    def __init__(self, random: np.random.Generator) -> None:
        count = int(random.integers(2, 6))
        self.chambers = chambers(count)
        self.high_kpa = random.uniform(2.5, 6.0) * random.uniform(0.95, 1.05, count)
        names = [*(f"lobe{k + 1}" for k in range(count)), "whole"]
        self.observables = tuple(Observable(name, "ml") for name in names)
        self.noise = float(random.uniform(1.0, 3.0))
        self._room_ml = random.uniform(250, 600, count)
        self._left_ml = random.uniform(50, 150, count)
        self._middle = random.uniform(0.35, 0.6, count)
        self._wide = random.uniform(0.1, 0.16, count)
        takes = random.uniform(0.02, 0.08, (count, count))
        self._takes = takes * (1 - np.eye(count))

    def deflection(self, kpa: Floats) -> Floats:
        load = kpa / self.high_kpa
        none, whole = np.tanh(-self._middle / self._wide / 2), np.tanh((1 - self._middle) / self._wide / 2)
        curve = np.tanh(np.clip((load - self._middle) / self._wide / 2, -50, 50))
        tissue = 0.05 * load  # stretches on beyond the curve
        return 0.95 * (curve - none) / (whole - none) + tissue

    def shape(self, deflection: Floats) -> Floats:
        own = deflection * self._room_ml
        lobes = self._left_ml + own * (1 - np.tanh(deflection @ self._takes))
        return np.concatenate([lobes, lobes.sum(axis=1, keepdims=True)], axis=1)


class Curl(Rig):
    """A curl: a strip with one chamber of many pockets rolls up, seen from the side by one camera, so in a plane.

    B. Mosadegh et al., Pneumatic networks for soft robotics that actuate rapidly, Advanced Functional Materials 24,
    2014. The pockets bulge with a power of the pressure, and bend more once they touch.
    """

    kind = "curl"

    def __init__(self, random: np.random.Generator) -> None:
        seen = int(random.integers(5, 13))
        self.chambers = chambers(1)
        self.high_kpa = random.uniform(40, 90, 1)
        self.marker_names = tuple(f"m{k + 1}" for k in range(seen))
        self.observables = tuple(
            Observable(f"m{k + 1}.{'xyz'[axis]}", "mm", k, axis) for k in range(seen) for axis in (0, 2)
        )
        self.noise = float(random.uniform(0.1, 0.25))
        self._long_mm = random.uniform(70, 150)
        self._at = np.sort(random.uniform(0.15, 1.0, seen))
        self._at[-1] = 1.0
        self._off_mm = random.uniform(-3, 9, seen)  # from the layer that does not stretch
        self._angle = np.deg2rad(random.uniform(120, 260))
        self._uneven = random.uniform(-0.4, 0.4)
        self._hangs = np.deg2rad(random.uniform(-60, 60))
        self._power, self._touch = random.uniform(1.5, 2.3), random.uniform(0.4, 0.7)
        self._more = random.uniform(0.3, 1.0)
        points = self._points(np.zeros((1, 1)))[0]
        self.rest_mm = np.column_stack([points[:, 0], np.zeros(seen), points[:, 1]])

    def deflection(self, kpa: Floats) -> Floats:
        load = kpa / self.high_kpa
        return self._bent(load) / self._bent(np.ones(1))

    def _bent(self, load: Floats) -> Floats:
        size = np.abs(load)
        touching = np.maximum(size - self._touch, 0.0) ** 1.5
        return np.sign(load) * (size**self._power / (1 + 0.3 * size**self._power) + self._more * touching)

    def _points(self, deflection: Floats) -> Floats:
        """The markers (T, M, 2) in the camera's plane."""
        along = np.linspace(0.0, 1.0, 81)
        angle = self._angle * deflection * (along + self._uneven * along * (1 - along))  # (T, 81)
        heading = self._hangs + angle
        ways = np.stack([np.cos(heading), np.sin(heading)], axis=2) * self._long_mm
        legs = 0.5 * (ways[:, 1:] + ways[:, :-1]) / (len(along) - 1)
        line = np.concatenate([np.zeros((len(legs), 1, 2)), np.cumsum(legs, axis=1)], axis=1)
        place = self._at * (len(along) - 1)
        low = np.minimum(place.astype(int), len(along) - 2)
        share = place - low
        turn = heading[:, low] * (1 - share) + heading[:, low + 1] * share
        foot = line[:, low] * (1 - share)[:, None] + line[:, low + 1] * share[:, None]
        return foot + self._off_mm[:, None] * np.stack([-np.sin(turn), np.cos(turn)], axis=2)

    def shape(self, deflection: Floats) -> Floats:
        return self._points(deflection).reshape(len(deflection), -1)
