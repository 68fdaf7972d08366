"""Rigs of the fifth portion without markers: muscles on a load cell, a lens, a honeycomb, a hand and a fibre."""

import numpy as np

from labrig.arrays import Floats
from labrig.bench._nature import Observable, Rig
from labrig.bench.development.rigs._common import chambers, cubic_membrane


class Tugs(Rig):
    """Muscles pull on one ring from several sides; the load cell that holds it tells three forces.

    G. K. Klute, J. M. Czerniecki, B. Hannaford, Artificial muscles: actuators for biorobotic systems, Int. J. Robotics
    Research 21, 2002. A bladder must first fill its braid; the cell gives way a little, and all pulls turn with it.
    """

    kind = "tugs"

    def __init__(self, random: np.random.Generator) -> None:
        count = int(random.integers(3, 8))
        self.chambers = chambers(count)
        self.high_kpa = random.uniform(150, 450) * random.uniform(0.95, 1.05, count)
        self.observables = tuple(Observable(f"force_{axis}", "N") for axis in "xyz")
        self.noise = float(random.uniform(0.25, 0.7))
        around = 2 * np.pi * np.arange(count) / count + random.normal(0, 0.15, count)
        up = random.uniform(-0.5, 0.9, count)
        self._way = np.column_stack([np.cos(around), np.sin(around), up])
        self._way /= np.linalg.norm(self._way, axis=1, keepdims=True)
        self._pulls_n = random.uniform(30, 120) * random.uniform(0.85, 1.15, count)
        self._gives = (
            random.uniform(0.02, 0.1) / self._pulls_n.mean()
        )  # of a muscle's length, for each newton
        self._zero_n = random.normal(0, 1, 3)
        self._fills, self._round = random.uniform(0.1, 0.35, count), random.uniform(0.08, 0.15)

    def deflection(self, kpa: Floats) -> Floats:
        def past(load: Floats) -> Floats:
            return np.logaddexp(0.0, (load - self._fills) / self._round)

        none = past(np.zeros(len(self._fills)))
        return (past(kpa / self.high_kpa) - none) / (past(np.ones(len(self._fills))) - none)

    def shape(self, deflection: Floats) -> Floats:
        pull = deflection * self._pulls_n
        force = pull @ self._way
        for _ in range(3):
            size = np.linalg.norm(force, axis=1, keepdims=True) * self._gives
            moved = force * self._gives * np.where(size > 0, np.tanh(size) / np.maximum(size, 1e-12), 1.0)
            way = self._way - 0.5 * moved[:, None]
            way = way / np.linalg.norm(way, axis=2, keepdims=True)
            force = np.einsum("tc,tcx->tx", pull, way)
        return self._zero_n + force


class Lens(Rig):
    """A liquid lens: pressure bulges its membrane into a cap, and a wavefront sensor tells its power.

    H. Ren, S.-T. Wu, Variable-focus liquid lens, Optics Express 15, 2007. One chamber and one number, in dioptres.
    """

    kind = "lens"

    def __init__(self, random: np.random.Generator) -> None:
        self.chambers = chambers(1)
        self.high_kpa = random.uniform(1.5, 8, 1)
        self.observables = (Observable("power", "dpt"),)
        self.noise = float(random.uniform(0.05, 0.15))
        self._rim_m = 1e-3 * random.uniform(4, 9)
        self._high_m = self._rim_m * random.uniform(0.2, 0.45)
        self._index, self._first_dpt = random.uniform(1.33, 1.5), random.uniform(-3, 3)
        self._cubic = random.uniform(0.2, 0.75, 1)

    def deflection(self, kpa: Floats) -> Floats:
        return cubic_membrane(kpa / self.high_kpa, self._cubic)

    def shape(self, deflection: Floats) -> Floats:
        height_m = self._high_m * deflection
        return self._first_dpt + (self._index - 1) * 2 * height_m / (self._rim_m**2 + height_m**2)


class Comb(Rig):
    """A honeycomb: cells share their walls, so that each that rises takes its neighbours a good way along.

    A. A. Stanley, A. M. Okamura, Controllable surface haptics via particle jamming and pneumatics, IEEE Trans. Haptics
    8, 2015. Lasers look down on some places; cells stiffen at first and give way the more, the fuller.
    """

    kind = "comb"

    def __init__(self, random: np.random.Generator) -> None:
        count, seen = int(random.integers(5, 11)), int(random.integers(4, 15))
        self.chambers = chambers(count)
        self.high_kpa = random.uniform(10, 40) * random.uniform(0.9, 1.1, count)
        self.observables = tuple(Observable(f"height{k + 1}", "mm") for k in range(seen))
        self.noise = float(random.uniform(0.01, 0.03))
        i, j = (axis.ravel() for axis in np.meshgrid(np.arange(-2, 3), np.arange(-2, 3)))
        cell = np.column_stack([i + 0.5 * j, np.sqrt(0.75) * j])
        cell = cell[np.argsort(np.linalg.norm(cell - [0.1, 0.03], axis=1))[:count]]
        apart = np.linalg.norm(cell[:, None] - cell, axis=2)
        near = ((apart > 0.5) & (apart < 1.2)).astype(float)
        tied = random.uniform(0.25, 0.7) * near
        self._shares = np.linalg.inv(np.eye(count) + np.diag(tied.sum(axis=1)) - tied)  # rows sum to 1
        place = cell[random.integers(0, count, seen)] + random.normal(0, 0.25, (seen, 2))
        wide = random.uniform(0.35, 0.6)
        bump = np.exp(-0.5 * (np.linalg.norm(cell[:, None] - place, axis=2) / wide) ** 2)
        self._lifts_mm = random.uniform(4, 10) * random.uniform(0.85, 1.15, (count, 1)) * bump
        self._zero_mm = random.normal(0, 0.2, seen)
        self._opens = random.uniform(0.5, 1.8, count)

    def deflection(self, kpa: Floats) -> Floats:
        own = np.sinh(self._opens * kpa / self.high_kpa) / np.sinh(self._opens)
        return own @ self._shares.T

    def shape(self, deflection: Floats) -> Floats:
        return self._zero_mm + deflection @ self._lifts_mm


class Hand(Rig):
    """A hand: each digit closes its near joint early and its far ones late; a chamber in the palm cups them all.

    R. Deimel, O. Brock, A novel type of compliant and underactuated robotic hand for dexterous grasping, Int. J.
    Robotics Research 35, 2016. Bend sensors tell the angles of the joints.
    """

    kind = "hand"

    def __init__(self, random: np.random.Generator) -> None:
        digits, joints = int(random.integers(3, 6)), int(random.integers(2, 4))
        self.chambers = chambers(digits + 1)
        self.high_kpa = np.append(np.full(digits, random.uniform(60, 200)), random.uniform(30, 80))
        self.high_kpa = self.high_kpa * random.uniform(0.93, 1.07, digits + 1)
        self.observables = tuple(
            Observable(f"digit{d + 1}_joint{j + 1}", "deg") for d in range(digits) for j in range(joints)
        )
        self.noise = float(random.uniform(0.15, 0.4))
        self._closes_deg = random.uniform(35, 80, (digits, joints))
        self._late = np.linspace(0.6, 2.2, joints) * random.uniform(0.9, 1.1, (digits, joints))
        self._cups_deg = random.uniform(5, 20, digits) * random.choice([-1.0, 1.0], digits)
        self._shares = random.uniform(
            -0.25, 0.25, digits
        )  # of a digit's way, by which a cupped palm changes it
        self._rest_deg = random.normal(5, 4, (digits, joints))
        self._steep, self._middle = random.uniform(2, 5, digits + 1), random.uniform(0.25, 0.55, digits + 1)

    def deflection(self, kpa: Floats) -> Floats:
        def along(load: Floats) -> Floats:
            return 0.5 * (1 + np.tanh(0.5 * self._steep * (load - self._middle)))

        first, last = along(np.zeros(len(self._steep))), along(np.ones(len(self._steep)))
        return (along(kpa / self.high_kpa) - first) / (last - first)

    def shape(self, deflection: Floats) -> Floats:
        own, palm = deflection[:, :-1, None], deflection[:, -1:, None]
        size = np.minimum(np.abs(own), 3.0)
        angle = self._closes_deg * np.sign(own) * size**self._late * (1 + self._shares[:, None] * palm)
        angle[..., 0] += self._cups_deg * palm[..., 0]
        return (self._rest_deg + angle).reshape(len(deflection), -1)


class Bragg(Rig):
    """An arm of one or two sections with three chambers each, felt by Bragg gratings along three or four fibres.

    M. Froggatt, J. Moore, High-spatial-resolution distributed strain measurement in optical fiber, Applied Optics 37,
    1998. Strain is that of stretch and of bending, whose curvature fades from a section's foot to its end.
    """

    kind = "bragg"

    def __init__(self, random: np.random.Generator) -> None:
        sections, fibres = int(random.integers(1, 3)), int(random.integers(3, 5))
        gratings, count = int(random.integers(5, 13)), 3 * sections
        self.chambers = chambers(count)
        self.high_kpa = random.uniform(40, 150) * random.uniform(0.95, 1.05, count)
        self.observables = tuple(
            Observable(f"fibre{f + 1}_{g + 1}", "um/m") for f in range(fibres) for g in range(gratings)
        )
        self.noise = float(random.uniform(2, 5))
        side = 2 * np.pi * np.arange(fibres) / fibres + random.normal(0, 0.05, fibres)
        place = (np.arange(gratings) + 0.5) / gratings * sections
        chamber = 2 * np.pi * (np.arange(count) % 3) / 3 + random.normal(0, 0.05, count)
        within = place - np.repeat(np.arange(sections), 3)[:, None]  # (C, gratings)
        here = 1 / (1 + np.exp(-within / 0.06)) / (1 + np.exp((within - 1) / 0.06))
        fades = here * (1 - random.uniform(0.0, 0.4) * np.clip(within, 0.0, 1.0))
        toward = np.cos(side[:, None] - chamber)  # (fibres, C)
        bends, grows = random.uniform(800, 3000), random.uniform(100, 600)
        strain = bends * toward[..., None] * fades + grows * here
        self._strain = strain.transpose(1, 0, 2).reshape(count, -1) * random.uniform(0.9, 1.1, (count, 1))
        self._squares = random.uniform(0.02, 0.12) / bends  # by which stretch counts more than in proportion
        self._first = random.normal(0, 40, fibres * gratings)
        self._hardens = random.uniform(0.1, 0.6, count)

    def deflection(self, kpa: Floats) -> Floats:
        load = kpa / self.high_kpa
        return load * (1 + self._hardens * load**2) / (1 + self._hardens)

    def shape(self, deflection: Floats) -> Floats:
        strain = deflection @ self._strain
        return self._first + strain + self._squares * strain**2
