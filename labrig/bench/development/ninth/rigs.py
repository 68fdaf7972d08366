"""Rigs of the ninth portion: a dome, a fibre finger, an arm of two segments, a twister, a pouch sheet."""

import numpy as np

from labrig.arrays import Floats
from labrig.bench._nature import Observable, Rig
from labrig.bench.development.rigs._common import chambers, cubic_membrane, markers, turns


class Dome(Rig):
    """A dome: one membrane over many cells, blown out by air, drawn in by vacuum; neighbours move along.

    J. D. Campbell, On the theory of initially tensioned circular membranes subjected to uniform pressure,
    Quarterly J. Mechanics and Applied Mathematics 9, 1956. All cells together make the membrane taut, and
    each then lifts less.
    """

    kind = "blown_dome"

    def __init__(self, random: np.random.Generator) -> None:
        count, seen = int(random.integers(5, 9)), int(random.integers(14, 31))
        self.chambers = chambers(count)
        self.high_kpa = random.uniform(8, 25) * random.uniform(0.95, 1.05, count)
        self._low_kpa = -self.high_kpa * random.uniform(0.25, 0.6)
        self.marker_names, self.observables = markers(seen)
        self.noise = float(random.uniform(0.05, 0.15))
        wide_mm = random.uniform(45, 90)
        around = random.uniform(0, 2 * np.pi) + 2 * np.pi * np.arange(count - 1) / (count - 1)
        ring = 0.58 * np.column_stack([np.cos(around), np.sin(around)])
        cells = np.concatenate([np.zeros((1, 2)), ring + random.normal(0, 0.02, ring.shape)])
        out = 0.92 * np.sqrt((np.arange(seen) + 0.5) / seen)
        angle = np.arange(seen) * np.pi * (3 - np.sqrt(5))
        spots = np.column_stack([out * np.cos(angle), out * np.sin(angle)]) + random.normal(
            0, 0.02, (seen, 2)
        )
        clamped = np.maximum(1 - np.sum(spots**2, axis=1), 0.03)
        near = np.exp(-np.sum((spots[:, None] - cells) ** 2, axis=2) / (2 * random.uniform(0.3, 0.42) ** 2))
        self._felt_mm = wide_mm * random.uniform(0.14, 0.22) * clamped[:, None] * near
        self._felt_mm *= random.uniform(0.88, 1.12, count)
        high = random.uniform(0.15, 0.4)
        self._spots_mm = wide_mm * np.column_stack([spots, high * clamped])
        normal = np.column_stack([2 * high * spots, np.ones(seen)])
        self._normal = normal / np.linalg.norm(normal, axis=1, keepdims=True)
        self._taut = random.uniform(0.2, 0.5)
        self._cubic = random.uniform(0.55, 0.8) * random.uniform(0.95, 1.05, count)
        self.rest_mm = self.shape(np.zeros((1, count))).reshape(-1, 3)

    @property
    def low_kpa(self) -> Floats:
        return self._low_kpa

    def deflection(self, kpa: Floats) -> Floats:
        return cubic_membrane(kpa / self.high_kpa, self._cubic)

    def shape(self, deflection: Floats) -> Floats:
        common = np.mean(deflection**2, axis=1, keepdims=True)
        lift = deflection @ self._felt_mm.T / np.sqrt(1 + self._taut * common)
        return (self._spots_mm + lift[..., None] * self._normal).reshape(len(deflection), -1)


class FibreFinger(Rig):
    """A fibre finger: two or three sections, each wound with threads at its own angle, bend and twist.

    P. Polygerinos et al., Modeling of soft fiber-reinforced bending actuators, IEEE Transactions on Robotics
    31(3), 2015; F. Connolly et al., Mechanical programming of soft actuators by varying fiber angle, Soft
    Robotics 2, 2015. The bend grows faster than the pressure, as the rubber softens with stretch.
    """

    kind = "fibre_finger"

    def __init__(self, random: np.random.Generator) -> None:
        count, seen = int(random.integers(2, 4)), int(random.integers(9, 17))
        self.chambers = chambers(count)
        self.high_kpa = random.uniform(120, 250) * random.uniform(0.95, 1.05, count)
        self.marker_names, self.observables = markers(seen)
        self.noise = float(random.uniform(0.1, 0.3))
        self._long_mm = random.uniform(100, 170) * random.dirichlet(np.full(count, 40.0))
        bend = np.deg2rad(random.uniform(130, 220)) * random.dirichlet(np.full(count, 20.0))
        twist = np.deg2rad(random.uniform(-25, 25, count))
        self._turns = np.column_stack([twist, -bend, bend * random.uniform(-0.06, 0.06, count)])
        self._preset = np.deg2rad(random.normal(0, 2.5, (count, 3)))
        self._longer = random.uniform(0.02, 0.08, count)
        self._hinders = random.uniform(0.03, 0.1)  # the bend of a section, when its neighbours are full
        self._soft = random.uniform(1.2, 2.6) * random.uniform(0.92, 1.08, count)
        place = np.linspace(0.12, 1.0, seen) * count
        self._section = np.minimum(place.astype(int), count - 1)
        self._share = place - self._section
        half_mm = random.uniform(8, 13)
        side = half_mm * np.where(np.arange(seen) % 2, 1.0, -1.0) * random.uniform(0.6, 1.0, seen)
        self._off_mm = np.column_stack([np.zeros(seen), side, half_mm * random.uniform(-0.2, 1.0, seen)])
        self.rest_mm = self.shape(np.zeros((1, count))).reshape(-1, 3)

    def deflection(self, kpa: Floats) -> Floats:
        load = kpa / self.high_kpa
        return load * np.sqrt((1 + (self._soft * load) ** 2) / (1 + self._soft**2))

    def shape(self, deflection: Floats) -> Floats:
        times, count = deflection.shape
        padded = np.pad(deflection, ((0, 0), (1, 1)))
        beside = np.tanh(padded[:, :-2] + padded[:, 2:])
        bends = self._preset + (deflection * (1 - self._hinders * beside))[..., None] * self._turns
        piece_mm = self._long_mm * (1 + self._longer * deflection)
        foot, heading = np.zeros((times, 3)), np.broadcast_to(np.eye(3), (times, 3, 3))
        out = np.empty((times, len(self._share), 3))
        for c in range(count):
            at = np.flatnonzero(self._section == c)
            part = bends[:, None, c] * self._share[at, None]
            turn, bow = turns(part)
            along = bow[..., 0] * (piece_mm[:, None, c] * self._share[at])[..., None]
            local = along + np.einsum("tmij,mj->tmi", turn, self._off_mm[at])
            out[:, at] = foot[:, None] + np.einsum("tij,tmj->tmi", heading, local)
            turn, bow = turns(bends[:, c])
            end = bow[..., 0] * piece_mm[:, c, None]
            foot = foot + np.einsum("tij,tj->ti", heading, end)
            heading = heading @ turn
        return out.reshape(times, -1)


class TwoSegmentArm(Rig):
    """An arm: two segments hang in a row, each with three chambers around its axis, and bend.

    R. J. Webster III and B. A. Jones, Design and kinematic modeling of constant curvature continuum robots: a
    review, International J. Robotics Research 29(13), 2010. The chambers level off a little, the upper ones
    carry the hoses.
    """

    kind = "two_segment_arm"

    def __init__(self, random: np.random.Generator) -> None:
        count, rings = 6, int(random.integers(4, 8))
        each = int(random.integers(2, 4))
        self.chambers = chambers(count)
        self.high_kpa = np.repeat(random.uniform(60, 140, 2), 3) * random.uniform(0.96, 1.04, count)
        self.marker_names, self.observables = markers(rings * each)
        self.noise = float(random.uniform(0.15, 0.4))
        self._long_mm = random.uniform(90, 150) * np.array([1.0, random.uniform(0.7, 1.0)])
        radius_mm = random.uniform(16, 24) * np.array([1.0, random.uniform(0.75, 1.0)])
        start = random.uniform(0, 2 * np.pi) + np.array([0.0, np.pi / 3 + random.normal(0, 0.05)])
        around = start[:, None] + 2 * np.pi * np.arange(3) / 3 + random.normal(0, 0.04, (2, 3))
        stretch_mm = self._long_mm[:, None] * random.uniform(0.25, 0.4) * random.uniform(0.9, 1.1, (2, 3))
        lever = 2 / 3 * stretch_mm / radius_mm[:, None]
        self._turns = (
            np.stack([-np.sin(around), np.cos(around), np.zeros((2, 3))], axis=2) * -lever[..., None]
        )
        self._longer_mm = stretch_mm / 3
        self._hang = np.array([1.0, -1.0, -1.0])  # the base is above
        self._levels = random.uniform(0.08, 0.25) * random.uniform(0.8, 1.2, count)
        place = np.repeat(np.linspace(0.25, 2.0, rings), each)
        self._segment = np.minimum(place.astype(int), 1)
        self._share = place - self._segment
        at = random.uniform(0, 2 * np.pi) + 2 * np.pi * np.tile(np.arange(each), rings) / each
        out_mm = radius_mm[self._segment] * random.uniform(1.15, 1.3)
        self._off_mm = np.column_stack([out_mm * np.cos(at), out_mm * np.sin(at), np.zeros(len(at))])
        self.rest_mm = self.shape(np.zeros((1, count))).reshape(-1, 3)

    def deflection(self, kpa: Floats) -> Floats:
        load = kpa / self.high_kpa
        return load * (1 + self._levels) / (1 + self._levels * np.abs(load))

    def shape(self, deflection: Floats) -> Floats:
        times = len(deflection)
        own = deflection.reshape(times, 2, 3)
        bends = np.einsum("tsc,scx->tsx", own, self._turns)
        piece_mm = self._long_mm + np.einsum("tsc,sc->ts", own, self._longer_mm)
        foot, heading = np.zeros((times, 3)), np.broadcast_to(np.eye(3), (times, 3, 3))
        out = np.empty((times, len(self._share), 3))
        for s in range(2):
            at = np.flatnonzero(self._segment == s)
            part = bends[:, None, s] * self._share[at, None]
            turn, bow = turns(part)
            along = bow[..., 2] * (piece_mm[:, None, s] * self._share[at])[..., None]
            local = along + np.einsum("tmij,mj->tmi", turn, self._off_mm[at])
            out[:, at] = foot[:, None] + np.einsum("tij,tmj->tmi", heading, local)
            turn, bow = turns(bends[:, s])
            end = bow[..., 2] * piece_mm[:, s, None]
            foot = foot + np.einsum("tij,tj->ti", heading, end)
            heading = heading @ turn
        return (out * self._hang).reshape(times, -1)


class Twister(Rig):
    """A twister: helical chambers of both hands turn a disc, and an inclinometer on it tells the angles.

    B. Gorissen et al., Flexible pneumatic twisting actuators and their application to tilting micromirrors,
    Sensors and Actuators A 216, 2014. Threads that near their neutral angle turn less and less; both hands at
    once stiffen the body.
    """

    kind = "twister"

    def __init__(self, random: np.random.Generator) -> None:
        count, seen = int(random.integers(2, 5)), int(random.integers(2, 4))
        self.chambers = chambers(count)
        self.high_kpa = random.uniform(50, 180) * random.uniform(0.95, 1.05, count)
        names = ("twist", "pitch", "roll")[:seen]
        self.observables = tuple(Observable(name, "deg") for name in names)
        self.noise = float(random.uniform(0.1, 0.3))
        hand = np.where(np.arange(count) % 2, -1.0, 1.0)
        self._twist = hand * random.uniform(35, 80) * random.uniform(0.88, 1.12, count)
        around = random.uniform(0, 2 * np.pi) + 2 * np.pi * np.arange(count) / count
        self._tips = random.uniform(8, 20) * random.uniform(0.85, 1.15, count)
        self._around = around
        self._at_rest = random.normal(0, 2.0, seen)
        self._stiffens = random.uniform(0.1, 0.3)
        self._near = random.uniform(1.1, 1.7) * random.uniform(0.95, 1.05, count)

    def deflection(self, kpa: Floats) -> Floats:
        load = kpa / self.high_kpa
        return 0.93 * np.tanh(self._near * load) / np.tanh(self._near) + 0.07 * load

    def shape(self, deflection: Floats) -> Floats:
        every = deflection.sum(axis=1)
        both = (every**2 - np.sum(deflection**2, axis=1)) / 2
        twist = (
            deflection
            @ self._twist
            / np.sqrt(1 + self._stiffens * every**2 / (1 + np.abs(both)) + both**2 / 9)
        )
        turned = self._around + np.deg2rad(twist)[:, None] / 2  # the helices turn with the disc
        tips = deflection * self._tips
        pitch, roll = np.sum(tips * np.cos(turned), axis=1), np.sum(tips * np.sin(turned), axis=1)
        return self._at_rest + np.column_stack([twist, pitch, roll])[:, : len(self.observables)]


class PouchSheet(Rig):
    """A sheet of pouch motors: pouches welded across a flat strip fold it, most one way, some the other.

    R. Niiyama et al., Pouch motors: printable soft actuators integrated with computational design, Soft
    Robotics 2(2), 2015. The moment is greatest while a pouch is flat; a round one folds no further, and has
    drawn the sheet in.
    """

    kind = "pouch_sheet"

    def __init__(self, random: np.random.Generator) -> None:
        count, each = int(random.integers(4, 8)), int(random.integers(2, 4))
        seen = count * each
        self.chambers = chambers(count)
        self.high_kpa = random.uniform(10, 40) * random.uniform(0.95, 1.05, count)
        self.marker_names, self.observables = markers(seen)
        self.noise = float(random.uniform(0.1, 0.3))
        wide_mm = random.uniform(40, 80)
        self._panel_mm = random.uniform(22, 40) * random.uniform(0.9, 1.1, count + 1)
        askew = np.deg2rad(random.normal(0, 5, count))
        side = np.where(random.random(count) < 0.25, 1.0, -1.0)
        fold = np.deg2rad(random.uniform(28, 55)) * random.uniform(0.88, 1.12, count) * side
        self._axis = np.column_stack([np.sin(askew), np.cos(askew), np.zeros(count)])
        self._fold, self._sags = fold, np.deg2rad(random.normal(0, 4, count))
        self._drawn_mm = self._panel_mm[1:] * random.uniform(0.06, 0.14)
        self._round = random.uniform(0.3, 0.7) * random.uniform(0.9, 1.1, count)
        across = np.tile(np.linspace(-0.45, 0.45, each), count) + random.normal(0, 0.03, seen)
        self._hinge = np.repeat(np.arange(count), each)
        on = random.uniform(0.4, 0.95, seen) * self._panel_mm[1:][self._hinge]
        self._on_mm = np.column_stack([on, across * wide_mm, np.zeros(seen)])
        self.rest_mm = self.shape(np.zeros((1, count))).reshape(-1, 3)

    def deflection(self, kpa: Floats) -> Floats:
        load = kpa / self.high_kpa
        return load * (1 + self._round) / (self._round + np.abs(load))

    def shape(self, deflection: Floats) -> Floats:
        times, count = deflection.shape
        angle = self._sags + deflection * self._fold
        drawn_mm = self._drawn_mm * deflection**2 / (1 + 0.3 * deflection**2)
        foot = np.zeros((times, 3))
        heading = np.broadcast_to(np.eye(3), (times, 3, 3))
        out = np.empty((times, len(self._hinge), 3))
        for c in range(count):
            foot = foot + heading[:, :, 0] * (self._panel_mm[c] - drawn_mm[:, c, None])
            heading = heading @ turns(angle[:, c, None] * self._axis[c])[0]
            at = np.flatnonzero(self._hinge == c)
            out[:, at] = foot[:, None] + np.einsum("tij,mj->tmi", heading, self._on_mm[at])
        return out.reshape(times, -1)
