"""Rigs of the seventh portion that are seen by cameras in space: an auger and a spine."""

import numpy as np

from labrig.arrays import Floats
from labrig.bench._nature import Rig
from labrig.bench.development.rigs._common import chambers, markers, turns


class Auger(Rig):
    """An auger: in each section three tubes, wound with fibres, get longer, bend it by their sum, and twist it.

    J. Bishop-Moser, S. Kota, Design and modeling of generalized fiber-reinforced pneumatic soft actuators, IEEE Trans.
    Robotics 31, 2015. A section is a helix; tubes give way late, when the fibres lie tight, and level off.
    """

    kind = "auger"

    def __init__(self, random: np.random.Generator) -> None:
        sections, rings, seen = (int(random.integers(*ends)) for ends in ((1, 4), (2, 5), (3, 5)))
        self._sections, self._rings, count = sections, rings, 3 * sections
        self.chambers = chambers(count)
        self.high_kpa = random.uniform(60, 180) * random.uniform(0.92, 1.08, count)
        self.marker_names, self.observables = markers(sections * rings * seen)
        self.noise = float(random.uniform(0.08, 0.2))
        self._long_mm = random.uniform(60, 120, sections)
        around = 2 * np.pi * np.arange(seen) / seen + random.normal(0, 0.1, seen)
        self._ring_mm = random.uniform(14, 24) * np.column_stack([np.cos(around), np.sin(around), 0 * around])
        faces = 2 * np.pi * np.arange(3) / 3 + random.normal(0, 0.1, (sections, 3))
        bends = np.deg2rad(random.uniform(25, 55)) * random.uniform(0.85, 1.15, (sections, 3))
        hand = random.choice([-1.0, 1.0], (sections, 3))  # of the fibres
        twists = np.deg2rad(random.uniform(15, 60)) * hand * random.uniform(0.7, 1.3, (sections, 3))
        self._turns_rad = np.stack([-bends * np.sin(faces), bends * np.cos(faces), twists], axis=2)
        self._grows = random.uniform(0.05, 0.15) * random.uniform(0.8, 1.2, (sections, 3))
        self._late, self._steep = random.uniform(0.25, 0.5, count), random.uniform(1.5, 2.5, count)
        self.rest_mm = self.shape(np.zeros((1, count))).reshape(-1, 3)

    def deflection(self, kpa: Floats) -> Floats:
        load = kpa / self.high_kpa
        before, late = np.tanh(self._steep * self._late), np.abs(load) - self._late
        size = np.tanh(self._steep * late) + before
        return np.sign(load) * size / (np.tanh(self._steep * (1 - self._late)) + before)

    def shape(self, deflection: Floats) -> Floats:
        foot, frame = np.zeros((len(deflection), 3)), np.broadcast_to(np.eye(3), (len(deflection), 3, 3))
        places = []
        for k in range(self._sections):
            own = deflection[:, 3 * k : 3 * k + 3]
            longer = 0.5 + np.log1p(np.exp(np.clip(2 * own @ self._grows[k], -40, 40))) / (2 * np.log(2))
            piece = np.zeros_like(foot)
            piece[:, 2] = self._long_mm[k] * longer / self._rings
            turn, bow = turns(own @ self._turns_rad[k] / self._rings)
            for _ in range(self._rings):
                foot = foot + np.einsum("txy,tyz,tz->tx", frame, bow, piece)
                frame = frame @ turn
                places.append(foot[:, None] + np.einsum("txy,my->tmx", frame, self._ring_mm))
        return np.concatenate(places, axis=1).reshape(len(deflection), -1)


class Spine(Rig):
    """A spine: between stiff plates three folded bellows pull together with vacuum, and part a little by pressure.

    M. A. Robertson, J. Paik, New soft robots really suck: vacuum-powered systems empower diverse capabilities, Science
    Robotics 2, 2017. Their folds buckle at some vacuum, where they give way most.
    """

    kind = "spine"

    def __init__(self, random: np.random.Generator) -> None:
        self._plates, seen = int(random.integers(2, 5)), int(random.integers(4, 7))
        count = 3 * self._plates
        self.chambers = chambers(count)
        self.high_kpa = random.uniform(12, 30) * random.uniform(0.94, 1.06, count)
        self._low_kpa = -self.high_kpa * random.uniform(0.8, 1.3)
        self.marker_names, self.observables = markers(self._plates * seen)
        self.noise = float(random.uniform(0.04, 0.12))
        self._high_mm, self._wide_mm = random.uniform(25, 45, self._plates), random.uniform(20, 35)
        around = 2 * np.pi * np.arange(seen) / seen + random.uniform(0, 1, seen)
        out_mm = self._wide_mm * random.uniform(0.8, 1.5, seen)
        up_mm = random.uniform(-3, 6, seen)  # some stand on pins
        self._pins_mm = np.column_stack([out_mm * np.cos(around), out_mm * np.sin(around), up_mm])
        self._faces = random.uniform(0, 2, self._plates)[:, None] + 2 * np.pi * np.arange(3) / 3
        self._opens = random.uniform(0.12, 0.25) * random.uniform(0.9, 1.1, count)
        self._buckles, self._steep = random.uniform(0.1, 0.7, count), random.uniform(1.0, 3.0, count)
        self.rest_mm = self.shape(np.zeros((1, count))).reshape(-1, 3)

    @property
    def low_kpa(self) -> Floats:
        return self._low_kpa

    def deflection(self, kpa: Floats) -> Floats:
        load = kpa / self.high_kpa
        none = np.arcsinh(self._steep * self._buckles)
        whole = np.arcsinh(self._steep * (1 + self._buckles)) - none
        return (np.arcsinh(self._steep * (load + self._buckles)) - none) / whole

    def shape(self, deflection: Floats) -> Floats:
        foot, frame = np.zeros((len(deflection), 3)), np.broadcast_to(np.eye(3), (len(deflection), 3, 3))
        places = []
        for k in range(self._plates):
            own = slice(3 * k, 3 * k + 3)
            parts_mm = self._high_mm[k] * self._opens[own] * deflection[:, own]
            faces = np.stack([np.sin(self._faces[k]), -np.cos(self._faces[k]), np.zeros(3)], axis=1)
            turn, bow = turns(parts_mm @ faces * 2 / (3 * self._wide_mm))
            piece = np.zeros_like(foot)
            # plates meet in the end
            piece[:, 2] = self._high_mm[k] * np.exp(parts_mm.mean(axis=1) / self._high_mm[k])
            foot = foot + np.einsum("txy,tyz,tz->tx", frame, bow, piece)
            frame = frame @ turn
            places.append(foot[:, None] + np.einsum("txy,my->tmx", frame, self._pins_mm))
        return np.concatenate(places, axis=1).reshape(len(deflection), -1)
