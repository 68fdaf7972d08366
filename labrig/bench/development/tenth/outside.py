"""Outside the library, of the tenth portion: bulges, supply, wires, counters, words, clamps; optics are beside it."""

import numpy as np

from labrig.arrays import Floats
from labrig.bench._nature import Law, Path, Rig, Setting
from labrig.bench.development._places import alone, full, long_axis, some, span
from labrig.bench.development._story import a_moment_s, pauses
from labrig.bench.development.tenth.outside_more import (
    GapsFilled,
    InterchangedCaptures,
    OutOfPlane,
    PoseFlips,
    ShapePrior,
    WavyPane,
)


def _place(rig: Rig) -> Floats:
    """Where each observable (K,) is along the body, from 0 to 1: by its marker, or else by its order."""
    if rig.rest_mm is not None:
        return long_axis(rig)[1][[o.marker for o in rig.observables]]
    count = len(rig.observables)
    return np.linspace(0.0, 1.0, count) if count > 1 else np.full(1, 0.4)


def _events(path: Path) -> int:
    return int(path.event.max()) + 1


class RunningBulge(Law):
    """Running bulge: past some pressure a bulge appears at one end, and its front runs along the body.

    E. Chater and J. W. Hutchinson, On the propagation of bulges and buckles, J. Applied Mechanics 51, 1984.
    Places behind the front move by more, places before it not yet; the front is a little blurred.
    """

    effect = "running_bulge"

    def __init__(self, setting: Setting) -> None:
        super().__init__(setting)
        random, count = setting.random, len(self.rig.chambers)
        self._at = random.uniform(0.35, 0.6, count)
        self._blur = random.uniform(0.025, 0.05)
        self._swells = some(random, count, 0.15, 0.35, share=0.7)[:, None] * alone(self.rig)
        place = _place(self.rig)
        starts_low = random.random(count) < 0.5  # at which end, by chamber
        self._far = np.where(starts_low[:, None], place, 1 - place)

    def seen(self, path: Path, deflection: Floats, values: Floats, strength: float) -> Floats:
        front = (deflection - self._at) / (1 - self._at)
        behind = (1 + np.tanh((front[..., None] - self._far) / (2 * self._blur))) / 2
        return values + strength * np.einsum("tck,ck->tk", behind, self._swells)


class DepletedTank(Law):
    """Depleted tank: a small tank is emptied by quick fillings, and full pressure is lacking until it recovers.

    P. Beater, Pneumatic Drives: System Design, Modelling and Control, 2007 (sizing of reservoirs). What lacks
    goes by how much air was taken within the last minute or so; chambers at high pressure lack the most.
    """

    effect = "depleted_tank"

    def __init__(self, setting: Setting) -> None:
        super().__init__(setting)
        random = setting.random
        self._recovers_s = random.uniform(12, 50)
        size = np.abs(self.rig.high_kpa)
        self._takes = size * random.uniform(0.7, 1.3, len(size))  # bigger chambers take more
        self._takes /= self._takes.sum()
        usual = self._spent(setting.path, setting.path.kpa)[setting.path.row]
        self._lacks = random.uniform(0.12, 0.25) / np.sqrt(np.mean(usual**2) + 1e-9)

    def _spent(self, path: Path, kpa: Floats) -> Floats:
        load = np.maximum(full(self.rig, kpa), 0.0)
        taken = np.maximum(np.diff(load, axis=0, prepend=np.zeros((1, load.shape[1]))), 0.0) @ self._takes
        kept = np.exp(-pauses(path) / self._recovers_s)
        out, now = np.empty(len(taken)), 0.0
        for i in range(len(taken)):
            now = now * kept[i] + taken[i]
            out[i] = now
        return out

    def pressure(self, path: Path, kpa: Floats, strength: float) -> Floats:
        load = np.maximum(full(self.rig, kpa), 0.0)
        lacking = self._lacks * self._spent(path, kpa)
        return kpa / (1 + strength * lacking[:, None] * load)


class ScannedChannels(Law):
    """Scanned channels: one converter reads all numbers in turn, and each keeps some of the one read before it.

    W. Kester (ed.), The Data Conversion Handbook, Analog Devices, 2005 (settling of multiplexed inputs). The
    order is that of the wires; the first number follows a pressure sensor.
    """

    effect = "channel_ghost"

    def __init__(self, setting: Setting) -> None:
        super().__init__(setting)
        random, count = setting.random, len(self.rig.observables)
        self._order = random.permutation(count)
        self._sensor = int(random.integers(len(self.rig.chambers)))
        self._kept = random.uniform(0.08, 0.2) * random.uniform(0.5, 1.5, count)
        self._span = span(self.rig)

    def seen(self, path: Path, deflection: Floats, values: Floats, strength: float) -> Floats:
        sensor = self._span * full(self.rig, path.kpa)[:, self._sensor]
        way = (values - self.rig.at_rest)[:, self._order]
        before = np.column_stack([sensor, way[:, :-1]])
        out = values.copy()
        out[:, self._order] += strength * self._kept * before
        return out


class LostCounts(Law):
    """Lost counts: whatever counts steps loses some, or counts some twice, in wide motions, until it is homed.

    E. O. Doebelin, Measurement Systems: Application and Design, 2003 (incremental encoders). So does a tracker
    that follows a texture from image to image. Each session begins with homing.
    """

    effect = "lost_counts"

    def __init__(self, setting: Setting) -> None:
        super().__init__(setting)
        random, path = setting.random, setting.path
        self._share = random.normal(0, 1, (_events(path), len(self.rig.observables)))
        self._wide = span(self.rig) * random.uniform(0.3, 0.6)
        usual = self._lost(path, self.rig.settled(path.kpa))[path.row]
        size = np.sqrt(np.mean(usual**2))
        self._scale = span(self.rig) * random.uniform(0.08, 0.2) / size if size > 0 else 0.0

    def _lost(self, path: Path, values: Floats) -> Floats:
        """The miscounts (T, K) so far, but for their scale."""
        last = np.flatnonzero(np.diff(path.event, append=path.event[-1] + 1))  # of each actuation
        jump = np.diff(values[last], axis=0, prepend=self.rig.at_rest[None])
        share = self._share[np.arange(len(last)) % len(self._share)]
        lost = share * jump * (jump / self._wide) ** 2 / (1 + (jump / self._wide) ** 2)
        total = np.cumsum(lost, axis=0)
        homed = np.flatnonzero(np.diff(path.session[last], prepend=-1))
        since = homed[np.searchsorted(homed, np.arange(len(last)), side="right") - 1]
        total -= total[since]
        return total[np.searchsorted(last, np.arange(len(values)))]

    def seen(self, path: Path, deflection: Floats, values: Floats, strength: float) -> Floats:
        return values + strength * self._scale * self._lost(path, values)


class FlippedBits(Law):
    """Flipped bits: on a noisy bus now and then one bit of a set-point arrives turned over, for one actuation.

    P. Koopman and T. Chakravarty, Cyclic redundancy code polynomial selection for embedded networks, DSN, 2004
    (why words are checked). The error is a half, a quarter, an eighth or a sixteenth of the range.
    """

    effect = "flipped_bits"

    def __init__(self, setting: Setting) -> None:
        super().__init__(setting)
        random, count = setting.random, len(self.rig.chambers)
        events = max(_events(setting.path), 8)
        self._often = random.uniform(0.025, 0.05)
        self._rank = random.permutation(events * count).reshape(events, count)
        self._bit = 2.0 ** random.integers(1, 5, (events, count))  # 2, 4, 8, 16

    def pressure(self, path: Path, kpa: Floats, strength: float) -> Floats:
        low, high = self.rig.low_kpa, self.rig.high_kpa
        event = path.event % len(self._rank)
        bit = self._bit[event]
        word = np.clip((path.commanded_kpa - low) / (high - low), 0.0, 0.9999)
        turned = np.where(np.floor(word * bit) % 2 == 0, 1.0, -1.0) / bit
        # the last one that happens is caught on its way, and matters in part
        happens = np.clip(strength * self._often * self._rank.size - self._rank[event], 0.0, 1.0)
        return kpa + happens * turned * (high - low)


class ClampedOnceMore(Law):
    """Clamped anew: the body is taken out between sessions, and once for cleaning, and never clamped quite alike.

    Guide to the Expression of Uncertainty in Measurement, JCGM 100, 2008 (reproducibility: conditions newly set
    up). How long its free part is and how firmly it is held changes how far it moves, more at one end.
    """

    effect = "clamped_anew"

    def __init__(self, setting: Setting) -> None:
        super().__init__(setting)
        random = setting.random
        times, size = 64, random.uniform(0.06, 0.12)
        place = 2 * _place(self.rig) - 1
        self._taken_out_s = a_moment_s(setting)
        free = np.clip(random.normal(0, 1, (times, 1)), -1.5, 1.5)
        held = np.clip(random.normal(0, 1, (times, 1)), -1.5, 1.5)
        self._gain = size * (free + 0.8 * held * place)
        self._gain[0] = 0.0  # as the model was made

    def seen(self, path: Path, deflection: Floats, values: Floats, strength: float) -> Floats:
        clamping = (path.session + (path.time_s >= self._taken_out_s)) % len(self._gain)
        farther = np.expm1(strength * self._gain[clamping])
        return values + farther * (values - self.rig.at_rest)


OUTSIDE: tuple[type[Law], ...] = (
    RunningBulge,
    DepletedTank,
    ScannedChannels,
    LostCounts,
    FlippedBits,
    ClampedOnceMore,
    WavyPane,
    OutOfPlane,
    GapsFilled,
    ShapePrior,
    InterchangedCaptures,
    PoseFlips,
)
