"""Wrinkle (on no list of usual suspects): the skin buckles between two chambers that differ."""

import numpy as np

from drivers.simulated.hidden._base import Array, Hidden


class Wrinkle(Hidden):
    """The skin buckles along a seam when two chambers differ enough, and lies flat otherwise.

    `strength`: depth of the wrinkle, mm.
    """

    name = "wrinkle"

    def prepare(self) -> None:
        body, random = self.setting.body, self.setting.random
        first, second = random.permutation(self.setting.chambers)[:2]
        self.difference = np.zeros(self.setting.chambers)
        self.difference[first], self.difference[second] = 1.0, -1.0
        self.threshold_mm = 0.2 * float(self.setting.largest_mm.mean()) * random.normal()
        centre = body.rest_mm[int(random.integers(len(body.rest_mm)))]
        distance = np.linalg.norm(body.rest_mm - centre, axis=1)
        self.pattern = np.cos(distance / 35.0) * np.exp(-((distance / 110.0) ** 2))

    def see(self, time_s: Array, tilt_deg: Array, deflection_mm: Array, position_mm: Array) -> Array:
        """Positions on the wrinkled skin."""
        del time_s, tilt_deg
        open_part = 1.0 / (1.0 + np.exp(-(deflection_mm @ self.difference - self.threshold_mm) / 2.5))
        depth = self.strength * open_part[:, None] * self.pattern
        return position_mm + depth[..., None] * self.setting.body.normal
