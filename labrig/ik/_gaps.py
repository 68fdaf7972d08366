"""Where a target is out of reach, by how much, and what stands against it."""

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from labrig.arrays import Floats

TOLERANCE_MM = 2.0
"""Distances up to this are no gap."""
_SMALLEST = 0.004
_MOST = 6
_NEAR = 1e-6
"""Share of its range within which a chamber is at its limit."""


@dataclass(frozen=True)
class Gap:
    """A part of the surface that stays away from the target.

    `depth_mm`: the farthest signed distance, positive where the surface stands out of the target; `middle_mm` (3,) in
    the target's own frame; `uv` the place on the model's surface; `area_share` of the surface; `chamber` the one that
    moves this part most, and whether it is at a `limit` ("", "lowest" or "highest") that keeps it from going on.
    """

    depth_mm: float
    middle_mm: tuple[float, float, float]
    uv: tuple[float, float]
    area_share: float
    chamber: str
    limit: str

    @property
    def words(self) -> str:
        """The gap in words."""
        side = "stands out of" if self.depth_mm > 0 else "stays inside"
        x, y, z = self.middle_mm
        why = f"; {self.chamber} is at its {self.limit} pressure" if self.limit else ""
        return (
            f"{side} the target by up to {abs(self.depth_mm):.1f} mm around ({x:.0f}, {y:.0f}, {z:.0f}){why}"
        )


def limits_of(pressure_kpa: Floats, low_kpa: Floats, high_kpa: Floats) -> NDArray[np.bool_]:
    """Which chambers are at their lowest, and which at their highest pressure: (2, C), for limits (C,), kPa."""
    slack = _NEAR * (high_kpa - low_kpa)
    return np.stack([pressure_kpa <= low_kpa + slack, pressure_kpa >= high_kpa - slack])


def find_gaps(
    signed_mm: Floats,
    uv: Floats,
    points_mm: Floats,
    influence: Floats,
    chambers: tuple[str, ...],
    limits: NDArray[np.bool_],
) -> tuple[Gap, ...]:
    """Connected parts of the sample grid that are farther from the target than the tolerance, the worst first.

    signed_mm (P,) on a square grid, NaN where nothing is opposite; points_mm (P, 3) in the target's frame; influence
    (P, C), mm/kPa, by how much each pressure moves the surface outwards; limits (2, C) of `limits_of`.
    """
    side = round(np.sqrt(len(signed_mm)))
    far = np.nan_to_num(signed_mm)
    found: list[Gap] = []
    for sign in (1, -1):
        pieces, count = _pieces((sign * far > TOLERANCE_MM).reshape(side, side))
        for number in range(1, count + 1):
            own = np.flatnonzero(pieces.ravel() == number)
            if len(own) < max(2, _SMALLEST * len(far)):
                continue
            worst = int(own[np.argmax(np.abs(far[own]))])
            x, y, z = (float(value) for value in points_mm[worst])
            push = np.abs(influence[worst])
            falls = sign * influence[worst] > 0.0  # where more pressure moves it away, less would help
            blocked = np.where(falls, limits[0], limits[1]) & (push > 0.3 * push.max())
            name = int(np.argmax(np.where(blocked, push, -1.0) if blocked.any() else push))
            found.append(
                Gap(
                    depth_mm=float(far[worst]),
                    middle_mm=(x, y, z),
                    uv=(float(uv[worst, 0]), float(uv[worst, 1])),
                    area_share=float(len(own) / len(far)),
                    chamber=chambers[name],
                    limit="" if not blocked[name] else "lowest" if falls[name] else "highest",
                )
            )
    return tuple(sorted(found, key=lambda gap: -abs(gap.depth_mm))[:_MOST])


def _pieces(mask: NDArray[np.bool_]) -> tuple[NDArray[np.int32], int]:
    from scipy.ndimage import label

    numbered = np.zeros(mask.shape, np.int32)
    return numbered, int(label(mask, output=numbered))  # pyright: ignore[reportArgumentType]
