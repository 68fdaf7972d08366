"""Hysteresis: at one pressure the surface lies lower on the way up than on the way down, whatever the speed."""

import numpy as np

from labrig.arrays import Floats
from labrig_drivers.simulated.hidden._base import Hidden


class Hysteresis(Hidden):
    """Bouc-Wen (Bouc 1967, Wen 1976), or a Preisach plane of relays (Preisach 1935), by chance.

    `strength`: half the width of the loop as a part of the highest pressure.
    """

    name = "hysteresis"
    natural = 0.03

    def prepare(self) -> None:
        random = self.setting.random
        self.share = self.setting.varied(0.15)
        self.preisach = bool(random.random() < 0.5)
        self.power = random.uniform(1.2, 2.0)
        self.yield_part = random.uniform(0.10, 0.22)
        if self.preisach:
            self._relays(random.uniform(0.10, 0.18))

    def _relays(self, spread: float) -> None:
        """Relays switch up at `high`, down at `low`; most of them are narrow. Their mean branch is taken
        off.
        """
        level = np.linspace(-0.15, 1.15, 40)
        high, low = (x.ravel() for x in np.meshgrid(level, level, indexing="ij"))
        keep = high > low
        self.high, self.low = high[keep], low[keep]
        weight = np.exp(-(((self.high - self.low - 0.12) / spread) ** 2))
        self.relay_weight = weight / weight.sum()
        self.level = np.linspace(-0.2, 1.2, 281)
        rising = (self.high[:, None] < self.level).T @ self.relay_weight
        falling = (self.low[:, None] < self.level).T @ self.relay_weight
        self.branch = rising + falling - 1.0
        self.loop = float(np.max(falling - rising))

    def load(self, step_s: Floats, pressure_kpa: Floats) -> Floats:
        """The membrane's pressure less the restoring force that hangs behind it."""
        del step_s
        x = pressure_kpa / self.setting.max_kpa
        behind = self._preisach(x) if self.preisach else self._bouc_wen(x)
        return pressure_kpa - self.strength * self.share * self.setting.max_kpa * behind

    def _bouc_wen(self, x: Floats) -> Floats:
        z = self.memory.get("z", np.zeros(self.setting.chambers))
        last = self.memory.get("x", np.zeros(self.setting.chambers))
        out = np.empty_like(x)
        for k in range(len(x)):
            change = x[k] - last
            parts = int(np.ceil(np.abs(change).max() / 0.02)) or 1
            for _ in range(parts):
                dx = change / parts
                z = (
                    z
                    + (dx - np.abs(z) ** self.power * 0.5 * (dx + np.abs(dx) * np.sign(z))) / self.yield_part
                )
                z = np.clip(z, -1.0, 1.0)
            out[k], last = z, x[k]
        self.memory["z"], self.memory["x"] = z, last
        return out

    def _preisach(self, x: Floats) -> Floats:
        on = self.memory.get("on")
        if on is None:  # demagnetised: relays that lie symmetrically about zero load start half up, half down
            on = np.repeat((self.high + self.low < 0.0)[:, None], self.setting.chambers, axis=1)
        out = np.empty_like(x)
        last = self.memory.get("value", np.zeros(self.setting.chambers))
        previous = self.memory.get("x", np.full(self.setting.chambers, np.nan))
        for k in range(len(x)):
            if not np.allclose(x[k], previous, rtol=0.0, atol=1e-7):
                on = (on | (x[k] > self.high[:, None])) & ~(x[k] < self.low[:, None])
                branch = np.interp(x[k], self.level, self.branch)
                last = -(2.0 * (self.relay_weight @ on) - 1.0 - branch) / self.loop
                previous = x[k]
            out[k] = last
        self.memory.update(on=on, value=last, x=previous)
        return out
