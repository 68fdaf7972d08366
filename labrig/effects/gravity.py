"""Gravity: weight and payload pull the surface down."""

from collections.abc import Iterator

import numpy as np

from labrig.effects._context import Context
from labrig.effects._effect import Effect, Parameter, Term, Variant
from labrig.effects._inside import inside
from labrig.effects._rows import Floats

_NEWTON = 1 / 9.80665
_PAYLOAD = {
    **dict.fromkeys(("kg", "kilogram"), 1.0),
    **dict.fromkeys(("g", "gram"), 1e-3),
    **dict.fromkeys(("N", "newton"), _NEWTON),
    "mN": 1e-3 * _NEWTON,
}
"""Units of a payload, in kg (of a force: of the mass that weighs so much)."""
_ANGLE = {"deg": np.pi / 180, "degree": np.pi / 180, "rad": 1.0, "radian": 1.0}


class Gravity(Effect):
    name = "gravity"
    meaning = (
        "The body sags under its own weight and under what it carries; the sag follows the\n"
        "orientation of the base and gives way where the surface is compliant."
    )
    acts_on = "mechanics"
    parameters = (
        Parameter(
            "sag", "observable", meaning="sag by sine, cosine of the tilt and alone, for each observable"
        ),
        Parameter("payload", "observable/kg", meaning="sag for each kg of payload, for each observable"),
        Parameter("acceleration", "m/s^2", -40.0, 40.0, meaning="surplus of the simulator's gravity"),
        Parameter("weight", "1", meaning="sag of a point for each unit of its compliance, along one axis"),
        Parameter("load", "1/kg", meaning="the same for each kg of payload"),
    )
    reference = "S. P. Timoshenko, S. Woinowsky-Krieger, Theory of Plates and Shells, 2nd ed. 1959"
    signature = (
        "error along one direction of space that follows payload or orientation, larger where compliant"
    )
    experiment = "the same set-points with the base turned, or with a payload"
    shows_in = "place"

    def variants(self, context: Context) -> Iterator[Variant]:
        loads, tilts = [], []
        for name, cov in context.rows.covariates.items():
            known = np.isfinite(cov.values).all() and context.shows(np.ptp(cov.values) > 0)
            if known and cov.unit in _PAYLOAD and ("load" in name.lower() or "mass" in name.lower()):
                loads.append(cov.values * _PAYLOAD[cov.unit])
            if known and cov.unit in _ANGLE and name.lower() in {"tilt", "orientation", "angle"}:
                angle = cov.values * _ANGLE[cov.unit]
                tilts += [np.sin(angle), np.cos(angle)]
        compliant = context.rows.rest_mm is not None and context.shows(context.moves)
        if loads or tilts:
            yield Variant("payload or tilt", _patterns({"sag": tilts, "payload": loads}))
            if context.base_kind != "static":  # a static map has a constant of its own
                own = _patterns({"sag": [*tilts, np.ones(len(context.base))], "payload": loads})
                yield Variant("own weight too", own)
                if compliant:
                    along = np.stack([yielding for _, yielding in self._yielding(context)], axis=-1)
                    fields = [
                        (along[..., None] * term.feature[:, None, None]).reshape(*along.shape[:2], -1)
                        for term in own
                    ]
                    more = [Term.field(n, x) for n, x in zip(("weight", "load"), fields, strict=False)]
                    yield Variant("own weight too, more where compliant", (*own, *more))
            if not context.saved:
                return
        if not compliant:
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


def _patterns(features: dict[str, list[Floats]]) -> tuple[Term, ...]:
    """A free pattern for each parameter that has features at all."""
    return tuple(Term.pattern(name, np.stack(x, axis=1)) for name, x in features.items() if x)
