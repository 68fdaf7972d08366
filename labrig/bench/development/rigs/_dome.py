"""A round membrane clamped at its rim, blown up to a dome by one or two chambers under it."""

import numpy as np

from labrig.arrays import Floats
from labrig.bench._nature import Rig
from labrig.bench.development.rigs._common import chambers, cubic_membrane, markers


class Dome(Rig):
    """A clamped membrane (H. Hencky, Z. Mathematik und Physik 63, 1915): its height goes with the load's cube root.

    Of two chambers one fills the middle, the other a ring around it or one half: both lift the same markers. What is
    already high is pushed along its own normal, so that the two do not simply add up.
    """

    kind = "dome"

    def __init__(self, random: np.random.Generator) -> None:
        count = int(random.integers(1, 3))
        self.chambers = chambers(count)
        self.high_kpa = random.uniform(8, 25) * random.uniform(0.9, 1.1, count)
        radius_mm = random.uniform(45, 80)
        flat = _grid(int(random.integers(24, 36)), random)
        self.marker_names, self.observables = markers(len(flat))
        self.noise = float(random.uniform(0.06, 0.12))
        self.rest_mm = np.column_stack([radius_mm * flat, np.zeros(len(flat))])
        far = np.linalg.norm(flat, axis=1)
        dome = 1 - far**2
        second = _ring(far, random) if random.random() < 0.5 else _half(flat, random)
        height_mm = radius_mm * random.uniform(0.2, 0.4, 2) * np.array([1.0, 0.6])
        self._lift_mm = (height_mm[:, None] * np.stack([dome, second]))[:count]
        self._outward = flat * (1 - far**2)[:, None] * random.uniform(0.3, 0.7) / radius_mm
        self._inflates = random.uniform(0.3, 0.8)
        self._radius_mm = radius_mm
        self._place = flat
        self._cubic = random.uniform(0.5, 0.93, count)

    def deflection(self, kpa: Floats) -> Floats:
        return cubic_membrane(kpa / self.high_kpa, self._cubic)

    def shape(self, deflection: Floats) -> Floats:
        assert self.rest_mm is not None
        height = deflection @ self._lift_mm  # (T, M)
        outward = (height**2)[..., None] * self._outward
        leaning = self._inflates * (height**2 / self._radius_mm)[..., None] * self._place
        aside = outward + leaning * (1 - np.sum(self._place**2, axis=1))[:, None]
        moved = np.concatenate([aside, height[..., None]], axis=2)
        return (self.rest_mm + moved).reshape(len(deflection), -1)


def _grid(count: int, random: np.random.Generator) -> Floats:
    """About `count` places (M, 2) of a square grid inside the unit circle, each a little off."""
    side = np.linspace(-1, 1, int(np.ceil(np.sqrt(count / 0.62))))
    places = np.stack(np.meshgrid(side, side), axis=-1).reshape(-1, 2) * 0.97
    places = places[np.linalg.norm(places, axis=1) < 0.93]
    places = places + random.normal(0, 0.02, places.shape)
    return places / np.maximum(np.linalg.norm(places, axis=1) / 0.95, 1.0)[:, None]


def _ring(far: Floats, random: np.random.Generator) -> Floats:
    """How far a ring around the middle lifts the places at a share `far` of the radius."""
    out = np.exp(-0.5 * ((far - random.uniform(0.5, 0.65)) / 0.22) ** 2) * (1 - far**4)
    return out / out.max()


def _half(flat: Floats, random: np.random.Generator) -> Floats:
    """How far a chamber under one half lifts the places."""
    angle = random.uniform(0, 2 * np.pi)
    along = flat @ np.array([np.cos(angle), np.sin(angle)])
    out = (1 - np.sum(flat**2, axis=1)) / (1 + np.exp(-along / 0.25))
    return out / out.max()
