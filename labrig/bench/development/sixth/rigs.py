"""Rigs of the sixth portion that are seen by cameras: a vine, a tongue, a crawler and a ray."""

import numpy as np

from labrig.arrays import Floats
from labrig.bench._nature import Rig
from labrig.bench.development.rigs._common import chambers, markers


def bent(along: Floats, turn: Floats, beside: Floats) -> Floats:
    """Places (T, M, 3) of points beside a bent line: `along` (T, M) it, turned (T, M, 2) there, `beside` (T, M, 2).

    From its foot to there the line is an arc of a circle; `turn` is an angle towards x and y.
    """
    angle = np.linalg.norm(turn, axis=2)
    part = np.sinc(0.5 * angle / np.pi) ** 2
    sine = np.sinc(angle / np.pi)
    out = 0.5 * (along * part)[..., None] * turn + beside
    toward = np.sum(turn * beside, axis=2)
    out = out - 0.5 * (part * toward)[..., None] * turn
    return np.concatenate([out, (along * sine - sine * toward)[..., None]], axis=2)


class Vine(Rig):
    """A vine robot: one chamber pushes it out at its tip past a pressure, and pouches along its sides bend it.

    E. W. Hawkes, L. H. Blumenschein, J. D. Greer, A. M. Okamura, A soft robot that navigates its environment through
    growth, Science Robotics 2, 2017. Rings with two markers each slide along; walls give way with a kink, hardly at
    first and then evenly.
    """

    kind = "vine"

    def __init__(self, random: np.random.Generator) -> None:
        sides, rings = int(random.integers(2, 5)), int(random.integers(4, 9))
        count = sides + 1
        self.chambers = chambers(count)
        self.high_kpa = np.append(random.uniform(10, 25), random.uniform(8, 35, sides))
        self.marker_names, self.observables = markers(2 * rings)
        self.noise = float(random.uniform(0.1, 0.3))
        self._long_mm, self._grows = random.uniform(150, 300), random.uniform(0.3, 0.9)
        self._at = np.repeat((np.arange(rings) + 1.0) / rings, 2)
        around = np.tile([0.0, np.pi], rings) + np.repeat(random.uniform(0, 2 * np.pi, rings), 2)
        self._beside_mm = random.uniform(15, 35) * np.column_stack([np.cos(around), np.sin(around)])
        faces = 2 * np.pi * np.arange(sides) / sides + random.normal(0, 0.1, sides)
        bends = np.deg2rad(random.uniform(25, 80)) * random.uniform(0.85, 1.15, sides)
        self._bends_rad = bends[:, None] * np.column_stack([np.cos(faces), np.sin(faces)])
        self._kink = random.uniform(0.1, 0.45, count)
        self._slope = np.append(random.uniform(0.05, 0.2), random.uniform(0.2, 0.6, sides))
        self.rest_mm = self.shape(np.zeros((1, count))).reshape(-1, 3)

    def deflection(self, kpa: Floats) -> Floats:
        load = kpa / self.high_kpa
        past = np.maximum(load - self._kink, 0.0)
        return (self._slope * (load - past) + past) / (self._slope * self._kink + 1 - self._kink)

    def shape(self, deflection: Floats) -> Floats:
        longer = 1 + self._grows * deflection[:, :1]
        turn = (longer * (deflection[:, 1:] @ self._bends_rad))[:, None] * self._at[:, None]
        beside = np.broadcast_to(self._beside_mm, (*turn.shape[:2], 2))
        return bent(self._long_mm * longer * self._at, turn, beside).reshape(len(deflection), -1)


class Tongue(Rig):
    """A tongue keeps its volume: squeezed across it grows longer and thinner, squeezed along one side it bends there.

    W. M. Kier, K. K. Smith, Tongues, tentacles and trunks: the biomechanics of movement in muscular-hydrostats,
    Zoological J. Linnean Society 83, 1985. Walls give way less and less, by a hyperbola.
    """

    kind = "tongue"

    def __init__(self, random: np.random.Generator) -> None:
        sides, across = int(random.integers(3, 5)), int(random.integers(3, 6))
        count, rows, seen = sides + across, int(random.integers(5, 10)), int(random.integers(4, 6))
        self.chambers = chambers(count)
        self.high_kpa = random.uniform(20, 70) * random.uniform(0.9, 1.1, count)
        self.marker_names, self.observables = markers(rows * seen)
        self.noise = float(random.uniform(0.04, 0.12))
        self._sides, self._long_mm = sides, random.uniform(60, 110)
        self._at = np.repeat((np.arange(rows) + 0.7) / rows, seen)
        around = np.tile(2 * np.pi * np.arange(seen) / seen, rows) + random.normal(0, 0.1, rows * seen)
        thick_mm = random.uniform(10, 18) * (1 - random.uniform(0.1, 0.5) * self._at)
        wide = random.uniform(1.0, 1.8)
        self._beside_mm = thick_mm[:, None] * np.column_stack([wide * np.cos(around), np.sin(around)])
        faces = 2 * np.pi * np.arange(sides) / sides + random.normal(0, 0.1, sides)
        bends = np.deg2rad(random.uniform(25, 60)) * random.uniform(0.85, 1.15, sides)
        self._bends_rad = bends[:, None] * np.column_stack([np.cos(faces), np.sin(faces)])
        middle = (np.arange(across) + 0.5) / across
        fine = np.linspace(0.0, 1.0, 61)
        self._fine = fine
        near = np.exp(-0.5 * ((fine - middle[:, None]) * across / 0.8) ** 2)
        self._grows = random.uniform(0.15, 0.4) * random.uniform(0.85, 1.15, (across, 1)) * near
        self._shortens = random.uniform(0.02, 0.1)  # by each chamber along it
        self._levels = random.uniform(0.4, 2.0, count)
        self.rest_mm = self.shape(np.zeros((1, count))).reshape(-1, 3)

    def deflection(self, kpa: Floats) -> Floats:
        load = kpa / self.high_kpa
        return load * (1 + self._levels) / (1 + self._levels * np.abs(load))

    def shape(self, deflection: Floats) -> Floats:
        sides, across = deflection[:, : self._sides], deflection[:, self._sides :]
        log = across @ self._grows - self._shortens * sides.sum(axis=1, keepdims=True)  # of the stretch
        stretch = np.exp(0.8 * np.tanh(log / 0.8))
        gone = np.cumsum(stretch, axis=1) / len(self._fine)
        index = np.rint(self._at * (len(self._fine) - 1)).astype(int)
        turn = (sides @ self._bends_rad)[:, None] * self._at[:, None]
        beside = self._beside_mm / np.sqrt(stretch[:, index])[..., None]
        return bent(self._long_mm * gone[:, index], turn, beside).reshape(len(deflection), -1)


class Crawler(Rig):
    """A crawler: one chamber in a skin with cuts grows longer; once the cuts buckle its scales pop out, by a root.

    A. Rafsanjani, Y. Zhang, B. Liu, S. M. Rubinstein, K. Bertoldi, Kirigami skins make a simple soft actuator crawl,
    Science Robotics 3, 2018. One camera sees it from the side, in x and z. The wall is stiff, soft, and stiff again.
    """

    kind = "crawler"

    def __init__(self, random: np.random.Generator) -> None:
        seen = int(random.integers(6, 13))
        self.chambers = chambers(1)
        self.high_kpa = random.uniform(20, 80, 1)
        self.marker_names, in_space = markers(seen)
        self.observables = tuple(o for o in in_space if o.axis != 1)
        self.noise = float(random.uniform(0.02, 0.06))
        self._at_mm = random.uniform(80, 160) * (np.arange(seen) + random.uniform(-0.2, 0.2, seen)) / seen
        self._up_mm = random.uniform(8, 14) + random.normal(0, 0.3, seen)
        self._grows = random.uniform(0.1, 0.3) * random.uniform(0.8, 1.2, seen)
        self._pops_mm = random.uniform(1.5, 5) * random.choice([0.0, 1.0, -0.5], seen, p=[0.3, 0.5, 0.2])
        self._first = random.uniform(0.05, 0.2)
        load = np.array([random.uniform(0.15, 0.35), random.uniform(0.65, 0.85)])
        way = np.array([0.4 * load[0], 1 - random.uniform(0.3, 0.7) * (1 - load[1])])
        self._load, self._way = np.concatenate([[0.0], load, [1.0]]), np.concatenate([[0.0], way, [1.0]])
        flat = self.shape(np.zeros((1, 1))).reshape(-1, 2)
        self.rest_mm = np.column_stack([flat[:, 0], np.zeros(seen), flat[:, 1]])

    def deflection(self, kpa: Floats) -> Floats:
        load = kpa / self.high_kpa
        slope = np.diff(self._way) / np.diff(self._load)
        beyond = slope[0] * np.minimum(load, 0.0) + slope[-1] * np.maximum(load - 1, 0.0)
        return np.interp(load, self._load, self._way) + beyond

    def shape(self, deflection: Floats) -> Floats:
        along = self._at_mm * (1 + self._grows * deflection)
        pops = np.sqrt(np.maximum(deflection, 0.0) ** 2 + self._first**2) - self._first
        up = self._up_mm * (1 - 0.1 * deflection) + self._pops_mm * np.sqrt(pops + 0.01) - 0.1 * self._pops_mm
        return np.stack([along, up], axis=2).reshape(len(deflection), -1)


class Ray(Rig):
    """A ray: stiff ribs across two soft fins bend up with pressure and down with vacuum, and the skin spans them.

    Y. Cai, S. Bi, L. Zheng, Design and experiments of a robotic fish imitating cow-nosed ray, J. Bionic Engineering 7,
    2010. Each rib is an arc of a circle; ribs level off either way.
    """

    kind = "ray"

    def __init__(self, random: np.random.Generator) -> None:
        ribs, rows, out = int(random.integers(2, 6)), int(random.integers(4, 7)), int(random.integers(3, 5))
        self._ribs, count = ribs, 2 * ribs
        self.chambers = chambers(count)
        self.high_kpa = random.uniform(15, 50) * random.uniform(0.93, 1.07, count)
        self._low_kpa = -self.high_kpa * random.uniform(0.5, 0.95)
        self.marker_names, self.observables = markers(2 * rows * out)
        self.noise = float(random.uniform(0.06, 0.15))
        length = np.linspace(0.0, 1.0, rows)
        share = np.maximum(0.0, 1 - np.abs(length * (ribs - 1) - np.arange(ribs)[:, None]))  # (ribs, rows)
        self._share = np.repeat(share, out, axis=1)
        self._y_mm = np.repeat(random.uniform(100, 180) * (length - 0.5), out)
        self._out = np.tile((np.arange(out) + 1.0) / out, rows)
        wing = random.uniform(70, 130) * (1 - random.uniform(0.2, 0.5) * np.abs(2 * length - 0.8))
        self._wide_mm, self._body_mm = np.repeat(wing, out), random.uniform(20, 40)
        self._bends_rad = np.deg2rad(random.uniform(30, 75)) * random.uniform(0.9, 1.1, count)
        self._droops_rad = np.deg2rad(random.uniform(-5, 15))
        self._levels = random.uniform(0.3, 3.0, count)
        self.rest_mm = self.shape(np.zeros((1, count))).reshape(-1, 3)

    @property
    def low_kpa(self) -> Floats:
        return self._low_kpa

    def deflection(self, kpa: Floats) -> Floats:
        load = kpa / self.high_kpa
        return load * np.sqrt(1 + self._levels) / np.sqrt(1 + self._levels * load**2)

    def shape(self, deflection: Floats) -> Floats:
        fins = []
        for k, side in enumerate((-1.0, 1.0)):
            own = slice(k * self._ribs, (k + 1) * self._ribs)
            angle = (deflection[:, own] * self._bends_rad[own]) @ self._share * self._out
            chord = self._wide_mm * self._out * np.sinc(0.5 * angle / np.pi)
            up = 0.5 * angle - self._droops_rad
            y = np.broadcast_to(self._y_mm, angle.shape)
            fins.append(
                np.stack([side * (self._body_mm + chord * np.cos(up)), y, chord * np.sin(up)], axis=2)
            )
        return np.concatenate(fins, axis=1).reshape(len(deflection), -1)
