"""What inverse kinematics finds: pressures, the pose of the target, and what remains between the two surfaces."""

from dataclasses import dataclass, field
from functools import cached_property
from typing import Any

import numpy as np

from labrig.arrays import Floats
from labrig.ik._gaps import Gap, find_gaps
from labrig.shape_contents import SolvedShape


@dataclass(frozen=True)
class IkResult:
    """The best actuation for a target.

    pressure_kpa (C,); target to rig: x -> rotation @ x + translation_mm; `mean_mm`, `p95_mm`, `max_mm` of the absolute
    distance between the model's surface and the target, over the samples that have the target opposite (`share` of
    all); `signed_mm` (P,) distances at `uv` (P, 2), positive where the surface stands out, NaN where nothing is
    opposite; `sd_kpa` (C,) how far each pressure could move if what remains were chance; `iterations` over all
    `starts`; `time_s` of the search, `prepare_s` of the target, `compile_s` of numba beside both; `inverted` if the
    target's triangles face inwards, which is allowed for.
    """

    chamber_names: tuple[str, ...]
    pressure_kpa: Floats
    rotation: Floats
    translation_mm: Floats
    mean_mm: float
    p95_mm: float
    max_mm: float
    share: float
    signed_mm: Floats
    uv: Floats
    sd_kpa: Floats
    limited: tuple[str, ...]
    iterations: int
    starts: int
    time_s: float
    prepare_s: float
    history: tuple[tuple[float, float], ...] = ()
    inverted: bool = False
    notes: tuple[str, ...] = field(default=())
    gap_facts: tuple[Any, ...] = field(default=(), repr=False)
    compile_s: float = 0.0

    def __repr__(self) -> str:
        kpa = ", ".join(f"{n} {p:.4g}" for n, p in zip(self.chamber_names, self.pressure_kpa, strict=True))
        return f"IkResult: mean {self.mean_mm:.3g} mm, 95 % within {self.p95_mm:.3g} mm, at {kpa} kPa"

    @cached_property
    def gaps(self) -> tuple[Gap, ...]:
        """Where the surface stays away from the target by more than 2 mm, the worst first."""
        if not self.gap_facts:
            return ()
        points, influence, limits = self.gap_facts
        return find_gaps(self.signed_mm, self.uv, points, influence, self.chamber_names, limits)

    def to_target(self, points_mm: Floats) -> Floats:
        """Points (..., 3) of the rig in the target's frame."""
        return (points_mm - self.translation_mm) @ self.rotation

    def to_dict(self) -> SolvedShape:
        """The result as plain values, without the distances point by point."""
        return {
            "pressure_kpa": dict(
                zip(self.chamber_names, np.round(self.pressure_kpa, 4).tolist(), strict=True)
            ),
            "sd_kpa": dict(zip(self.chamber_names, _rounded(self.sd_kpa), strict=True)),
            "at_limit": list(self.limited),
            "rotation": np.round(self.rotation, 9).tolist(),
            "translation_mm": np.round(self.translation_mm, 4).tolist(),
            "distance_mm": {
                "mean": _number(self.mean_mm),
                "p95": _number(self.p95_mm),
                "max": _number(self.max_mm),
            },
            "share": round(self.share, 4),
            "iterations": self.iterations,
            "starts": self.starts,
            "time_ms": round(1e3 * self.time_s, 2),
            "prepare_ms": round(1e3 * self.prepare_s, 2),
            "compile_ms": round(1e3 * self.compile_s, 2),
            "gaps": [
                {
                    "depth_mm": _number(gap.depth_mm),
                    "middle_mm": [_number(x) for x in gap.middle_mm],
                    "uv": [_number(x) for x in gap.uv],
                    "area_share": round(gap.area_share, 4),
                    "chamber": gap.chamber,
                    "limit": gap.limit,
                    "words": gap.words,
                }
                for gap in self.gaps
            ],
            "inverted": self.inverted,
            "notes": list(self.notes),
        }


def _number(value: float) -> float | None:
    return round(float(value), 4) if np.isfinite(value) else None


def _rounded(values: Floats) -> list[float | None]:
    return [_number(value) for value in values]
