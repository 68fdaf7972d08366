"""Hysteresis of the ninth portion: relays, a hysteretic spring, plays, a path's length, slipping elements."""

import numpy as np

from labrig.arrays import Floats
from labrig.bench._nature import Law, Path, Setting
from labrig.bench.development._places import alone, columns, full, span
from labrig.bench.development._story import finely, plays


class PreisachRelays(Law):
    """Preisach's relays: each goes on at one pressure and off at a lower one; the wall sums over them.

    F. Preisach, Über die magnetische Nachwirkung, Zeitschrift für Physik 94, 1935; in the form of I. D.
    Mayergoyz, Mathematical Models of Hysteresis, Springer, 1991: an integral of weights times relays over the
    half plane. What is added is the sum, less the middle of its rising and its falling branch, which belongs
    to the elastic curve.
    """

    effect = "hysteresis"

    def __init__(self, setting: Setting) -> None:
        super().__init__(setting)
        random, count = setting.random, len(self.rig.chambers)
        relays = 300
        wide = np.minimum(random.exponential(random.uniform(0.25, 0.4), relays), 0.95)
        self._off = 0.01 + (1.05 - wide) * random.beta(1.2, 1.2, relays)
        self._on = self._off + wide
        self._weight = random.gamma(2.0, 1.0, relays)
        self._weight /= self._weight.sum()
        self._share = random.uniform(0.3, 0.55) * random.uniform(0.8, 1.2, count)

    def wall(self, path: Path, kpa: Floats, deflection: Floats, strength: float) -> Floats:
        load = full(self.rig, kpa)
        drive = np.concatenate([load, -load], axis=1)  # vacuum has relays that mirror those of pressure
        state = np.zeros((drive.shape[1], len(self._on)), dtype=bool)
        out = np.empty_like(drive)
        for i, now in enumerate(drive):
            on, stays = now[:, None] >= self._on, now[:, None] > self._off
            state = on | (state & stays)
            out[i] = (state - (on + 1.0 * stays) / 2) @ self._weight
        count = load.shape[1]
        return deflection + strength * self._share * (out[:, :count] - out[:, count:])


class BoucWenSpring(Law):
    """The hysteretic spring of Bouc and Wen: a part of the restoring force turns with the motion.

    Y.-K. Wen, Method for random vibration of hysteretic systems, J. Engineering Mechanics Division ASCE 102,
    1976: dz = A dx - beta |dx| |z|^(n-1) z - gamma dx |z|^n. Here x is the share of full pressure, and z is 1
    at its largest.
    """

    effect = "hysteresis"

    def __init__(self, setting: Setting) -> None:
        super().__init__(setting)
        random, count = setting.random, len(self.rig.chambers)
        self._steep = 1 / random.uniform(0.2, 0.4)
        self._beta = random.uniform(0.5, 0.9)
        self._power = random.uniform(1.0, 2.0)
        self._share = random.uniform(0.06, 0.1) * random.uniform(0.8, 1.2, count)

    def wall(self, path: Path, kpa: Floats, deflection: Floats, strength: float) -> Floats:
        step, _, where = finely(path, full(self.rig, kpa), 0.02)
        z = np.zeros(step.shape[1])
        out = np.empty_like(step)
        for i, dx in enumerate(step):
            size = np.abs(z) ** self._power
            turn = self._beta * np.sign(dx * z) + 1 - self._beta
            z = z + self._steep * dx * (1 - turn * size)
            out[i] = z
        return deflection - strength * self._share * out[where]


class PrandtlIshlinskiiPlays(Law):
    """Plays of Prandtl and Ishlinskii, generalised: the wall trails its elastic curve by many plays.

    M. Al Janaideh, S. Rakheja, C.-Y. Su, An analytical generalized Prandtl-Ishlinskii model inversion for
    hysteresis compensation in micropositioning control, IEEE/ASME Transactions on Mechatronics 16, 2011. The
    density of the plays falls exponentially with their width; the envelope is the elastic curve of the wall.
    """

    effect = "hysteresis"

    def __init__(self, setting: Setting) -> None:
        super().__init__(setting)
        random, count = setting.random, len(self.rig.chambers)
        self._half = np.linspace(0.03, random.uniform(0.3, 0.45), 10)
        density = np.exp(-random.uniform(1.0, 6.0) * self._half)
        self._weight = density / density.sum()
        self._share = random.uniform(0.25, 0.5) * random.uniform(0.8, 1.2, count)

    def wall(self, path: Path, kpa: Floats, deflection: Floats, strength: float) -> Floats:
        half = np.repeat(self._half[:, None], deflection.shape[1], axis=1)
        trails = np.einsum("tnc,n->tc", plays(deflection, half), self._weight)
        return deflection + strength * self._share * (trails - deflection)


class EndochronicBody(Law):
    """The endochronic theory: the body forgets by the length of the path that its shape has gone.

    K. C. Valanis, A theory of viscoplasticity without a yield surface, Archives of Mechanics 23, 1971: a back
    stress, the integral of exp(-alpha (z - z')) dx(z'), where the intrinsic time z is the path's length. A
    law of Duhem's kind in which any motion of the body, by whichever chamber, wipes out what was remembered.
    """

    effect = "hysteresis"

    def __init__(self, setting: Setting) -> None:
        super().__init__(setting)
        random, rig = setting.random, self.rig
        whole = np.linalg.norm(alone(rig), axis=1).mean()
        self._alpha = 1 / (whole * random.uniform(0.25, 0.5))
        self._share = random.uniform(0.2, 0.35)

    def seen(self, path: Path, deflection: Floats, values: Floats, strength: float) -> Floats:
        step = np.diff(values, axis=0, prepend=self.rig.at_rest[None])
        length = self._alpha * np.linalg.norm(step, axis=1)
        fades = np.exp(-length)
        grows = np.where(length > 1e-9, -np.expm1(-length) / np.maximum(length, 1e-9), 1.0)
        back = np.zeros(values.shape[1])
        out = np.empty_like(values)
        for i in range(len(values)):
            back = fades[i] * back + grows[i] * step[i]
            out[i] = back
        return values - strength * self._share * out


class SlippingElementsAtPlaces(Law):
    """Iwan's elements that stick and slip, side by side at each place: they yield one after another.

    W. D. Iwan, A distributed-element model for hysteresis and its steady-state dynamic response, J. Applied
    Mechanics 33, 1966; also called the Maxwell-slip model. Each place has as much of it as its rubber is
    filled there.
    """

    effect = "hysteresis"

    def __init__(self, setting: Setting) -> None:
        super().__init__(setting)
        random, rig = setting.random, self.rig
        count = len(rig.observables)
        way = np.maximum(np.abs(alone(rig)).max(axis=0), 0.05 * span(rig))
        self._yields = np.linspace(0.05, random.uniform(0.35, 0.55), 6)[:, None] * way
        filled = random.lognormal(0.0, 0.4, count)
        for row in columns(rig):  # all axes of a marker alike
            filled[row[row >= 0]] = random.lognormal(0.0, 0.4)
        self._share = random.uniform(0.15, 0.3) * filled / np.sqrt(np.mean(filled**2))

    def seen(self, path: Path, deflection: Floats, values: Floats, strength: float) -> Floats:
        step = np.diff(values, axis=0, prepend=self.rig.at_rest[None])
        held = np.zeros_like(self._yields)
        out = np.empty_like(values)
        for i in range(len(values)):
            held = np.clip(held + step[i], -self._yields, self._yields)
            out[i] = held.mean(axis=0)
        return values - strength * self._share * out
