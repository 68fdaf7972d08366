"""Fills each chamber in turn and reads all of them: what `labrig rig check` judges a rig's tubes and sensors by."""

from collections.abc import Callable
from dataclasses import dataclass, field

import numpy as np

from labrig.arrays import Floats
from labrig.rig._pressure_watch import PressureWatch
from labrig.rig._rig import Rig
from labrig_drivers import DeviceError

SHARE = 0.5
"""How far a chamber is filled, as a share of the limit that is farther from vented."""

_TICK_S = 0.05
_REST_S = 1.0
_LOOK_S = 0.5
_STILL = 0.01
_LONGEST_S = 10.0
_HOLD_S = 3.0


@dataclass
class Filling:
    """One chamber filled alone: what was asked for, and what all chambers read.

    `time_s` (N,) from the first command, `pressure_kpa` (N, C); `ramp_s` is how long the slew limit let the command
    rise, `held_s` when the pressures had come to rest and the hold began. `moved_mm` (M, 3) is how far the markers
    moved, NaN where one was not seen; None without motion capture. `refused` says why nothing was filled.
    """

    chamber: int
    level_kpa: float
    time_s: Floats = field(default_factory=lambda: np.zeros(0))
    pressure_kpa: Floats = field(default_factory=lambda: np.zeros((0, 0)))
    ramp_s: float = 0.0
    held_s: float = 0.0
    moved_mm: Floats | None = None
    refused: str = ""


@dataclass
class Fillings:
    """What every chamber read at rest, kPa (C,), and each chamber filled alone."""

    rest_kpa: Floats
    of: list[Filling]


def fill_in_turn(rig: Rig, tell: Callable[[str], None] = lambda _: None) -> Fillings:
    """Vent, then fill each chamber alone to half of its farther limit, hold it, and vent again.

    Takes 5 to 15 s a chamber. Raises `DeviceError` when the device fails, a chamber reads more than its limit allows,
    or a vent is not confirmed; the caller vents then.
    """
    rig.vent()
    watch = PressureWatch(rig.config, rig.pressure.name, rig.clock.now_s())
    rest, still_mm = _read(rig, watch, _REST_S)
    fillings = []
    for index, chamber in enumerate(rig.config.chambers):
        level_kpa = SHARE * max(chamber.max_kpa, chamber.min_kpa, key=abs)
        if not level_kpa:
            fillings.append(Filling(index, level_kpa, refused="its limits are 0 to 0 kPa"))
            continue
        tell(f"filling {chamber.name} to {level_kpa:g} kPa")
        fillings.append(_fill(rig, watch, index, level_kpa, still_mm))
    return Fillings(_mean(rest[1]), fillings)


def _fill(rig: Rig, watch: PressureWatch, index: int, level_kpa: float, still_mm: Floats | None) -> Filling:
    target = np.zeros(len(rig.config.chambers))
    step_kpa = rig.config.chambers[index].slew_kpa_s * _TICK_S
    began_s = rig.clock.now_s()
    times: list[float] = []
    values: list[Floats] = []
    try:
        while abs(level_kpa - target[index]) > 0:
            target[index] += np.clip(level_kpa - target[index], -step_kpa, step_kpa)
            rig.pressure.set(target)
            _take(rig, watch, _TICK_S, times, values)
    except DeviceError as error:
        if target[index] and len(times):
            raise
        return Filling(index, level_kpa, refused=str(error).removeprefix(f"{rig.pressure.name}: "))
    ramp_s = rig.clock.now_s() - began_s
    while rig.clock.now_s() - began_s < ramp_s + _LONGEST_S:
        _take(rig, watch, _LOOK_S, times, values)
        if _at_rest(np.array(times), np.array(values), abs(level_kpa)):
            break
    held_s = rig.clock.now_s() - began_s
    _take(rig, watch, _HOLD_S - _LOOK_S, times, values)
    last, held_mm = _read(rig, watch, _LOOK_S)
    times += last[0].tolist()
    values += list(last[1])
    rig.vent()
    watch.forget(rig.clock.now_s())
    moved_mm = None if held_mm is None or still_mm is None else held_mm - still_mm
    time_s = np.array(times) - began_s
    return Filling(index, level_kpa, time_s, np.array(values), ramp_s, held_s, moved_mm)


def _at_rest(time_s: Floats, pressure_kpa: Floats, level_kpa: float) -> bool:
    """Whether no chamber changed between the last half second and the one before it."""
    if not len(time_s) or time_s[-1] - time_s[0] < 2 * _LOOK_S:
        return False
    late = _mean(pressure_kpa[time_s > time_s[-1] - _LOOK_S])
    before = _mean(pressure_kpa[(time_s <= time_s[-1] - _LOOK_S) & (time_s > time_s[-1] - 2 * _LOOK_S)])
    change = np.abs(late - before)
    return not np.any(change > max(_STILL * level_kpa, 0.1))


def _take(
    rig: Rig, watch: PressureWatch, duration_s: float, times: list[float], values: list[Floats]
) -> None:
    """Wait, and keep what is measured meanwhile; raises `DeviceError` beyond a limit, and where readings stay out."""
    end_s = rig.clock.now_s() + duration_s
    while True:
        samples = rig.pressure.samples()
        for sample in samples:
            times.append(sample.time_s)
            values.append(sample.pressure_kpa)
        now_s = rig.clock.now_s()
        watch.hear(samples, now_s)
        watch.check(samples, now_s)
        left_s = end_s - rig.clock.now_s()
        if left_s <= 0:
            break
        rig.clock.sleep(min(_TICK_S, left_s))


def _read(rig: Rig, watch: PressureWatch, duration_s: float) -> tuple[tuple[Floats, Floats], Floats | None]:
    """Read for a while: times (N,), pressures (N, C), and where the markers are on the mean, (M, 3) mm."""
    if rig.mocap is not None:
        rig.mocap.frames()
    times: list[float] = []
    values: list[Floats] = []
    _take(rig, watch, duration_s, times, values)
    if not values:
        raise DeviceError(f"{rig.pressure.name}: no measurement for {duration_s:g} s; check its link")
    frames = rig.mocap.frames() if rig.mocap is not None else []
    position = _mean(np.array([frame.position_mm for frame in frames])) if frames else None
    return (np.array(times), np.array(values)), position


def _mean(values: Floats) -> Floats:
    """The mean over the first axis of what is known; NaN where nothing is."""
    known = np.isfinite(values)
    count = known.sum(axis=0)
    return np.where(count > 0, np.where(known, values, 0.0).sum(axis=0) / np.maximum(count, 1), np.nan)
