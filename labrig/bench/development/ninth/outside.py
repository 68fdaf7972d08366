"""Outside the library, of the ninth portion: lenses, compressors, coils, missing valves, draughts, snaps."""

import numpy as np

from labrig.arrays import Floats
from labrig.bench._nature import Law, Path, Setting
from labrig.bench.development._places import (
    body_mm,
    direction,
    full,
    moved,
    positions,
    shift,
    some,
    span,
)


class LensDistortion(Law):
    """Lens distortion: a camera sees points too far out or in, with the cube of distance from its axis.

    D. C. Brown, Close-range camera calibration, Photogrammetric Engineering 37(8), 1971. The axis meets the
    body somewhere near its middle; a residue of calibration.
    """

    effect = "lens_distortion"
    needs = frozenset({"markers"})

    def __init__(self, setting: Setting) -> None:
        super().__init__(setting)
        random = setting.random
        centre, self._radius = body_mm(self.rig)
        self._axis = direction(random)
        self._middle = centre + self._radius * random.normal(0, 0.4, 3)
        seen = self.rig.settled(setting.path.kpa[setting.path.row])
        bent = self._bend(positions(self.rig, seen))
        natural = span(self.rig) * random.uniform(0.1, 0.25) / np.sqrt(np.mean(bent**2))
        self._k = natural * random.choice([-1.0, 1.0])

    def _bend(self, points_mm: Floats) -> Floats:
        arms = (points_mm - self._middle) / self._radius
        across = arms - (arms @ self._axis)[..., None] * self._axis
        return across * np.sum(across**2, axis=-1, keepdims=True)

    def seen(self, path: Path, deflection: Floats, values: Floats, strength: float) -> Floats:
        points_mm = positions(self.rig, values)
        return moved(self.rig, values, points_mm + strength * self._k * self._bend(points_mm))


class CompressorCycles(Law):
    """Compressor cycles: the tank empties and is pumped up again, and regulators let some through.

    ISO 6953-2, Pneumatic fluid power: Compressed air pressure regulators, Part 2, 2015 (pressure regulation
    characteristics: what comes out shifts with what comes in). A slow fall and a quick rise; a shut valve
    stays shut.
    """

    effect = "supply_cycle"

    def __init__(self, setting: Setting) -> None:
        super().__init__(setting)
        random, count = setting.random, len(self.rig.chambers)
        self._period_s = random.uniform(90, 400)
        self._start = random.uniform(0, 1)
        self._fall = random.uniform(0.7, 0.9)  # of the cycle
        self._through = random.uniform(0.06, 0.12) * random.uniform(0.7, 1.3, count)

    def pressure(self, path: Path, kpa: Floats, strength: float) -> Floats:
        phase = (path.time_s / self._period_s + self._start) % 1.0
        tank = np.where(phase < self._fall, 1 - phase / self._fall, (phase - self._fall) / (1 - self._fall))
        is_open = np.tanh(full(self.rig, kpa) / 0.1)
        shift_kpa = self.rig.high_kpa * self._through * is_open * (2 * tank[:, None] - 1)
        return kpa + strength * shift_kpa


class SnapsThrough(Law):
    """Snaps through: past some pressure a curved wall flips out by itself, and goes on from there.

    J. T. B. Overvelde et al., Amplifying the response of soft actuators by harnessing snap-through
    instabilities, PNAS 112(35), 2015. Only some walls do; they flip back at the same pressure, near enough.
    """

    effect = "wall_flips"

    def __init__(self, setting: Setting) -> None:
        super().__init__(setting)
        random, count = setting.random, len(self.rig.chambers)
        self._at = random.uniform(0.3, 0.7, count)
        self._wide = random.uniform(0.01, 0.03)
        self._jump = some(random, count, 0.12, 0.3, share=0.5)

    def wall(self, path: Path, kpa: Floats, deflection: Floats, strength: float) -> Floats:
        load = full(self.rig, kpa)
        flipped = (1 + np.tanh((load - self._at) / self._wide)) / 2
        return deflection + strength * self._jump * flipped


class CoilsDisturb(Law):
    """Coils disturb: the magnetic field of a valve that is powered turns the readings of the tracker near it.

    M. A. Nixon et al., The effects of metals and interfering fields on electromagnetic trackers, Presence
    7(2), 1998. A coil is on or off, however high the pressure; those at the end of the manifold are farther
    away.
    """

    effect = "coil_field"

    def __init__(self, setting: Setting) -> None:
        super().__init__(setting)
        random, count = setting.random, len(self.rig.chambers)
        far = np.linspace(1.0, random.uniform(1.5, 2.5), count)
        way = np.stack([direction(random) for _ in range(count)]) + 1.5 * direction(random)
        field = shift(self.rig, way) / far[:, None] ** 3
        field *= random.uniform(0.7, 1.3, field.shape)  # each sensor lies otherwise in the field
        self._field = field * span(self.rig) * random.uniform(0.1, 0.25)

    def seen(self, path: Path, deflection: Floats, values: Floats, strength: float) -> Floats:
        powered = np.abs(full(self.rig, path.commanded_kpa)) > 0.02
        return values + strength * powered.astype(float) @ self._field


class ValveMisses(Law):
    """Valve misses: now and then a valve does not switch when it is told to, and its chamber stays as it was.

    ISO 19973-2, Pneumatic fluid power: Assessment of component reliability by testing, Part 2: Directional
    control valves, 2015 (failure to shift). Dirt or damp: some valves more than others, at random among the
    actuations.
    """

    effect = "missed_switching"

    def __init__(self, setting: Setting) -> None:
        super().__init__(setting)
        random, count = setting.random, len(self.rig.chambers)
        self._often = np.maximum(some(random, count, 0.06, 0.12, share=0.6), 0.01)
        self._chance = random.random((int(setting.path.event.max()) + 1, count))

    def pressure(self, path: Path, kpa: Floats, strength: float) -> Floats:
        if strength == 0:
            return kpa
        often = np.minimum(strength * self._often, 0.8)
        missed = np.clip(
            2 * (1 - self._chance[np.maximum(path.event, 0) % len(self._chance)] / often), 0.0, 1.0
        )  # wholly or in part
        begins = np.flatnonzero(np.diff(path.event, prepend=path.event[0] - 1))
        first = np.searchsorted(begins, np.arange(len(path.event)), side="right") - 1
        before = np.where((begins[first] > 0)[:, None], kpa[np.maximum(begins[first] - 1, 0)], 0.0)
        return kpa + missed * (before - kpa)


class Draught(Law):
    """Draught: the air in the room is never still, and sways a light body to and fro by a little.

    ISO 7730, Ergonomics of the thermal environment, 2005, on draughts; as a sum of waves after M. Shinozuka
    and C.-M. Jan, Digital simulation of random processes, Journal of Sound and Vibration 25, 1972. Gusts last
    some seconds.
    """

    effect = "draught"

    def __init__(self, setting: Setting) -> None:
        super().__init__(setting)
        random, waves = setting.random, 40
        self._rate = 2 * np.pi / random.uniform(4, 40) * np.exp(random.normal(0, 0.7, waves))
        self._phase = random.uniform(0, 2 * np.pi, waves)
        self._push = span(self.rig) * random.uniform(0.08, 0.2) * np.sqrt(2 / waves)
        self._way = shift(self.rig, direction(random) * np.sqrt(3))
        self._way = self._way * random.uniform(0.5, 1.5, len(self._way))

    def seen(self, path: Path, deflection: Floats, values: Floats, strength: float) -> Floats:
        sway = self._push * np.sin(path.time_s[:, None] * self._rate + self._phase).sum(axis=1)
        return values + strength * sway[:, None] * self._way
