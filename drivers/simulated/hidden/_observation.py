"""Effects of weight, shape and measurement: they move what is seen, not what the chambers do."""

import numpy as np

from drivers.simulated.hidden._base import Array, Hidden


class Gravity(Hidden):
    """The sheet sags under its own weight, most where it is softest: a membrane far out is stiff.

    The sag follows the tangent compliance of the chambers' law, along gravity in the frame of the base, which
    may be tilted. `strength`: sag of a vented patch, mm.
    """

    name = "gravity"

    def see(self, time_s: Array, tilt_deg: Array, deflection_mm: Array, position_mm: Array) -> Array:
        """Positions with the sag."""
        del time_s
        body = self.setting.body
        soft = (1.0 / (1.0 + 3.0 * (deflection_mm / body.limit_mm) ** 2)) @ body.weight.T
        tilt = np.deg2rad(tilt_deg)
        down = np.stack([0.0 * tilt, -np.sin(tilt), -np.cos(tilt)], axis=-1)
        return position_mm + self.strength * soft[..., None] * down[:, None]


class RestShape(Hidden):
    """The shell was printed or mounted a little out of shape: a smooth bend along its normals.

    `strength`: typical deviation, mm.
    """

    name = "rest_shape"
    natural = 0.5

    def prepare(self) -> None:
        body, random = self.setting.body, self.setting.random
        centred = body.rest_mm - body.rest_mm.mean(axis=0)
        across, up = centred[:, 0] / 100.0, centred[:, 2] / 150.0
        terms = np.stack([across**2, up**2, across * up, up**3, across**2 * up, np.cos(2.0 * up)], axis=-1)
        bend = (terms - terms.mean(axis=0)) @ random.normal(size=terms.shape[1])
        self.bend = (bend / np.sqrt(np.mean(bend**2)))[:, None] * body.normal

    def see(self, time_s: Array, tilt_deg: Array, deflection_mm: Array, position_mm: Array) -> Array:
        """Positions on the shell as it is."""
        del time_s, tilt_deg, deflection_mm
        return position_mm + self.strength * self.bend


class Frame(Hidden):
    """A calibration wand held badly: the measuring frame is turned, shifted, and a little off in scale.

    `strength`: the turn, degrees; shift and scale go with it.
    """

    name = "frame"
    natural = 0.2

    def prepare(self) -> None:
        random = self.setting.random
        axis = random.normal(size=3)
        self.axis = axis / np.linalg.norm(axis)
        self.shift_mm = random.normal(size=3)
        self.scale = 1e-3 * random.normal()
        self.pivot_mm = self.setting.body.rest_mm.mean(axis=0) + random.normal(size=3) * 40.0

    def see(self, time_s: Array, tilt_deg: Array, deflection_mm: Array, position_mm: Array) -> Array:
        """Positions in the frame as it is (Rodrigues' rotation)."""
        del time_s, tilt_deg, deflection_mm
        angle = np.deg2rad(self.strength)
        arm = position_mm - self.pivot_mm
        along = (arm @ self.axis)[..., None] * self.axis
        turned = along + np.cos(angle) * (arm - along) + np.sin(angle) * np.cross(self.axis, arm)
        seen = self.pivot_mm + turned * (1.0 + self.scale * self.strength) + self.strength * self.shift_mm
        return np.asarray(seen, dtype=float)


class Drift(Hidden):
    """Everything warms up: first a Kelvin-type approach to the working temperature, then the day's wave.

    By chance the cameras' mount moves (all markers alike) or the silicone softens. `strength`: mm, or per
    cent of compliance, at the end of the warm-up.
    """

    name = "drift"
    natural = 0.5

    def prepare(self) -> None:
        random, duration = self.setting.random, self.setting.duration_s
        self.softens = bool(random.random() < 0.4)
        self.lag_s = duration * random.uniform(0.25, 0.8)
        self.wave_s, self.phase = duration * random.uniform(1.5, 3.0), random.uniform(0.0, 2.0 * np.pi)
        direction = random.normal(size=3)
        self.direction = direction / np.linalg.norm(direction)

    def warmth(self, time_s: Array) -> Array:
        """Temperature above the start, in parts of the warm-up, (T,)."""
        wave = np.sin(2.0 * np.pi * time_s / self.wave_s + self.phase) - np.sin(self.phase)
        return 1.0 - np.exp(-time_s / self.lag_s) + 0.15 * wave

    def deflect(self, time_s: Array, step_s: Array, deflection_mm: Array) -> Array:
        """Deflections of the warmer membrane."""
        del step_s
        if not self.softens:
            return deflection_mm
        return deflection_mm * (1.0 + 0.01 * self.strength * self.warmth(time_s)[:, None])

    def see(self, time_s: Array, tilt_deg: Array, deflection_mm: Array, position_mm: Array) -> Array:
        """Positions seen by cameras that have moved, and turned with it by a hair."""
        del tilt_deg, deflection_mm
        if self.softens:
            return position_mm
        moved = self.strength * self.warmth(time_s)[:, None, None]
        turned = np.cross(self.direction, position_mm - self.setting.body.rest_mm.mean(axis=0)) * 5e-4
        return np.asarray(position_mm + moved * (np.roll(self.direction, 1) + turned), dtype=float)


class MarkerSlip(Hidden):
    """One marker's glue lets go at some moment: it slides to another place within a second or two.

    `strength`: how far, mm.
    """

    name = "marker_slip"
    natural = 2.0

    def prepare(self) -> None:
        body, random = self.setting.body, self.setting.random
        self.marker = int(random.integers(len(body.rest_mm)))
        self.moment_s = self.setting.duration_s * random.uniform(0.3, 0.7)
        normal = body.normal[self.marker]
        way = random.normal(size=3)
        way -= (way @ normal) * normal
        self.way = way / np.linalg.norm(way)

    def see(self, time_s: Array, tilt_deg: Array, deflection_mm: Array, position_mm: Array) -> Array:
        """Positions with one marker slipped."""
        del tilt_deg, deflection_mm
        slipped = 0.5 * (1.0 + np.tanh(2.0 * (time_s - self.moment_s)))
        moved = position_mm.copy()
        moved[:, self.marker] += self.strength * slipped[:, None] * self.way
        return moved
