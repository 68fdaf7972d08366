"""Friction of the eighth portion: dry, with Stribeck's dip, in a braid, on a table, and of seals."""

import numpy as np

from labrig.arrays import Bools, Floats
from labrig.bench._nature import Law, Path, Setting
from labrig.bench.development._places import columns, full, moved, positions, some, span
from labrig.bench.development._story import pauses, steps

_STILL = 1e-3  # of full pressure: a smaller step is no motion


def _kept(now: Floats, moves: Bools) -> Floats:
    """The last of `now` (T, N, ...) at which something `moves` (T, N), for each moment; zeros before the first."""
    last = np.maximum.accumulate(np.where(moves, np.arange(len(now))[:, None], -1), axis=0)
    kept = now[np.maximum(last, 0), np.arange(now.shape[1])]
    return np.where((last < 0).reshape(*last.shape, *[1] * (now.ndim - 2)), 0.0, kept)


def _way(load: Floats) -> Floats:
    """Which way (T, C) each chamber moves, or moved last: 1 up, -1 down, 0 before its first motion."""
    step = steps(load)
    return _kept(np.sign(step), np.abs(step) > _STILL)


class DryFriction(Law):
    """Dry friction: a force of one size against the direction of motion; each chamber has its own.

    C. A. de Coulomb, Théorie des machines simples, Bachelier, Paris, 1821.
    """

    effect = "friction"

    def __init__(self, setting: Setting) -> None:
        super().__init__(setting)
        self._force_kpa = some(setting.random, len(self.rig.chambers), 0.03, 0.07) * self.rig.high_kpa

    def pressure(self, path: Path, kpa: Floats, strength: float) -> Floats:
        return kpa - strength * self._force_kpa * _way(full(self.rig, kpa))


class StribeckCurve(Law):
    """Stribeck's curve: most friction at the slowest motion, less as it gets quicker, then more by viscosity.

    B. Armstrong-Hélouvry, P. Dupont, C. Canudas de Wit, A survey of models, analysis tools and compensation methods
    for the control of machines with friction, Automatica 30, 1994. All chambers are alike.
    """

    effect = "friction"

    def __init__(self, setting: Setting) -> None:
        super().__init__(setting)
        random = setting.random
        self._slow = random.uniform(0.035, 0.07)  # as shares of the full motion
        self._quick = self._slow * random.uniform(0.5, 0.8)
        self._dip_per_s = random.uniform(0.02, 0.2)
        self._viscous_s = random.uniform(0.001, 0.005)

    def wall(self, path: Path, kpa: Floats, deflection: Floats, strength: float) -> Floats:
        load = full(self.rig, kpa)
        speed = np.abs(steps(load)) / np.maximum(pauses(path), 0.01)[:, None]
        size = self._quick + (self._slow - self._quick) * np.exp(-((speed / self._dip_per_s) ** 2))
        return deflection - strength * (size + self._viscous_s * speed) * _way(load)


class BraidRubs(Law):
    """Braid that rubs: threads are pressed onto each other by the pressure, and rub as the muscle moves.

    B. Tondu, P. Lopez, Modeling and control of McKibben artificial muscle robot actuators, IEEE Control Systems
    Magazine 20, 2000. The friction goes with pressure times the area of contact, which grows as the braid opens.
    """

    effect = "friction"

    def __init__(self, setting: Setting) -> None:
        super().__init__(setting)
        random, count = setting.random, len(self.rig.chambers)
        self._coefficient = random.uniform(0.06, 0.12) * random.uniform(0.8, 1.2, count)
        self._opens = random.uniform(0.2, 0.8)

    def wall(self, path: Path, kpa: Floats, deflection: Floats, strength: float) -> Floats:
        load = full(self.rig, kpa)
        area = 1 + self._opens * np.clip(np.abs(deflection), 0.0, 2.0)
        return deflection - strength * self._coefficient * np.abs(load) * area * _way(load)


class RestsOnTable(Law):
    """Rests on a table: where the body lies on it each place stays behind, against the way that it goes.

    E. Rabinowicz, Friction and Wear of Materials, Wiley, 1965. The lower places rest on it; what hangs on the body
    presses it down.
    """

    effect = "friction"

    def __init__(self, setting: Setting) -> None:
        super().__init__(setting)
        random, rig = setting.random, self.rig
        self._back = random.uniform(0.09, 0.15) * span(rig)
        self._mass_kg = random.uniform(0.2, 0.6)
        self._by_number = random.uniform(0.5, 1.0, len(rig.observables))
        height = rig.rest_mm[:, 2] if rig.rest_mm is not None else np.zeros(0)
        share = random.uniform(0.5, 0.9)
        self._rests = (height <= np.quantile(height, share)) if height.size else np.zeros(0, dtype=bool)

    def seen(self, path: Path, deflection: Floats, values: Floats, strength: float) -> Floats:
        rig = self.rig
        back = strength * self._back * (1 + path.payload_kg / self._mass_kg)[:, None]
        still = 0.003 * span(rig)
        step = np.diff(values, axis=0, prepend=rig.at_rest[None])
        out = values - back * self._by_number * _kept(np.sign(step), np.abs(step) > still)
        if columns(rig).max(initial=-1) < 0:
            return out
        points = positions(rig, values)
        leap = np.diff(points, axis=0, prepend=positions(rig, rig.at_rest[None]))
        far = np.linalg.norm(leap, axis=2)
        way = _kept(leap / np.maximum(far, 1e-12)[..., None], far > still)
        return moved(rig, out, points - back[..., None] * self._rests[:, None] * way)


class SealOfPiston(Law):
    """Seals of pistons: rings rub by their squeeze, and the more the pressure presses their lips on; more going out.

    Parker Hannifin, Parker O-Ring Handbook, ORD 5700, 2007. Some chambers only have pistons.
    """

    effect = "friction"

    def __init__(self, setting: Setting) -> None:
        super().__init__(setting)
        random, count = setting.random, len(self.rig.chambers)
        self._squeeze = some(random, count, 0.04, 0.08, 0.6)
        self._lips = np.where(self._squeeze > 0, random.uniform(0.03, 0.08, count), 0.0)
        self._out, self._in = 1.0, random.uniform(0.5, 1.0)

    def pressure(self, path: Path, kpa: Floats, strength: float) -> Floats:
        load = full(self.rig, kpa)
        way = _way(load)
        size = (self._squeeze + self._lips * np.abs(load)) * np.where(way > 0, self._out, self._in)
        return kpa - strength * size * way * self.rig.high_kpa
