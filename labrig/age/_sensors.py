"""What the pressure sensors say of a run by themselves: leaks, zeros, and what was logged beside."""

from collections.abc import Iterator
from typing import TYPE_CHECKING, Any

import numpy as np

from labrig.age._reading import Reading, reading
from labrig.arrays import Floats

if TYPE_CHECKING:
    from xarray import Dataset

_HELD = 0.1
"""Of its range, from where it is vented: a chamber with less in it, or less vacuum, says nothing of its leak."""
_VENTED = 0.01
"""Of its range: what is commanded below that is vented."""
_SHORTEST_S = 0.5
_PER_MINUTE = 60.0


def sensor_readings(run: "Dataset") -> Iterator[Reading | None]:
    """Leak rate and zero of each chamber that has a sensor, and the mean of everything else that was logged."""
    if "measured" in run and np.isfinite(run["measured"].values).any():
        yield from _chambers(run)
    if "covariates" in run:
        values = np.asarray(run["covariates"].values, float)
        for i, name in enumerate(run["covariate"].values):
            own = values[..., i][np.isfinite(values[..., i])]
            if own.size:
                spread = float(own.std() / np.sqrt(run.sizes["capture"]))
                yield reading(
                    "ambient", str(name), float(own.mean()), spread, str(run["covariate_unit"].values[i])
                )


def _chambers(run: "Dataset") -> Iterator[Reading | None]:
    measured, hold_s = np.asarray(run["measured"].values, float), np.asarray(run["hold_s"].values, float)
    settled, commanded = np.asarray(run["settled"].values, bool), np.asarray(run["commanded"].values, float)
    low, high = np.asarray(run["chamber_min"].values, float), np.asarray(run["chamber_max"].values, float)
    span = high - low
    vented_at = np.clip(0.0, low, high)
    away = np.abs(commanded - vented_at) / np.maximum(high - vented_at, vented_at - low)
    unit = str(run["commanded"].attrs.get("units", ""))
    for c, name in enumerate(str(v) for v in run["chamber"].values):
        known = settled & np.isfinite(measured[..., c]) & np.isfinite(hold_s)
        digit = _digit(measured[..., c], span[c])
        held = [
            _loss(hold_s[k, known[k]], measured[k, known[k], c], digit)
            for k in np.flatnonzero(away[:, c] > _HELD)
        ]
        rate, sd = _mean([each for each in held if each is not None])
        yield reading("leak", name, rate, sd, "%/min")
        vented = known & (np.abs(commanded).max(axis=1) <= _VENTED * span[c])[:, None]
        rounding = digit / np.sqrt(12.0)
        zero = [measured[k, vented[k], c] for k in np.flatnonzero(vented.any(axis=1))]
        value, sd = _mean([(float(z.mean()), max(_sd_of_mean(z), rounding)) for z in zero if len(z) > 1])
        yield reading("zero", name, value, max(sd, rounding), unit)


def _digit(values: Floats, span: float) -> float:
    """The last digit of a sensor: what two of its readings differ by at least, and what single precision can hold."""
    own = values[np.isfinite(values)]
    least = float(np.finfo(np.float32).eps) * max(float(np.abs(own).max(initial=0.0)), span)
    apart = np.diff(np.unique(own))
    return float(apart[apart > least].min()) if (apart > least).any() else least


def _loss(time_s: Floats, pressure: Floats, digit: float) -> tuple[float, float] | None:
    """How fast a held pressure or vacuum falls, % of itself a minute, by a straight line; None for too short a hold.

    The standard deviation is that of least squares, or, where larger, that of a line through two readings that are
    rounded to a `digit`, each off by digit / sqrt(12): rounding of a pressure that hardly moves is no noise that more
    readings average (B. Widrow, I. Kollar, Quantization Noise, Cambridge University Press, 2008).
    """
    if len(time_s) < 4 or np.ptp(time_s) < _SHORTEST_S:
        return None
    off, above = (
        time_s - time_s.mean(),
        pressure - pressure[0],
    )  # a pressure that stays has a slope of exactly 0
    square, mean = float(off @ off), float(pressure.mean())
    if mean == 0:
        return None
    slope = float(off @ above) / square
    left = above - above.mean() - slope * off
    sd = float(np.sqrt(left @ left / (len(left) - 2) / square))
    scale = -100.0 * _PER_MINUTE / mean
    return slope * scale, max(sd, digit / np.sqrt(6.0) / float(np.ptp(time_s))) * abs(scale)


def _sd_of_mean(values: Floats) -> float:
    return float(values.std(ddof=1) / np.sqrt(len(values))) if len(values) > 1 else np.nan


def _mean(parts: list[tuple[float, float]]) -> tuple[float, float]:
    """The mean of values weighted by what each says; its standard deviation grows with how they disagree (Birge)."""
    values = np.array(parts, float).reshape(-1, 2)
    values = values[np.isfinite(values).all(axis=1)]
    if not len(values):
        return np.nan, np.nan
    weight = values[:, 1] ** -2
    mean = float(weight @ values[:, 0] / weight.sum())
    ratio = float(weight @ (values[:, 0] - mean) ** 2) / max(len(values) - 1, 1)
    return mean, float(np.sqrt(max(1.0, ratio) / weight.sum()))


def lost_readings(run: "Dataset") -> Iterator[Reading | None]:
    """The share of all marker frames in settled recordings in which a marker was not seen."""
    if "position_mm" not in run:
        return
    position: Any = np.asarray(run["position_mm"].values, float)
    settled = np.asarray(run["settled"].values, bool)
    lost = ~np.isfinite(position).all(axis=3)
    each = np.array([100.0 * lost[k, settled[k]].mean() for k in np.flatnonzero(settled.any(axis=1))])
    if len(each):
        yield reading("lost", "all markers", float(each.mean()), _sd_of_mean(each), "%")
