"""Numbers to colours, by the scale that reports and recordings share."""

import numpy as np
from numpy.typing import NDArray

from labrig.view._style import AFTER, ERROR_SCALE


def rgb(colour: str) -> tuple[int, int, int]:
    """`#c0563a` as three numbers."""
    return int(colour[1:3], 16), int(colour[3:5], 16), int(colour[5:7], 16)


def error_colours(error: NDArray[np.float64], top: float) -> NDArray[np.uint8]:
    """Colours (N, 3) for errors (N,) from 0 to `top`; what is not known is grey."""
    share = np.clip(np.nan_to_num(error) / (top or 1.0), 0.0, 1.0)
    stops = [position for position, _ in ERROR_SCALE]
    anchors = np.array([rgb(colour) for _, colour in ERROR_SCALE], dtype=float)
    mixed = np.stack([np.interp(share, stops, anchors[:, k]) for k in range(3)], axis=-1)
    mixed[~np.isfinite(error)] = (120, 126, 134)
    return mixed.round().astype(np.uint8)


def moved_colours(distance: NDArray[np.float64], top: float) -> NDArray[np.uint8]:
    """Colours (N, 3) for how far something moved (N,), from 0 to `top`."""
    share = np.clip(np.nan_to_num(distance) / (top or 1.0), 0.0, 1.0)[:, None]
    near, far = np.array([214.0, 219.0, 222.0]), np.array(rgb(AFTER), dtype=float)
    return ((1.0 - share) * near + share * far).round().astype(np.uint8)
