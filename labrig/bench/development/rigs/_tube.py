"""A peristaltic tube: ring chambers one after another squeeze it, and rings of markers ride on its outside."""

import numpy as np

from labrig.arrays import Floats
from labrig.bench._nature import Rig
from labrig.bench.development.rigs._common import chambers, markers


class Tube(Rig):
    """Rings that bulge outwards, late at first and little in the end, and shorten the tube as they do.

    A bulge carries all that lies beyond it towards the base, so that far markers show every chamber.
    """

    kind = "tube"

    def __init__(self, random: np.random.Generator) -> None:
        count = int(random.integers(4, 9))
        self.chambers = chambers(count)
        self.high_kpa = random.uniform(40, 90) * random.uniform(0.92, 1.08, count)
        stations, each = int(random.integers(5, 9)), int(random.integers(3, 5))
        self.marker_names, self.observables = markers(stations * each)
        self.noise = float(random.uniform(0.06, 0.12))
        pitch_mm, radius_mm = random.uniform(18, 28), random.uniform(16, 26)
        length_mm = pitch_mm * count
        up_mm = np.repeat((np.arange(stations) + 0.7) / stations * length_mm, each)
        up_mm = up_mm + random.normal(0, 1.5, len(up_mm))
        turn = np.tile(np.arange(each) * 2 * np.pi / each, stations) + random.normal(0, 0.1, len(up_mm))
        self._out = np.stack([np.cos(turn), np.sin(turn)], axis=1)
        self.rest_mm = np.column_stack([radius_mm * self._out, up_mm])
        centre_mm = pitch_mm * (np.arange(count) + 0.5)
        width_mm = pitch_mm * random.uniform(0.4, 0.65)
        share = (up_mm - centre_mm[:, None]) / width_mm  # (C, M)
        bulge_mm = radius_mm * random.uniform(0.25, 0.5, count)[:, None]
        self._bulge_mm = bulge_mm * np.exp(-0.5 * share**2)
        short_mm = pitch_mm * random.uniform(0.06, 0.2, count)[:, None]
        self._short_mm = short_mm * 0.5 * (1 + np.tanh(share))
        self._uneven = random.normal(0, 0.06, (count, 2)) * pitch_mm  # a ring that is stiffer on one side
        self._beyond = np.maximum(up_mm - centre_mm[:, None], 0.0) / length_mm
        self._steep = random.uniform(0.8, 2.6, count)
        self._turns_at = random.uniform(0.3, 0.5, count)

    def deflection(self, kpa: Floats) -> Floats:
        def bulge(load: Floats) -> Floats:
            return np.tanh(self._steep * (load - self._turns_at)) + np.tanh(self._steep * self._turns_at)

        return bulge(kpa / self.high_kpa) / bulge(np.ones(len(self._steep)))

    def shape(self, deflection: Floats) -> Floats:
        assert self.rest_mm is not None
        radial = (deflection @ self._bulge_mm)[..., None] * self._out
        swung = np.einsum("tc,cm,cx->tmx", deflection, self._beyond, self._uneven)
        down = -((deflection**2) @ self._short_mm)[..., None]
        moved = np.concatenate([radial + swung, down], axis=2)
        return (self.rest_mm + moved).reshape(len(deflection), -1)
