"""Bodies that blind campaigns are drawn from, and the base models that go with them.

A body is described by a recipe (a plain dict), so that a base model can be rebuilt from a file.
"""

from collections.abc import Callable
from dataclasses import replace
from typing import Any

import numpy as np
from numpy.typing import NDArray

from labrig._errors import LabrigError
from labrig.physics import Surface, reduced_surface

Array = NDArray[np.float64]


class SurfaceBody:
    """Some chambers of one of labrig's surfaces; the others stay vented.

    With `linear`, deflections are proportional to pressure and markers move along their normals only, so
    that a static map of degree 1 is the whole truth.
    """

    axes: tuple[int, ...] = (0, 1, 2)
    unit = "mm"

    def __init__(self, surface: Surface, active: list[int], linear: bool = False) -> None:
        self.surface = surface
        self.active = list(active)
        self.linear = linear
        self.chamber_names = tuple(surface.chamber_names[c] for c in active)
        self.marker_names = surface.marker_names
        self.rest_mm = surface.rest_mm
        self.normal = surface.normal
        self.weight = surface.weight[:, active]
        self.compliance_mm_per_kpa = surface.compliance_mm_per_kpa[active] * (0.7 if linear else 1.0)
        self.limit_mm = surface.limit_mm[active] * (1e3 if linear else 1.0)

    def deflection_mm(self, pressure_kpa: Array) -> Array:
        """Deflections (..., C) of the active chambers."""
        if self.linear:
            return self.compliance_mm_per_kpa * np.asarray(pressure_kpa, dtype=float)
        whole = np.zeros((*np.shape(pressure_kpa)[:-1], len(self.surface.chamber_names)))
        whole[..., self.active] = pressure_kpa
        return self.surface.deflection_mm(whole)[..., self.active]

    def shape_mm(self, deflection_mm: Array) -> Array:
        """Marker positions (F, M, 3)."""
        if self.linear:
            return self.rest_mm + (deflection_mm @ self.weight.T)[..., None] * self.normal
        whole = np.zeros((len(deflection_mm), len(self.surface.chamber_names)))
        whole[:, self.active] = deflection_mm
        return self.surface.shape_mm(whole)


class CylinderBody:
    """A pneumatic actuator on a load cell: one force, N, and no geometry; one or two chambers push together.

    It is carried as one marker of which only x counts; 1 mm of it stands for 1 N.
    """

    axes: tuple[int, ...] = (0,)
    unit = "N"
    marker_names = ("force",)

    def __init__(self, chambers: int, linear: bool) -> None:
        self.linear = linear
        self.chamber_names = tuple(f"p{c + 1}" for c in range(chambers))
        self.rest_mm = np.zeros((1, 3))
        self.normal = np.array([[1.0, 0.0, 0.0]])
        self.weight = np.ones((1, chambers))
        self.compliance_mm_per_kpa = np.linspace(0.8, 0.6, chambers)
        self.limit_mm = np.full(chambers, 5e4 if linear else 50.0)

    def deflection_mm(self, pressure_kpa: Array) -> Array:
        """Force of each chamber, N, (..., C): the same law as a membrane's."""
        load = self.compliance_mm_per_kpa * np.asarray(pressure_kpa, dtype=float)
        scale = 2.0 * self.limit_mm / np.sqrt(3.0)
        return scale * np.sinh(np.arcsinh(1.5 * np.sqrt(3.0) * load / self.limit_mm) / 3.0)

    def shape_mm(self, deflection_mm: Array) -> Array:
        """The force as x of the only marker, (F, 1, 3)."""
        return (deflection_mm @ self.weight.T)[..., None] * self.normal


BenchBody = SurfaceBody | CylinderBody


def make_body(recipe: dict[str, Any]) -> BenchBody:
    """The body of a recipe: {kind: surface, surface, active, linear} or {kind: cylinder, chambers, linear}."""
    if recipe["kind"] == "cylinder":
        return CylinderBody(recipe["chambers"], recipe["linear"])
    if recipe["kind"] == "surface":
        surface = reduced_surface({"simulated": {"surface": recipe["surface"]}})
        return SurfaceBody(surface, recipe["active"], recipe["linear"])
    raise LabrigError(f"bench: there is no body '{recipe['kind']}' (surface or cylinder)")


def observed(body: BenchBody, position_mm: Array) -> Array:
    """The observables (R, K) among positions (R, M, 3)."""
    return position_mm[..., list(body.axes)].reshape(len(position_mm), -1)


def settled(body: BenchBody, pressure_kpa: Array) -> Array:
    """Observables (F, K) of the body at rest under pressures (F, C), with nothing hidden."""
    return observed(body, body.shape_mm(body.deflection_mm(np.asarray(pressure_kpa, dtype=float))))


def wrong_form(body: BenchBody, form: str, seed: int) -> Callable[[Array], Array]:
    """A model of the body that is wrong in form: `law` (a hyperbola for the cubic) or `spread` (other
    patches).
    """
    random = np.random.default_rng([seed, 11])
    if form == "spread" and isinstance(body, SurfaceBody):
        geometry = body.surface.geometry
        patches = tuple(
            replace(patch, u0=u0, u1=u1, v0=v0, v1=v1)
            for patch in geometry.patches
            for u0, u1, v0, v1 in [
                np.array([patch.u0, patch.u1, patch.v0, patch.v1]) + 0.02 * random.normal(size=4)
            ]
        )
        other = replace(geometry, patches=patches, edge=geometry.edge * random.uniform(1.2, 1.6))
        surface = Surface(other, body.surface.chamber_names, body.surface.marker_names)
        moved = SurfaceBody(surface, body.active, body.linear)
        return lambda pressure: settled(moved, pressure)
    bend = random.uniform(1.6, 2.6, len(body.chamber_names))
    scale = np.abs(body.deflection_mm(np.full(len(body.chamber_names), 60.0)))

    def hyperbola(pressure: Array) -> Array:
        load = body.compliance_mm_per_kpa * pressure
        return observed(body, body.shape_mm(load / (1.0 + np.abs(load) / (bend * scale))))

    return hyperbola


def make_base(recipe: dict[str, Any]) -> Callable[[Array], Array]:
    """The base model (F, C) -> (F, K) of a recipe: {body: ..., error: null or {form, seed, scale}}."""
    body = make_body(recipe["body"])
    error = recipe.get("error")
    if not error:
        return lambda actuation: settled(body, actuation)
    wrong = wrong_form(body, error["form"], error["seed"])

    def predict(actuation: Array) -> Array:
        right = settled(body, actuation)
        return right + error["scale"] * (wrong(actuation) - right)

    return predict


def own_error(recipe: dict[str, Any], pressure: Array) -> float:
    """Root mean square of what is wrong in the form of a recipe's base at pressures (F, C); no effect takes it away."""
    if not recipe.get("error"):
        return 0.0
    right = make_base({**recipe, "error": None})(pressure)
    return float(np.sqrt(np.mean((make_base(recipe)(pressure) - right) ** 2)))
