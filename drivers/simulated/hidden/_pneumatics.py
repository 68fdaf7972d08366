"""Effects of the air supply: what arrives in a chamber is not what was commanded."""

import numpy as np

from drivers.simulated.hidden._base import Array, Hidden


class Regulator(Hidden):
    """A pressure sensor that is off, S-shaped and different per channel, so that the loop settles elsewhere.

    `strength`: the typical error of span, as a part of the pressure.
    """

    name = "regulator"
    natural = 0.03

    def prepare(self) -> None:
        random, count = self.setting.random, self.setting.chambers
        self.span = random.choice([-1.0, 1.0]) * self.setting.varied(0.35)
        self.bend = 0.25 * random.normal(size=count)
        self.zero = 0.08 * random.normal(size=count)

    def set_point(self, target_kpa: Array) -> Array:
        """Pressure at which the faulty sensor reads the target; a vented line is open to the room."""
        x = target_kpa / self.setting.max_kpa
        error = self.span * x + self.bend * np.sin(2.0 * np.pi * x) / np.pi + self.zero
        return np.where(target_kpa == 0.0, 0.0, target_kpa + self.strength * self.setting.max_kpa * error)


class Leak(Hidden):
    """Each chamber is shut in once it has reached its pressure, and loses air through an orifice.

    Flow goes with the root of the pressure, so the root falls linearly. `strength`: part of the highest
    pressure lost in the first 10 s at the highest pressure.
    """

    name = "leak"
    natural = 0.05

    def prepare(self) -> None:
        self.share = self.setting.varied(0.4)
        self.shut_after_s = 0.8

    def line(self, since_s: Array, step_s: Array, pressure_kpa: Array) -> Array:
        """What is left in the chambers."""
        del step_s
        shut_s = np.maximum(since_s - self.shut_after_s, 0.0)[:, None]
        rate = self.strength * self.share * np.sqrt(self.setting.max_kpa) / 20.0
        left = np.maximum(np.sqrt(np.abs(pressure_kpa)) - rate * shut_s, 0.0)
        return np.sign(pressure_kpa) * left**2


class Delay(Hidden):
    """A long thin tube and a soft chamber: two volumes that fill one after the other.

    `strength`: time constant of each, s.
    """

    name = "delay"
    natural = 0.5

    def prepare(self) -> None:
        self.share = self.setting.varied(0.15)

    def line(self, since_s: Array, step_s: Array, pressure_kpa: Array) -> Array:
        """Two lags in series."""
        del since_s
        first, second = self.memory.get("volumes", np.zeros((2, self.setting.chambers)))
        out = np.empty_like(pressure_kpa)
        lag = np.maximum(self.strength * self.share, 1e-3)
        keep = np.exp(-step_s[:, None] / lag)
        for k in range(step_s.size):
            before = first
            first = pressure_kpa[k] + (first - pressure_kpa[k]) * keep[k]
            rest = step_s[k] / lag * keep[k]
            second = (
                pressure_kpa[k] + (second - pressure_kpa[k]) * keep[k] + (before - pressure_kpa[k]) * rest
            )
            out[k] = second
        self.memory["volumes"] = np.stack([first, second])
        return out
