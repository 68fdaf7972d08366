"""What spoils a campaign: noise, its slow and uneven kinds, outliers, and markers out of sight."""

from dataclasses import asdict, dataclass

import numpy as np
from numpy.typing import NDArray

from labrig.arrays import Floats
from labrig.bench._nature import Rig


@dataclass(frozen=True)
class Spoil:
    """How a campaign is spoiled; sizes in the units of the observables, of which some are `noisier`, the rest as parts
    of one.

    `row` and `capture`: standard deviations of independent noise of each row, and of each capture (kept
    through its hold), per observable. `common`: of a slow offset, alike for all markers (one per axis, of
    sensors one per unit), AR(0.9) from capture to capture. `uneven`: how much the row noise swells and shrinks
    over the campaign.
    """

    row: float = 0.1
    capture: float = 0.1
    common: float = 0.0
    uneven: float = 0.0
    occlusion: float = 0.0
    outliers: float = 0.0

    def floor(self, rows: float) -> float:
        """Repeatability of the mean of a capture of `rows` rows, without the slow part."""
        return float(np.hypot(self.capture, self.row / np.sqrt(rows)))

    def as_dict(self) -> dict[str, float]:
        """The settings, for a file."""
        return asdict(self)


def _slow(random: np.random.Generator, captures: int, axes: int, memory: float = 0.9) -> Floats:
    """Stationary AR(1) of unit variance, (captures, axes)."""
    series = np.empty((captures, axes))
    value = random.normal(size=axes)
    for k in range(captures):
        series[k] = value
        value = memory * value + np.sqrt(1.0 - memory**2) * random.normal(size=axes)
    return series


def spoil(
    true: Floats, rig: Rig, capture: NDArray[np.int64], how: Spoil, random: np.random.Generator
) -> Floats:
    """Measured observables (R, K), NaN where out of sight, for true ones; `capture` (R,) numbers their holds.

    A marker is hidden, or jumps, with all its axes; an observable that is no marker's stays in sight.
    """
    rows, observables = true.shape
    captures = int(capture.max()) + 1
    owner, of_marker = _owners(rig)
    kinds = sorted({(o.axis, o.unit) for o in rig.observables})
    axis = [kinds.index((o.axis, o.unit)) for o in rig.observables]
    owners = int(owner.max()) + 1
    swell = 1.0 + how.uneven * np.sin(
        2.0 * np.pi * (np.arange(rows) / rows * random.uniform(0.5, 2.0) + random.random())
    )
    measured = true + how.row * swell[:, None] * random.normal(size=true.shape) * rig.noisier
    measured += (how.capture * random.normal(size=(captures, observables)) * rig.noisier)[capture]
    if how.common:
        measured += how.common * _slow(random, captures, max(axis) + 1)[capture][:, axis] * rig.noisier
    if how.outliers:
        whole = random.random((captures, owners)) < 0.5 * how.outliers
        bad = whole[capture] | (random.random((rows, owners)) < 0.5 * how.outliers)
        size = max(how.capture, how.row) * random.uniform(20.0, 200.0, (captures, owners))
        jump = size[:, owner] * random.normal(size=(captures, observables)) * rig.noisier
        measured += np.where(bad[:, owner], jump[capture], 0.0)
    if how.occlusion and of_marker.sum() > 1:
        share = random.uniform(0.2, 2.0, owners)
        hidden = random.random((captures, owners)) < how.occlusion * share / share.mean()
        blink = random.random((rows, owners)) < 0.1 * how.occlusion
        measured[((hidden[capture] | blink) & of_marker)[:, owner]] = np.nan
    return measured


def _owners(rig: Rig) -> tuple[NDArray[np.int64], NDArray[np.bool_]]:
    """Which thing each observable (K,) belongs to, a marker or itself, and which of the things are markers."""
    names = [o.marker if o.marker >= 0 else -1 - k for k, o in enumerate(rig.observables)]
    things, owner = np.unique(names, return_inverse=True)
    return owner, things >= 0
