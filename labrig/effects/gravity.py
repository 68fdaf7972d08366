"""Gravity: weight and payload pull the surface down."""

from collections.abc import Iterator

import numpy as np

from labrig.effects._context import Context
from labrig.effects._effect import Effect, Parameter, Term, Variant
from labrig.effects._inside import inside
from labrig.effects._rows import Floats

_PAYLOAD = {"kg", "g", "gram", "kilogram", "N", "newton", "mN"}
_ANGLE = {"deg": np.pi / 180, "degree": np.pi / 180, "rad": 1.0, "radian": 1.0}


class Gravity(Effect):
    name = "gravity"
    meaning = (
        "The body sags under its own weight and under what it carries; the sag follows the\n"
        "orientation of the base and gives way where the surface is compliant."
    )
    acts_on = "mechanics"
    parameters = (
        Parameter("sag", "observable", meaning="sag at the largest payload or tilt, for each observable"),
        Parameter("acceleration", "m/s^2", -40.0, 40.0, meaning="surplus of the simulator's gravity"),
        Parameter("weight", "1", meaning="sag of a point for each unit of its compliance, along one axis"),
    )
    reference = "S. P. Timoshenko, S. Woinowsky-Krieger, Theory of Plates and Shells, 2nd ed. 1959"
    signature = (
        "error along one direction of space that follows payload or orientation, larger where compliant"
    )
    experiment = "the same set-points with the base turned, or with a payload"
    shows_in = "place"

    def variants(self, context: Context) -> Iterator[Variant]:
        features = []
        for name, cov in context.rows.covariates.items():
            known = np.isfinite(cov.values).all() and np.ptp(cov.values) > 0
            if known and cov.unit in _PAYLOAD and ("load" in name.lower() or "mass" in name.lower()):
                features.append(cov.values / np.abs(cov.values).max())
            if known and cov.unit in _ANGLE and name.lower() in {"tilt", "orientation", "angle"}:
                angle = cov.values * _ANGLE[cov.unit]
                features += [np.sin(angle), np.cos(angle)]
        if features:
            loads = np.stack(features, axis=1)
            yield Variant("payload or tilt", (Term.pattern("sag", loads),))
            if context.base_kind != "static":  # a static map has a constant of its own
                own = np.column_stack([loads, np.ones(len(loads))])
                yield Variant("own weight too", (Term.pattern("sag", own),))
                if context.rows.rest_mm is not None and context.moves:
                    along = np.stack([yielding for _, yielding in self._yielding(context)], axis=-1)
                    fields = (along[..., None] * own[:, None, None]).reshape(*along.shape[:2], -1)
                    yield Variant(
                        "own weight too, more where compliant",
                        (Term.pattern("sag", own), Term.field("weight", fields)),
                    )
            return
        if context.rows.rest_mm is None or not context.moves:
            return
        yield from inside(context, acceleration="gravity_")
        for letter, along in self._yielding(context):
            yield Variant(f"own weight along {letter}", (Term.field("weight", along),))

    @staticmethod
    def _yielding(context: Context) -> Iterator[tuple[str, Floats]]:
        """How far each observable gives way to a weight along x, y and z, as the surface is inflated, (F, K)."""
        compliance = np.abs(context.jacobian).sum(axis=2)
        for m in np.unique(context.rows.marker[context.rows.marker >= 0]):
            own = context.rows.marker == m
            compliance[:, own] = compliance[:, own].mean(axis=1, keepdims=True)
        for a, letter in enumerate("xyz"):
            along = np.where(context.rows.axis == a, compliance, 0.0) * context.span.mean()
            yield letter, along
