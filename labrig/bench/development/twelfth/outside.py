"""Outside the library, of the twelfth portion: saturation, cross-talk, wraps, lamps, sensors that are mounted anew."""

import numpy as np

from labrig.arrays import Floats
from labrig.bench._nature import Law, Path, Setting
from labrig.bench.development._story import a_moment_s
from labrig.bench.development.twelfth._sensors import added, any_sensor, sensors, usual

_ROOM_KPA = 101.3
_FORCE = frozenset({"force"})


class AmplifierSaturates(Law):
    """Saturation: an amplifier's gain is set too high, and above some force its output stays at its supply's voltage.

    P. Horowitz, W. Hill, The Art of Electronics, Cambridge University Press, third edition, 2015. What is measured goes
    on; one load cell, or each, reads one and the same number.
    """

    effect = "saturated_sensor"
    needs = _FORCE

    def __init__(self, setting: Setting) -> None:
        super().__init__(setting)
        random, rig, path = setting.random, self.rig, setting.path
        self._forces = sensors(rig, "N")
        if random.random() < 0.5:
            self._forces = random.choice(self._forces, 1)
        shown = rig.settled(path.kpa)[:, self._forces]
        self._most = shown.max(axis=0)
        self._less = random.uniform(0.25, 0.5) * np.ptp(shown, axis=0)

    def seen(self, path: Path, deflection: Floats, values: Floats, strength: float) -> Floats:
        if strength == 0:
            return values
        over = values[:, self._forces] - (self._most - strength * self._less)
        return added(values, self._forces, -np.maximum(over, 0.0))


class SensorsCrossTalk(Law):
    """Cross-talk: each sensor answers a little to what others measure: side loads on a cell, bending of an encoder.

    Y. Sun, Y. Liu, T. Zou, M. Jin, H. Liu, Design and optimization of a novel six-axis force/torque sensor, Measurement
    65, 2015, on the coupling matrix. It was taken for diagonal.
    """

    effect = "sensor_crosstalk"

    def __init__(self, setting: Setting) -> None:
        super().__init__(setting)
        random, rig = setting.random, self.rig
        self._which = sensors(rig)
        far = usual(rig, setting.path)[self._which]
        matrix = random.normal(0, 1.0, (len(far), len(far))) * (random.random((len(far), len(far))) < 0.7)
        np.fill_diagonal(matrix, 0.0)
        self._matrix = random.uniform(0.06, 0.15) * matrix * far / far[:, None]

    def seen(self, path: Path, deflection: Floats, values: Floats, strength: float) -> Floats:
        gone = (values - self.rig.at_rest)[:, self._which]
        return added(values, self._which, strength * gone @ self._matrix)


class EncoderWraps(Law):
    """Wrapped encoder: past the end of its turn an angle begins again below, and the software misses to count that.

    F. Petrella et al., Speed measurement algorithms for low-resolution incremental encoder equipped drives, ISIE, 2007.
    Where the turn ends is by chance; a magnet of many poles has short turns.
    """

    effect = "encoder_wraps"
    needs = frozenset({"angle"})

    def __init__(self, setting: Setting) -> None:
        super().__init__(setting)
        random, path = setting.random, setting.path
        self._which = any_sensor(setting, "deg")
        shown = self.rig.settled(path.kpa[path.row])[:, self._which]
        self._ends = float(np.quantile(shown, random.uniform(0.2, 0.8)))
        self._turn = float(random.uniform(0.2, 0.5) * usual(self.rig, path)[self._which])

    def seen(self, path: Path, deflection: Floats, values: Floats, strength: float) -> Floats:
        past = values[:, self._which] > self._ends
        return added(values, self._which, np.where(past, -strength * self._turn, 0.0))


class LampWarmsTheAir(Law):
    """Lamp: now and then somebody lights the rig to look at it, and shut-in air gets warmer and presses more.

    J. L. Gay-Lussac, Recherches sur la dilatation des gaz et des vapeurs, Annales de Chimie 43, 1802. Pressure above
    vacuum goes with the temperature, which rises and falls exponentially; what is in the shade gets less.
    """

    effect = "heat_pulses"

    def __init__(self, setting: Setting) -> None:
        super().__init__(setting)
        random, path = setting.random, setting.path
        rows_s = path.time_s[path.row]
        count = int(random.integers(2, 5))
        self._on_s = np.quantile(rows_s, random.uniform(0.02, 0.9, count))
        self._off_s = self._on_s + random.uniform(20.0, 120.0, count)
        self._warms_s = random.uniform(8.0, 40.0)
        self._size = random.uniform(0.02, 0.05) * random.uniform(0.3, 1.0, len(self.rig.chambers))

    def pressure(self, path: Path, kpa: Floats, strength: float) -> Floats:
        def reached(since_s: Floats) -> Floats:
            return -np.expm1(-np.maximum(since_s, 0.0) / self._warms_s)

        time_s = path.time_s[:, None]
        warm = np.sum(reached(time_s - self._on_s) - reached(time_s - self._off_s), axis=1)
        over = np.maximum(kpa, 0.0) + _ROOM_KPA
        shut_in = np.clip(np.abs(kpa) / (0.05 * self.rig.high_kpa), 0.0, 1.0)  # what is vented stays open
        return kpa + strength * self._size * warm[:, None] * over * shut_in


class SensorMountedAnew(Law):
    """Mounted anew: one sensor's clamp slips, or it is taken out and put back, with another zero and another lever.

    JCGM 100, Guide to the Expression of Uncertainty in Measurement, 2008, on what a new mounting adds. All the others
    stay as they were.
    """

    effect = "sensor_remounted"

    def __init__(self, setting: Setting) -> None:
        super().__init__(setting)
        random, rig = setting.random, self.rig
        self._from_s = a_moment_s(setting)
        self._which = any_sensor(setting)
        far = float(usual(rig, setting.path)[self._which])
        self._zero = random.choice([-1.0, 1.0]) * random.uniform(0.15, 0.4) * far
        self._lever = random.normal(0, 0.15)

    def seen(self, path: Path, deflection: Floats, values: Floats, strength: float) -> Floats:
        gone = values[:, self._which] - self.rig.at_rest[self._which]
        late = path.time_s >= self._from_s
        return added(values, self._which, strength * late * (self._zero + self._lever * gone))


class CoarseReadings(Law):
    """Coarse readings: a converter of few steps rounds what some sensors say, while others are read finely.

    B. Widrow, I. Kollár, Quantization Noise, Cambridge University Press, 2008. The same value always becomes the same
    step, so that repeating does not help.
    """

    effect = "coarse_reading"

    def __init__(self, setting: Setting) -> None:
        super().__init__(setting)
        random, rig = setting.random, self.rig
        units = sorted({o.unit for o in rig.observables if o.marker < 0})
        self._which = sensors(rig, str(random.choice(units)))
        far = usual(rig, setting.path)[self._which]
        self._step = random.uniform(0.3, 0.6) * far.mean()
        self._zero = random.uniform(0, 1, len(far))

    def seen(self, path: Path, deflection: Floats, values: Floats, strength: float) -> Floats:
        if strength == 0:
            return values
        step = strength * self._step
        place = values[:, self._which] / step + self._zero
        return added(values, self._which, (np.round(place) - place) * step)


class CosineError(Law):
    """Cosine error: a load cell turns with the joint that it sits on, and reads only what is left along its axis.

    E. P. DeGarmo, J. T. Black, R. A. Kohser, Materials and Processes in Manufacturing, Macmillan, 1988, on that error.
    It was mounted askew, too; so each force is read by a factor that an angle sets.
    """

    effect = "cosine_error"
    needs = frozenset({"force", "angle"})

    def __init__(self, setting: Setting) -> None:
        super().__init__(setting)
        random = setting.random
        self._forces = sensors(self.rig, "N")
        self._angle = any_sensor(setting, "deg")
        self._askew = np.deg2rad(random.uniform(8, 25, len(self._forces)) * random.choice([-1, 1]))

    def seen(self, path: Path, deflection: Floats, values: Floats, strength: float) -> Floats:
        turn = np.deg2rad(values[:, [self._angle]] - self.rig.at_rest[self._angle])
        less = np.cos(np.clip(turn + self._askew, -1.5, 1.5)) - np.cos(self._askew)
        return added(values, self._forces, strength * less * values[:, self._forces])


class MainsHum(Law):
    """Mains hum: load cells pick up the mains, which rows far apart show as a slow wave that never ends.

    H. W. Ott, Electromagnetic Compatibility Engineering, Wiley, 2009; C. E. Shannon, Communication in the presence of
    noise, Proceedings of the IRE 37, 1949, on what is sampled too seldom. Its size is a cell's own, and the mains'
    frequency wanders a little.
    """

    effect = "mains_hum"
    needs = _FORCE

    def __init__(self, setting: Setting) -> None:
        super().__init__(setting)
        random = setting.random
        self._forces = sensors(self.rig, "N")
        far = usual(self.rig, setting.path)[self._forces]
        self._size = random.uniform(0.1, 0.25) * far * random.uniform(0.5, 1.5, len(far))
        self._period_s = random.uniform(12.0, 70.0)
        self._wanders_s = random.uniform(200.0, 900.0)
        self._by, self._phase = random.uniform(1.0, 4.0), random.uniform(0, 2 * np.pi, 2)

    def seen(self, path: Path, deflection: Floats, values: Floats, strength: float) -> Floats:
        slow = 2 * np.pi * path.time_s / self._wanders_s + self._phase[1]
        wave = np.sin(2 * np.pi * path.time_s / self._period_s + self._phase[0] + self._by * np.sin(slow))
        return added(values, self._forces, strength * wave[:, None] * self._size)


OUTSIDE: tuple[type[Law], ...] = (
    AmplifierSaturates,
    SensorsCrossTalk,
    EncoderWraps,
    LampWarmsTheAir,
    SensorMountedAnew,
    CoarseReadings,
    CosineError,
    MainsHum,
)
