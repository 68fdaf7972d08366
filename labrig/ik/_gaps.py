"""Where a target is out of reach, by how much, and what stands against it."""

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from labrig.arrays import Floats

TOLERANCE_MM = 2.0
"""Distances up to this are no gap."""
_SMALLEST = 0.004
_MOST = 6
_LIMITS = {-1: "lowest", 0: "", 1: "highest"}


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


def find_gaps(
    signed_mm: Floats,
    uv: Floats,
    points_mm: Floats,
    influence: Floats,
    chambers: tuple[str, ...],
    limits: NDArray[np.int64],
) -> tuple[Gap, ...]:
    """Connected parts of the sample grid that are farther from the target than the tolerance, the worst first.

    signed_mm (P,) on a square grid, NaN where nothing is opposite; points_mm (P, 3) in the target's frame; influence
    (P, C) mm/kPa; limits (C,) -1, 0 or 1 for a chamber at its lowest pressure, between, at its highest.
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
            push = influence[worst]
            blocked = limits == (-1 if sign > 0 else 1)  # to go in, pressures fall; to come out, they rise
            strong = push > 0.3 * push.max()
            chosen = (
                int(np.argmax(np.where(blocked & strong, push, -1.0))) if (blocked & strong).any() else -1
            )
            name = int(np.argmax(push)) if chosen < 0 else chosen
            found.append(
                Gap(
                    depth_mm=float(far[worst]),
                    middle_mm=(x, y, z),
                    uv=(float(uv[worst, 0]), float(uv[worst, 1])),
                    area_share=float(len(own) / len(far)),
                    chamber=chambers[name],
                    limit=_LIMITS[int(limits[name])] if chosen >= 0 else "",
                )
            )
    return tuple(sorted(found, key=lambda gap: -abs(gap.depth_mm))[:_MOST])


def _pieces(mask: NDArray[np.bool_]) -> tuple[NDArray[np.int32], int]:
    from scipy.ndimage import label

    numbered = np.zeros(mask.shape, np.int32)
    return numbered, int(label(mask, output=numbered))  # pyright: ignore[reportArgumentType]
