"""Effects that no list of usual suspects has: for finding out whether an unknown cause is called unknown."""

import numpy as np

from drivers.simulated.hidden._base import Array, Hidden


class Wrinkle(Hidden):
    """The skin buckles along a seam when two neighbouring chambers differ enough, and lies flat otherwise.

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


class Softening(Hidden):
    """Mullins effect (1969): rubber is softer below the largest stretch that it has ever seen.

    `strength`: part of the stiffness lost by a first full inflation.
    """

    name = "softening"
    natural = 0.05

    def deflect(self, time_s: Array, step_s: Array, deflection_mm: Array) -> Array:
        """Deflections of the damaged rubber."""
        del time_s, step_s
        largest = self.memory.get("largest", np.zeros(self.setting.chambers))
        reached = np.maximum(np.maximum.accumulate(np.abs(deflection_mm), axis=0), largest)
        self.memory["largest"] = reached[-1]
        unused = 1.0 - (np.abs(deflection_mm) / np.maximum(reached, 1e-9)) ** 2
        return deflection_mm * (1.0 + self.strength * (reached / self.setting.largest_mm) * unused)


class Supply(Hidden):
    """The pump sags: the more all chambers ask for together, the less each of them gets, with a knee.

    `strength`: part of the pressure missing when every chamber is full.
    """

    name = "supply"
    natural = 0.05

    def set_point(self, target_kpa: Array) -> Array:
        """What the sagging supply delivers."""
        demand = np.abs(target_kpa).sum() / self.setting.max_kpa.sum()
        short = np.logaddexp(0.0, (demand - 0.45) / 0.06) * 0.06 / 0.55
        return target_kpa * (1.0 - self.strength * short)


class Lens(Hidden):
    """Uncorrected radial distortion of the cameras: displacement grows with the cube of the distance.

    `strength`: distortion 150 mm from the optical axis, mm.
    """

    name = "lens"

    def prepare(self) -> None:
        self.axis_mm = self.setting.body.rest_mm.mean(axis=0) + self.setting.random.normal(size=3) * 25.0

    def see(self, time_s: Array, tilt_deg: Array, deflection_mm: Array, position_mm: Array) -> Array:
        """Positions through the lens."""
        del time_s, tilt_deg, deflection_mm
        arm = (position_mm - self.axis_mm) * np.array([1.0, 0.0, 1.0])
        distance = np.linalg.norm(arm, axis=-1, keepdims=True)
        return position_mm + self.strength * arm * distance**2 / 150.0**3
