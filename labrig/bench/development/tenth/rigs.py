"""Rigs of the tenth portion: a carpet of cilia, a wheel whose rim is pushed about, a fan of ribs."""

import numpy as np
from scipy.special import lambertw

from labrig.arrays import Floats
from labrig.bench._nature import Rig
from labrig.bench.development.rigs._common import chambers, markers, turns


class Cilia(Rig):
    """A carpet of cilia: soft posts, thinner on one side, each of which bows over to its own side under pressure.

    E. Milana et al., Metachronal patterns in artificial cilia for low Reynolds number fluid propulsion, Science
    Advances 6, 2020. The thin side is a neo-Hookean wall in pure shear (R. S. Rivlin, Large elastic deformations of
    isotropic materials IV, Philosophical Transactions A 241, 1948): its load goes with the stretch less one over its
    cube, so it gives way the faster, the further it is. Full posts lift the soft floor around them a little.
    """

    kind = "cilia"

    def __init__(self, random: np.random.Generator) -> None:
        count = int(random.integers(3, 10))
        each = int(random.integers(3, min(5, 30 // count) + 1))
        self.chambers = chambers(count)
        self.high_kpa = random.uniform(40, 120) * random.uniform(0.95, 1.05, count)
        self.marker_names, self.observables = markers(count * each)
        self.noise = float(random.uniform(0.03, 0.1))
        self._tall_mm = random.uniform(28, 55) * random.uniform(0.95, 1.05, count)
        apart_mm = random.uniform(0.8, 1.2) * float(self._tall_mm.mean())
        row = np.arange(count) % 3
        line = np.arange(count) // 3
        feet = np.column_stack([row + 0.5 * (line % 2), 0.87 * line]) * apart_mm
        self._feet_mm = feet - feet.mean(axis=0) + random.normal(0, 0.03 * apart_mm, feet.shape)
        ways = random.uniform(0, 2 * np.pi) + random.uniform(0.1, 0.5) * np.arange(
            count
        )  # a little on from post to post
        self._ways = ways + random.normal(0, 0.1, count)
        self._bends = np.deg2rad(random.uniform(60, 115)) * random.uniform(0.9, 1.1, count)
        self._leans = np.deg2rad(random.normal(0, 3.0, (count, 2)))
        self._longer = random.uniform(0.04, 0.12)
        self._tapers = random.uniform(0.2, 0.6)  # tips bend less than feet
        self._place = np.linspace(0.35, 1.0, each)
        self._thick_mm = random.uniform(2.5, 4.5)
        self._side = random.uniform(0, 2 * np.pi, (count, each))
        self._lifts_mm = random.uniform(0.5, 2.0)
        near = np.sum((self._feet_mm[:, None] - self._feet_mm) ** 2, axis=2)
        self._floor = np.exp(-near / (2 * (0.8 * apart_mm) ** 2))
        self._most = random.uniform(1.8, 3.2) * random.uniform(0.95, 1.05, count)
        self.rest_mm = self.shape(np.zeros((1, count))).reshape(-1, 3)

    @staticmethod
    def _stretch(load: Floats) -> Floats:
        """The stretch s with s - s^-3 = load, by Newton's method from below, where it never goes too far."""
        out = np.where(load >= 0, 1.0, np.cbrt(1 / (1 + np.maximum(-load, 0.0))))
        for _ in range(12):
            out = out - (out - out**-3 - load) / (1 + 3 * out**-4)
        return out

    def deflection(self, kpa: Floats) -> Floats:
        return (self._stretch(self._most * kpa / self.high_kpa) - 1) / (self._stretch(self._most) - 1)

    def shape(self, deflection: Floats) -> Floats:
        times, count = deflection.shape
        part = np.linspace(0.0, 1.0, 8)[1:] - 1 / 14  # the middles of seven pieces up to a marker
        up = self._place[:, None] * part  # (each, 7)
        bent = np.concatenate([up, self._place[:, None]], axis=1)
        bent = (bent - 0.5 * self._tapers * bent**2) / (1 - 0.5 * self._tapers)
        angle = (deflection * self._bends)[..., None, None] * bent
        long_mm = self._tall_mm * (1 + self._longer * deflection)
        along = long_mm[..., None] * self._place
        out = along * np.sin(angle[..., :-1]).mean(axis=-1)
        high = along * np.cos(angle[..., :-1]).mean(axis=-1)
        end = angle[..., -1]
        before, beside = self._thick_mm * np.cos(self._side), self._thick_mm * np.sin(self._side)
        out, high = out + before * np.cos(end), high - before * np.sin(end)
        c, s = np.cos(self._ways)[:, None], np.sin(self._ways)[:, None]
        local = np.stack([c * out - s * beside, s * out + c * beside, high], axis=-1)
        lean = np.concatenate([self._leans, np.zeros((count, 1))], axis=1)
        local = np.einsum("cij,tcmj->tcmi", turns(lean)[0], local)
        floor = self._lifts_mm * (deflection**2 / (1 + 0.2 * deflection**2)) @ self._floor
        local[..., :2] += self._feet_mm[:, None]
        local[..., 2] += floor[..., None]
        return local.reshape(times, -1)


class Wheel(Rig):
    """A wheel: cells between a hub and a rim that hardly stretches push a part of it out, and draw in the rest.

    W. Soedel, Vibrations of Shells and Plates, Marcel Dekker, 1981: a ring bends in waves, the more easily the fewer
    they are, and goes along itself as it goes in and out. The cells push against a pocket of shut air, as in a tyre,
    whose pressure rises by a polytropic law (P. S. Els, B. Grobbelaar, Investigation of the time- and temperature
    dependency of hydro-pneumatic suspension systems, SAE 930265, 1993). Some are drawn in by vacuum too.
    """

    kind = "wheel"

    def __init__(self, random: np.random.Generator) -> None:
        count, seen = int(random.integers(5, 10)), int(random.integers(12, 31))
        self.chambers = chambers(count)
        self.high_kpa = random.uniform(20, 60) * random.uniform(0.95, 1.05, count)
        drawn = random.uniform(0.2, 0.6) if random.random() < 0.6 else 0.0
        self._low_kpa = 0.0 - drawn * self.high_kpa
        self.marker_names, self.observables = markers(seen)
        self.noise = float(random.uniform(0.06, 0.2))
        self._radius_mm = random.uniform(60, 120)
        wide_mm = self._radius_mm * random.uniform(0.3, 0.5)
        self._angle = 2 * np.pi * (np.arange(seen) + random.uniform(-0.2, 0.2, seen)) / seen
        self._across_mm = wide_mm * random.uniform(-0.5, 0.5, seen)
        cell = (
            random.uniform(0, 2 * np.pi)
            + 2 * np.pi * np.arange(count) / count
            + random.normal(0, 0.03, count)
        )
        self._wave = np.arange(7.0)
        felt = np.exp(-((self._wave / random.uniform(3.0, 4.5)) ** 2))  # a cell's push, in waves
        eased = felt / (1 + random.uniform(2e-4, 1.5e-3) * np.maximum(self._wave**2 - 1, 0.0) ** 2)
        eased[0] *= random.uniform(0.1, 0.3)  # the rim hardly stretches
        eased[1] *= random.uniform(0.5, 1.0)  # spokes hold it about the hub
        phase = self._wave[:, None] * cell
        push = self._radius_mm * random.uniform(0.12, 0.2) * random.uniform(0.9, 1.1, count)
        self._cosine = eased[:, None] * np.cos(phase) * push / eased.sum()
        self._sine = eased[:, None] * np.sin(phase) * push / eased.sum()
        off = random.normal(0, 0.15, count)  # cells push beside the middle of the rim's width
        canted = np.exp(2.5 * (np.cos(self._angle[:, None] - cell) - 1))
        self._cants = np.deg2rad(random.uniform(15, 30)) * canted * off
        self._oval = random.normal(0, 0.01, 2)
        self._stiffens = random.uniform(0.55, 0.75) * random.uniform(0.96, 1.04, count)
        self._squeezed, self._power = random.uniform(0.35, 0.55), random.uniform(1.1, 1.35)
        self.rest_mm = self.shape(np.zeros((1, count))).reshape(-1, 3)

    @property
    def low_kpa(self) -> Floats:
        return self._low_kpa

    def _needs(self, deflection: Floats) -> Floats:
        """The share of the full pressure for a deflection: a spring, and the pocket of air that it squeezes."""
        air = (1 - self._squeezed * deflection) ** -self._power - 1
        full = (1 - self._squeezed) ** -self._power - 1
        return (1 - self._stiffens) * deflection + self._stiffens * air / full

    def deflection(self, kpa: Floats) -> Floats:
        load = kpa / self.high_kpa
        low = np.minimum(load, 0.0) / (1 - self._stiffens)  # what the spring alone would do
        high = np.full_like(load, 0.999999 / self._squeezed)
        for _ in range(56):
            middle = 0.5 * (low + high)
            over = self._needs(middle) > load
            low, high = np.where(over, low, middle), np.where(over, middle, high)
        return np.where(load == 0, 0.0, 0.5 * (low + high))

    def shape(self, deflection: Floats) -> Floats:
        a, b = deflection @ self._cosine.T, deflection @ self._sine.T  # (T, waves)
        c, s = np.cos(np.outer(self._wave, self._angle)), np.sin(np.outer(self._wave, self._angle))
        out = a @ c + b @ s
        over = np.concatenate([[0.0], 1 / self._wave[1:]])
        along = (b * over) @ c - (a * over) @ s
        turned = np.concatenate([[0.0], self._wave[1:] - over[1:]])
        # what a rim loses in radius because it is bent and does not stretch
        bent = np.sum((a**2 + b**2) * turned**2, axis=1, keepdims=True) / 2
        out = out - 0.5 * bent / self._radius_mm
        cant = deflection @ self._cants.T
        out = out + self._across_mm * np.sin(cant)
        oval = self._oval @ np.stack([np.cos(2 * self._angle), np.sin(2 * self._angle)])
        radius = self._radius_mm * (1 + oval) + out
        x = radius * np.cos(self._angle) - along * np.sin(self._angle)
        y = radius * np.sin(self._angle) + along * np.cos(self._angle)
        z = self._across_mm * np.cos(cant) - 0.1 * self._radius_mm * np.sin(cant)
        return np.stack([x, y, z], axis=-1).reshape(len(deflection), -1)


class Fan(Rig):
    """A fan: ribs from one pivot, one of them held, with folded bags between them that open it to both sides.

    The bags are of coated cloth, which gives way easily and then hardly: its load goes with the strain times an
    exponential of its square (H. Demiray, A note on the elasticity of soft biological tissues, J. Biomech. 5, 1972).
    A hem along the edge holds all of them when the fan is far open, and ribs bow from the fuller bag to the emptier.
    """

    kind = "fan"

    def __init__(self, random: np.random.Generator) -> None:
        count = int(random.integers(3, 9))
        each = 3 if count < 6 else 2
        self.chambers = chambers(count)
        self.high_kpa = random.uniform(15, 50) * random.uniform(0.95, 1.05, count)
        self.marker_names, self.observables = markers(count * (each + 1))
        self.noise = float(random.uniform(0.1, 0.3))
        self._held = int(random.integers(count // 3, count - count // 3 + 1))  # which of the count + 1 ribs
        self._long_mm = random.uniform(80, 150)
        self._folded = np.deg2rad(random.uniform(7, 13)) * random.uniform(0.9, 1.1, count)
        self._opens = np.deg2rad(random.uniform(70, 130)) / count * random.uniform(0.9, 1.1, count)
        self._hem = random.uniform(0.05, 0.15)
        self._bows = random.uniform(0.1, 0.25)
        self._cone = np.deg2rad(random.uniform(6, 18))
        self._puffs_mm = self._long_mm * random.uniform(0.08, 0.14) * random.uniform(0.9, 1.1, count)
        self._flat_mm = random.uniform(2, 5)
        self._ribs = np.delete(np.arange(count + 1), self._held)
        self._place = np.linspace(0.45, 0.97, each) + random.normal(0, 0.01, (count, each))
        self._top = random.uniform(0.55, 0.7)
        self._lifts = np.deg2rad(random.uniform(2, 6)) * random.choice([-1.0, 1.0])
        self._heading = random.uniform(0, 2 * np.pi)
        self._hardens = random.uniform(0.45, 0.9) * random.uniform(0.95, 1.05, count)
        self.rest_mm = self.shape(np.zeros((1, count))).reshape(-1, 3)

    def deflection(self, kpa: Floats) -> Floats:
        load, hard = kpa / self.high_kpa, self._hardens
        # d exp(hard (d^2 - 1)) = load, by Lambert's function
        square = np.real(lambertw(2 * hard * np.exp(2 * hard) * np.minimum(load**2, 1e200)))
        return np.sign(load) * np.sqrt(square / (2 * hard))

    def shape(self, deflection: Floats) -> Floats:
        times, count = deflection.shape
        every = deflection.mean(axis=1, keepdims=True)
        angle = self._folded + self._opens * deflection * (1 - self._hem * np.tanh(every))
        at = np.concatenate([np.zeros((times, 1)), np.cumsum(angle, axis=1)], axis=1)
        at = at - at[:, self._held, None] + self._heading
        own = np.pad(deflection * self._opens, ((0, 0), (1, 1)))
        bow = self._bows * (own[:, :-1] - own[:, 1:])  # the bag before a rib against the one after it
        bow[:, self._held] = 0.0
        far = self._place * self._long_mm
        rib = at[:, self._ribs, None] + bow[:, self._ribs, None] * self._place**2
        raised = (
            self._cone + self._lifts * every[..., None] * np.abs(self._ribs - self._held)[:, None] / count
        )
        level = far * np.cos(raised)
        ribs = np.stack([level * np.cos(rib), level * np.sin(rib), far * np.sin(raised)], axis=-1)
        middle = 0.5 * (at[:, :-1] + at[:, 1:])
        out_mm = self._top * self._long_mm
        puff = self._flat_mm + self._puffs_mm * deflection / (1 + 0.3 * np.abs(deflection))
        flat, high = out_mm * np.cos(self._cone), out_mm * np.sin(self._cone)
        flat, high = flat - puff * np.sin(self._cone), high + puff * np.cos(self._cone)
        bags = np.stack([flat * np.cos(middle), flat * np.sin(middle), high], axis=-1)
        return np.concatenate([ribs.reshape(times, -1), bags.reshape(times, -1)], axis=1)
