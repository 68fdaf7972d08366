"""Friction of the ninth portion: Dahl's, bristles, tendons round the bend, a sleeve, and places that drag."""

import numpy as np

from labrig.arrays import Floats
from labrig.bench._nature import Law, Path, Setting
from labrig.bench.development._places import columns, full, moved, positions, some, span
from labrig.bench.development._story import pauses, steps


class DahlFriction(Law):
    """Dahl's friction: after each turn the force rises to Coulomb's value within a short way.

    P. R. Dahl, A solid friction model, Aerospace Corporation, report TOR-0158(3107-18)-1, 1968: dF/dx = sigma
    (1 - F/Fc sgn dx). Each chamber has its own, and Fc grows with the pressure, as pressed seals do.
    """

    effect = "friction"

    def __init__(self, setting: Setting) -> None:
        super().__init__(setting)
        random, count = setting.random, len(self.rig.chambers)
        self._force = random.uniform(0.03, 0.06) * random.uniform(0.7, 1.3, count)
        self._by_load = random.uniform(0.0, 0.6)
        self._way = random.uniform(0.006, 0.025)  # of full pressure, in which the force rises

    def pressure(self, path: Path, kpa: Floats, strength: float) -> Floats:
        load = full(self.rig, kpa)
        step = steps(load)
        goes, fades = np.sign(step), np.exp(-np.abs(step) / self._way)
        part = np.zeros(load.shape[1])
        out = np.empty_like(load)
        for i in range(len(load)):
            part = goes[i] + (part - goes[i]) * fades[i]
            out[i] = part
        size = self._force * (1 + self._by_load * np.abs(load))
        return kpa - strength * size * out * self.rig.high_kpa


class LuGreBristles(Law):
    """The LuGre model: bristles bend and slip, with Stribeck's dip and some viscosity.

    C. Canudas de Wit, H. Olsson, K. J. Åström, P. Lischinsky, A new model for control of systems with
    friction, IEEE Transactions on Automatic Control 40, 1995: dz/dt = v - sigma0 |v| z / g(v), F = sigma0 z +
    sigma1 dz/dt + sigma2 v, g(v) = Fc + (Fs - Fc) exp(-(v/vs)^2). All chambers are of one make.
    """

    effect = "friction"

    def __init__(self, setting: Setting) -> None:
        super().__init__(setting)
        random, count = setting.random, len(self.rig.chambers)
        self._coulomb = random.uniform(0.03, 0.06) * random.uniform(0.9, 1.1, count)  # of the full motion
        self._stick = self._coulomb * random.uniform(1.1, 1.6)
        self._stribeck_per_s = random.uniform(0.02, 0.15)
        self._sigma0 = self._coulomb / random.uniform(0.005, 0.02)
        self._sigma1_s = random.uniform(0.005, 0.03)
        self._sigma2_s = random.uniform(0.001, 0.004)

    def wall(self, path: Path, kpa: Floats, deflection: Floats, strength: float) -> Floats:
        step = steps(full(self.rig, kpa))
        pause = np.maximum(pauses(path), 0.01)[:, None]
        speed = step / pause
        dip = np.exp(-((speed / self._stribeck_per_s) ** 2))
        slides = self._coulomb + (self._stick - self._coulomb) * dip
        aim = np.sign(step) * slides / self._sigma0
        fades = np.exp(-self._sigma0 * np.abs(step) / slides)  # the exact solution at a steady speed
        bristle = np.zeros(step.shape[1])
        out = np.empty_like(step)
        for i in range(len(step)):
            new = aim[i] + (bristle - aim[i]) * fades[i]
            bending = (new - bristle) / pause[i]
            out[i] = self._sigma0 * new + self._sigma1_s * bending + self._sigma2_s * speed[i]
            bristle = new
        return deflection - strength * out


class TendonsRoundTheBend(Law):
    """Tendons round the bend: along a curved guide tension falls by exp(-mu theta), either way.

    J. A. Eytelwein, Handbuch der Statik fester Körper, 1808; M. Kaneko, T. Yamashita, K. Tanie, Basic
    considerations on transmission characteristics for tendon drive robots, ICAR, 1991. theta grows with the
    bending of the whole body; after a turn the far end stands still until the tension has fallen by exp(-2 mu
    theta).
    """

    effect = "friction"

    def __init__(self, setting: Setting) -> None:
        super().__init__(setting)
        random, count = setting.random, len(self.rig.chambers)
        self._mu = random.uniform(0.05, 0.1)
        self._wrap = random.uniform(0.4, 1.0, count)
        self._bends = random.uniform(0.4, 1.2)

    def wall(self, path: Path, kpa: Floats, deflection: Floats, strength: float) -> Floats:
        theta = self._wrap + self._bends * np.clip(np.abs(deflection).mean(axis=1, keepdims=True), 0.0, 2.0)
        less = np.exp(-strength * self._mu * theta)
        low = np.minimum(deflection * less, deflection / less)
        high = np.maximum(deflection * less, deflection / less)
        far = np.zeros(deflection.shape[1])
        out = np.empty_like(deflection)
        for i in range(len(deflection)):
            far = np.minimum(np.maximum(far, low[i]), high[i])
            out[i] = far
        return out


class RubberSleeve(Law):
    """A rubber sleeve round the body: it holds the whole shape back, against the way it went last.

    P. Thirion, Les coefficients d'adhérence du caoutchouc, Revue générale du caoutchouc 23, 1946: 1/mu = a +
    b N, so that rubber's friction N / (a + b N) grows less than the load N: how tight the sleeve is, and how
    far it is filled.
    """

    effect = "friction"

    def __init__(self, setting: Setting) -> None:
        super().__init__(setting)
        random = setting.random
        self._tight = random.uniform(0.2, 0.6)
        self._a, self._b = 1.0, random.uniform(0.3, 1.2)
        self._back = random.uniform(0.06, 0.11) * span(self.rig)

    def seen(self, path: Path, deflection: Floats, values: Floats, strength: float) -> Floats:
        normal = self._tight + np.abs(deflection).mean(axis=1)
        size = strength * self._back * np.sqrt(values.shape[1]) * normal / (self._a + self._b * normal)
        step = np.diff(values, axis=0, prepend=self.rig.at_rest[None])
        far = np.linalg.norm(step, axis=1)
        moves = far > 2e-3 * span(self.rig) * np.sqrt(values.shape[1])
        last = np.maximum.accumulate(np.where(moves, np.arange(len(far)), -1))
        way = step[np.maximum(last, 0)] / np.maximum(far[np.maximum(last, 0)], 1e-12)[:, None]
        return values - size[:, None] * np.where(last[:, None] < 0, 0.0, way)


class DraggedPlaces(Law):
    """Dragged places: what rubs stands still until pulled by more than its friction, then follows.

    J. J. Moreau, Evolution problem associated with a moving convex set in a Hilbert space, J. Differential
    Equations 26, 1977: Coulomb's friction in the plane or in space, behind a spring. Some places only rub.
    """

    effect = "friction"

    def __init__(self, setting: Setting) -> None:
        super().__init__(setting)
        random, rig = setting.random, self.rig
        places = len(rig.marker_names) or len(rig.observables)
        self._length = some(random, places, 0.08, 0.16, random.uniform(0.5, 0.9)) * span(rig)

    def seen(self, path: Path, deflection: Floats, values: Floats, strength: float) -> Floats:
        rig = self.rig
        marked = columns(rig).max(initial=-1) >= 0
        points = positions(rig, values) if marked else values[..., None]
        stands = positions(rig, rig.at_rest[None])[0] if marked else rig.at_rest[:, None]
        length = strength * self._length
        out = np.empty_like(points)
        for i in range(len(points)):
            pull = points[i] - stands
            far = np.linalg.norm(pull, axis=1)
            follows = np.maximum(far - length, 0.0) / np.maximum(far, 1e-12)
            stands = stands + follows[:, None] * pull
            out[i] = stands
        if not marked:
            return out[..., 0]
        rubs = (length > 0)[:, None]
        return moved(rig, values, np.where(rubs, out, points))
