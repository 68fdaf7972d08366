"""The solid that a shell lies on: maps from (u, v) in the unit square to mm."""

from typing import Annotated, Literal

import numpy as np
from pydantic import BaseModel, ConfigDict, Field, model_validator

from labrig.arrays import Floats
from labrig.physics._quantity import Unit
from labrig.surface import Spline

Millimetres = Annotated[float, Unit("mm")]


class Section(BaseModel):
    """A part of a shell file: nothing unknown in it, nothing changed later."""

    model_config = ConfigDict(extra="forbid", frozen=True, allow_inf_nan=False)


class Ring(Section):
    """The girth is `by` larger around height `v` (0..1), over a distance of `width`."""

    v: float
    width: float = Field(gt=0)
    by: float


class Bump(Section):
    """The core stands out by `height` around (u, v), over a distance of `width`."""

    u: float
    v: float
    width: float = Field(gt=0)
    height: Millimetres


class TubeCore(Section):
    """The front of an upright elliptic tube: x across, y outwards, z up; `wrap_deg` of its circumference."""

    kind: Literal["tube"]
    width: Millimetres = Field(gt=0)
    depth: Millimetres = Field(gt=0)
    height: Millimetres = Field(gt=0)
    wrap_deg: float = Field(default=140.0, gt=0, lt=340)
    barrel: float = 0.0
    rings: tuple[Ring, ...] = ()
    bumps: tuple[Bump, ...] = ()

    def points_mm(self, u: Floats, v: Floats) -> Floats:
        """Points (..., 3), mm, at (u, v)."""
        angle = (u - 0.5) * np.deg2rad(self.wrap_deg)
        girth = 1.0 + self.barrel * np.sin(np.pi * v)
        for ring in self.rings:
            girth = girth + ring.by * np.exp(-(((v - ring.v) / ring.width) ** 2))
        out = 0.5 * self.depth * girth * np.cos(angle)
        for bump in self.bumps:
            out = out + bump.height * np.exp(-(((u - bump.u) ** 2 + (v - bump.v) ** 2) / bump.width**2))
        return np.stack([0.5 * self.width * girth * np.sin(angle), out, self.height * v], axis=-1)


class PlaneCore(Section):
    """A flat upright plate in the x-z plane that faces y."""

    kind: Literal["plane"]
    width: Millimetres = Field(gt=0)
    height: Millimetres = Field(gt=0)

    def points_mm(self, u: Floats, v: Floats) -> Floats:
        """Points (..., 3), mm, at (u, v)."""
        return np.stack([self.width * (u - 0.5), np.zeros_like(u), self.height * v], axis=-1)


class SplineCore(Section):
    """A B-spline surface: control points (n_u, n_v, 3), mm, written out or in a file (.npz); d/dv x d/du must
    point outwards.
    """

    kind: Literal["spline"]
    control_points: list[list[tuple[float, float, float]]]
    degree: int = Field(default=2, ge=1, le=5)

    @model_validator(mode="after")
    def _rectangular(self) -> "SplineCore":
        if len({len(row) for row in self.control_points}) != 1:
            raise ValueError("control_points must be n_u rows of n_v points each")
        if not np.isfinite(np.asarray(self.control_points)).all():
            raise ValueError("control_points must be finite")
        if min(len(self.control_points), len(self.control_points[0])) <= self.degree:
            raise ValueError("more control points than the degree are needed in each direction")
        return self

    def points_mm(self, u: Floats, v: Floats) -> Floats:
        """Points (..., 3), mm, at (u, v)."""
        control = np.asarray(self.control_points, dtype=float)
        spline = Spline((control.shape[0], control.shape[1]), self.degree)
        return spline.evaluate(control, np.stack([u.ravel(), v.ravel()], axis=1)).reshape(*u.shape, 3)


Core = Annotated[TubeCore | PlaneCore | SplineCore, Field(discriminator="kind")]
