"""Further laws outside the library: real phenomena that none of its names describes."""

import numpy as np

from labrig.arrays import Floats
from labrig.bench._nature import Law, Path, Setting
from labrig.bench.development._places import alone, columns, full, smooth_field, some, span, spread
from labrig.bench.development._story import pauses, steps


class SetByHighestLoad(Law):
    """Permanent set: each new highest load leaves a wall a little longer, also once it is vented.

    A. Dorfmann, R. W. Ogden, A constitutive model for the Mullins effect with permanent set in particle-reinforced
    rubber, Int. J. Solids and Structures 41, 2004.
    """

    effect = "permanent_set"

    def __init__(self, setting: Setting) -> None:
        super().__init__(setting)
        self._power = setting.random.uniform(1.5, 3.0)
        self._set = some(setting.random, len(self.rig.chambers), 0.05, 0.15, 0.8)

    def wall(self, path: Path, kpa: Floats, deflection: Floats, strength: float) -> Floats:
        highest = np.maximum.accumulate(np.maximum(deflection, 0.0), axis=0)
        return deflection + strength * self._set * highest**self._power


class AddedDamage(Law):
    """Damage that adds up: one chamber's reinforcement fails, as the square of the damage of all its load cycles.

    M. A. Miner, Cumulative damage in fatigue, J. Applied Mechanics 12, 1945.
    """

    effect = "added_damage"

    def __init__(self, setting: Setting) -> None:
        super().__init__(setting)
        self._chamber = int(setting.random.integers(len(self.rig.chambers)))
        self._power = setting.random.uniform(2.0, 4.0)
        self._life = max(float(self._damage(full(self.rig, setting.path.kpa))[-1]), 1e-6)
        self._softer = setting.random.uniform(0.15, 0.5)

    def _damage(self, load: Floats) -> Floats:
        own = np.maximum(load[:, self._chamber : self._chamber + 1], 0.0)
        return np.cumsum(np.abs(steps(own**self._power)))

    def wall(self, path: Path, kpa: Floats, deflection: Floats, strength: float) -> Floats:
        spent = np.minimum(self._damage(full(self.rig, kpa)) / self._life, 1.5)
        out = deflection.copy()
        out[:, self._chamber] *= np.exp(np.minimum(strength * self._softer * spent**2, 2.0))
        return out


class AliasedPulsation(Law):
    """Aliasing: the strokes of a membrane pump, too fast for the rows, are seen as a slow beat of the supply.

    C. E. Shannon, Communication in the presence of noise, Proc. IRE 37, 1949.
    """

    effect = "aliased_pulsation"

    def __init__(self, setting: Setting) -> None:
        super().__init__(setting)
        random = setting.random
        self._period_s, self._phase = random.uniform(0.9, 6.0), random.uniform(0, 2 * np.pi)
        self._second = random.uniform(0.0, 0.5)
        self._passed = random.uniform(0.03, 0.1) * random.uniform(0.7, 1.3, len(self.rig.chambers))

    def pressure(self, path: Path, kpa: Floats, strength: float) -> Floats:
        angle = 2 * np.pi * path.time_s / self._period_s + self._phase
        stroke = np.sin(angle) + self._second * np.sin(2 * angle)
        return kpa * np.exp(strength * self._passed * stroke[:, None])


class Blister(Law):
    """Blister: once a chamber has passed a load a glued layer lets go beside it, and bulges with it ever after.

    H. M. Jensen, The blister test for interface toughness measurement, Engineering Fracture Mechanics 40, 1991.
    """

    effect = "blister"

    def __init__(self, setting: Setting) -> None:
        super().__init__(setting)
        random, path = setting.random, setting.path
        self._chamber = int(random.integers(len(self.rig.chambers)))
        load = full(self.rig, path.kpa)[:, self._chamber]
        highest = np.maximum.accumulate(load)
        self._opens = max(float(highest[int(random.uniform(0.15, 0.6) * len(load))]), 0.2)
        self._opens = min(self._opens, 0.95 * float(load.max()))
        marked = columns(self.rig).max(initial=-1) >= 0
        field = spread(self.rig, smooth_field(setting)) if marked else np.sign(alone(self.rig)[self._chamber])
        self._bulge = span(self.rig) * random.uniform(0.2, 0.6) * field

    def seen(self, path: Path, deflection: Floats, values: Floats, strength: float) -> Floats:
        load = full(self.rig, path.kpa)[:, self._chamber]
        since = np.maximum.accumulate(load) > self._opens
        bulges = since * np.maximum(deflection[:, self._chamber], 0.0) ** 2
        return values + strength * bulges[:, None] * self._bulge


class PixelLocking(Law):
    """Pixel locking: the centre of a marker is drawn to the pixel's middle, so that its error waves as it moves.

    H. W. Schreier, J. R. Braasch, M. A. Sutton, Systematic errors in digital image correlation caused by intensity
    interpolation, Optical Engineering 39, 2000.
    """

    effect = "pixel_locking"
    needs = frozenset({"markers"})

    def __init__(self, setting: Setting) -> None:
        super().__init__(setting)
        random = setting.random
        self._pixel_mm = span(self.rig) * random.uniform(0.4, 1.0)
        self._drawn_mm = span(self.rig) * random.uniform(0.03, 0.1)

    def seen(self, path: Path, deflection: Floats, values: Floats, strength: float) -> Floats:
        return values - strength * self._drawn_mm * np.sin(2 * np.pi * values / self._pixel_mm)


class HeatBuildUp(Law):
    """Heat build-up: each stroke warms the rubber and its gas, warm walls are softer, and minutes of rest cool them.

    A. N. Gent (ed.), Engineering with Rubber, 3rd ed., Hanser, 2012.
    """

    effect = "heat_build_up"

    def __init__(self, setting: Setting) -> None:
        super().__init__(setting)
        random = setting.random
        self._cools_s = np.exp(random.uniform(np.log(40), np.log(400)))
        self._softer = some(random, len(self.rig.chambers), 0.03, 0.1, 0.9)
        self._usual = max(float(np.mean(self._heat(setting.path, full(self.rig, setting.path.kpa)))), 1e-6)

    def _heat(self, path: Path, load: Floats) -> Floats:
        stays, work = np.exp(-pauses(path) / self._cools_s), np.abs(steps(load * np.abs(load)))
        state, out = np.zeros(load.shape[1]), np.empty_like(load)
        for t in range(len(out)):
            state = state * stays[t] + work[t]
            out[t] = state
        return out

    def wall(self, path: Path, kpa: Floats, deflection: Floats, strength: float) -> Floats:
        warm = self._heat(path, full(self.rig, kpa)) / self._usual
        return deflection * np.exp(np.minimum(strength * self._softer * warm, 2.0))


class ValveInterference(Law):
    """Interference: valves that are pulsed disturb the sensors, most at half duty, and each sensor in its own way.

    H. W. Ott, Electromagnetic Compatibility Engineering, Wiley, 2009.
    """

    effect = "valve_interference"

    def __init__(self, setting: Setting) -> None:
        super().__init__(setting)
        random, rig = setting.random, self.rig
        self._picks_up = span(rig) * random.normal(0, 0.1, len(rig.observables))
        self._loud = some(random, len(rig.chambers), 0.5, 1.5, 0.8)

    def seen(self, path: Path, deflection: Floats, values: Floats, strength: float) -> Floats:
        duty = np.clip(full(self.rig, path.commanded_kpa), 0.0, 1.0)
        loud = np.sqrt((4 * duty * (1 - duty)) ** 2 @ self._loud)
        return values + strength * loud[:, None] * self._picks_up
