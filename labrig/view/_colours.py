"""Numbers to colours, by the scale that reports, recordings and still pictures share: noise floors, the same in all."""

import numpy as np
from numpy.typing import NDArray

from labrig.view._style import AFTER, ERROR_SCALE

STEPS = (1, 2, 4, 8, 16)
"""Floors at which the scale has its stops: up to one floor an error is none, from sixteen on it is as dark as any."""
UNSEEN = (120, 126, 134)


def rgb(colour: str) -> tuple[int, int, int]:
    """`#c0563a` as three numbers."""
    return int(colour[1:3], 16), int(colour[3:5], 16), int(colour[5:7], 16)


def shade(error: NDArray[np.float64], floor: float) -> NDArray[np.float64]:
    """Where errors lie on the scale of colours, 0 (up to the floor) to 1 (sixteen floors and more); NaN stays."""
    return np.clip(np.log2(np.maximum(error / floor, STEPS[0])) / np.log2(STEPS[-1]), 0.0, 1.0)


def error_colours(error: NDArray[np.float64], floor: float) -> NDArray[np.uint8]:
    """Colours (N, 3) for errors (N,) by the noise floor; what is not known is grey."""
    share = np.nan_to_num(shade(error, floor))
    stops = [position for position, _ in ERROR_SCALE]
    anchors = np.array([rgb(colour) for _, colour in ERROR_SCALE], dtype=float)
    mixed = np.stack([np.interp(share, stops, anchors[:, k]) for k in range(3)], axis=-1)
    mixed[~np.isfinite(error)] = UNSEEN
    return mixed.round().astype(np.uint8)


def floor_for_colours(floor: float | None, error: NDArray[np.float64]) -> float:
    """The floor that colours are counted in; where none is known, a sixteenth of the largest error."""
    if floor is not None and np.isfinite(floor) and floor > 0:
        return float(floor)
    known = error[np.isfinite(error)]
    return float(known.max()) / STEPS[-1] if known.size and known.max() > 0 else 1.0


def moved_colours(distance: NDArray[np.float64], top: float) -> NDArray[np.uint8]:
    """Colours (N, 3) for how far something moved (N,), from 0 to `top`."""
    share = np.clip(np.nan_to_num(distance) / (top or 1.0), 0.0, 1.0)[:, None]
    near, far = np.array([214.0, 219.0, 222.0]), np.array(rgb(AFTER), dtype=float)
    return ((1.0 - share) * near + share * far).round().astype(np.uint8)
