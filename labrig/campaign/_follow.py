"""Did the pressures follow? Every recording is held against what was commanded."""

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np

from labrig.arrays import Floats
from labrig.rig import RigConfig
from labrig_drivers import PressureSample

IN_A_ROW = 3
"""Samples in a row that must be outside the tolerance: one alone may be a slip of the sensor or of the link."""

BEGINNING_S = 0.5
"""What counts as the beginning of a recording whose pressures may sag, s."""


@dataclass(frozen=True)
class Miss:
    """A chamber that did not follow: what it was asked for, what it read then, and how far off it may be, kPa."""

    chamber: str
    commanded_kpa: float
    measured_kpa: float
    tolerance_kpa: float

    def __str__(self) -> str:
        return (
            f"{self.chamber} was asked for {self.commanded_kpa:.1f} kPa and reads "
            f"{round(self.measured_kpa, 1) + 0.0:.1f} kPa "
            f"(it may be {self.tolerance_kpa:.1f} kPa off)"
        )


def misses(
    samples: Sequence[PressureSample], commanded_kpa: Floats, config: RigConfig, *, sag: bool = False
) -> list[Miss]:
    """The chambers that were outside the rig's tolerance of `commanded_kpa` (C,) for `IN_A_ROW` samples.

    With `sag` only the beginning counts. A chamber without a sensor (NaN) is never among them, and without samples
    nobody is: that pressures are measured at all is watched elsewhere.
    """
    if sag and samples:
        end_s = samples[0].time_s + BEGINNING_S
        samples = [sample for sample in samples if sample.time_s <= end_s]
    if not samples:
        return []
    measured = np.array([sample.pressure_kpa for sample in samples], float)
    tolerance = config.follow.tolerance_kpa + config.follow.tolerance_share * np.abs(commanded_kpa)
    outside = np.abs(measured - commanded_kpa) > tolerance
    found = []
    for index, chamber in enumerate(config.chambers):
        column = outside[:, index]
        if _longest(column) >= min(IN_A_ROW, len(column)):
            value = float(np.median(measured[column, index]))
            found.append(Miss(chamber.name, float(commanded_kpa[index]), value, float(tolerance[index])))
    return found


def reached_kpa(samples: Sequence[PressureSample], chambers: int) -> list[float | None]:
    """The mean of what each chamber read, (C,) kPa; None where nothing was read."""
    if not samples:
        return [None] * chambers
    measured = np.array([sample.pressure_kpa for sample in samples], float)
    known = np.isfinite(measured)
    total = np.where(known, measured, 0.0).sum(axis=0)
    return [float(s / n) if n else None for s, n in zip(total, known.sum(axis=0), strict=True)]


def _longest(outside: np.ndarray) -> int:
    """The longest stretch of True."""
    longest = now = 0
    for value in outside.tolist():
        now = now + 1 if value else 0
        longest = max(longest, now)
    return longest
