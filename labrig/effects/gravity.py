"""Gravity: weight and payload pull the surface down."""

from collections.abc import Collection, Iterator
from functools import partial

import numpy as np

from labrig.arrays import Floats
from labrig.effects._context import Context
from labrig.effects._effect import Effect, Parameter, Term, Variant
from labrig.effects._family import Space, acting, by_covariate, field, motion_scale, pattern, pressure
from labrig.effects._fields import frame_modes
from labrig.effects._in_parts import another_bend_in_each, another_in_each, poses_of
from labrig.effects._inside import inside
from labrig.effects._logged import is_payload, is_tilt, payloads_kg, tilts_rad
from labrig.effects._sign import Part, Sign, along_own, by_capture, held
from labrig.effects._weights import is_family

_WHERE_COMPLIANT = {"sag": "weight", "payload": "weight_per_kg", "tilt": "weight_by_tilt"}
_SPACES = {"what gives": ("pressure", "field"), "anywhere": ("pattern",)}
_FREE = 1.0
"""Prior variance of a sag whose shape over the body is free: weights may sit anywhere."""
_OPEN = 0.05
"""Share of the range from which a wall is off its seat: a grid."""


class Gravity(Effect):
    name = "gravity"
    meaning = (
        "The body sags under its own weight and under what it carries; the sag follows the\n"
        "orientation of the base and gives way where the surface is compliant."
    )
    acts_on = "mechanics"
    parameters = (
        Parameter("sag", "observable", meaning="sag under its own weight, for each observable"),
        Parameter("payload", "observable/kg", meaning="sag under each kg that it carries"),
        Parameter("tilt", "observable", meaning="sag by the sine and the cosine of the tilt"),
        Parameter("acceleration", "m/s^2", -40.0, 40.0, meaning="surplus of the simulator's gravity"),
        Parameter("weight", "1", meaning="sag of a point for each unit of its compliance, along one axis"),
        Parameter("weight_per_kg", "1/kg", meaning="the same for each kg of payload"),
        Parameter("weight_by_tilt", "1", meaning="the same by the sine and the cosine of the tilt"),
        Parameter("held_per_kg", "actuation/kg", per="chamber", meaning="pressure that each kg is worth"),
        Parameter("held_by_sine", "actuation", per="chamber", meaning="the same by the sine of the tilt"),
        Parameter("held_by_cosine", "actuation", per="chamber", meaning="by its cosine, since upright"),
    )
    reference = "S. P. Timoshenko, S. Woinowsky-Krieger, Theory of Plates and Shells, 2nd ed. 1959"
    signature = (
        "error along one direction of space that follows payload or orientation, larger where compliant"
    )
    experiment = "the same set-points with the base turned, or with a payload, and then as before again"
    needs = "markers, or a tilt or a payload that was logged"
    by_hand = "turn the base (or put a known payload on it) and log the angle"
    then_measured = True

    def variants(self, context: Context) -> Iterator[Variant]:
        loads = [kg for _, kg in payloads_kg(context)]
        tilts = [way for _, angle in tilts_rad(context) for way in (np.sin(angle), np.cos(angle))]
        placed = (context.rows.marker >= 0) & (context.rows.axis >= 0)
        compliant = bool(placed.any()) and context.shows(context.moves)
        both = {"payload": loads, "tilt": tilts}
        # what a saved effect has no values for was not logged, or did not change, when it was fitted
        for one in (both, {"payload": loads}, {"tilt": tilts}) if context.saved else (both,):
            yield from self._carried(context, {name: x for name, x in one.items() if x}, compliant)
            if context.shows(context.moves):
                yield from _against_pressures(context, one)
        if ((loads or tilts) and not context.saved) or not compliant:
            return
        yield from inside(context, acceleration="gravity_")
        for letter, along in self._yielding(context):
            yield Variant(f"own weight along {letter}", (Term.field("weight", along),))

    def _carried(
        self, context: Context, features: dict[str, list[Floats]], compliant: bool
    ) -> Iterator[Variant]:
        """The forms in which payloads, kg, and tilts (sine and cosine) matter."""
        if not features:
            return
        yield Variant("payload or tilt", _patterns(features))
        if context.base_kind == "static":  # a static map has a constant of its own
            return
        own = _patterns({"sag": [np.ones(len(context.base))], **features})
        yield Variant("own weight too", own)
        if compliant:
            along = np.stack([yielding for _, yielding in self._yielding(context)], axis=-1)
            more = [
                Term.field(_WHERE_COMPLIANT[term.parameter], _products(along, term.feature)) for term in own
            ]
            yield Variant("own weight too, more where compliant", (*own, *more))

    def lacks(self, context: Context, form: str, parameters: Collection[str]) -> str:
        logged = context.rows.covariates.items()
        if is_family(form):  # the names of its functions say what it pulls by
            loaded = any(n.startswith("load") for n in parameters) and not any(
                is_payload(*each) for each in logged
            )
            turned = any("sine" in n for n in parameters) and not any(is_tilt(*each) for each in logged)
            return " and ".join(["the payload"] * loaded + ["the tilt"] * turned)
        by = {
            "the payload": ("payload", "weight_per_kg", "held_per_kg"),
            "the tilt": ("tilt", "weight_by_tilt", "held_by_sine", "held_by_cosine"),
        }
        return " and ".join(what for what, names in by.items() if set(names) & set(parameters))

    def family(self, context: Context) -> Iterator[Space]:
        """Sag along each axis under the body's own weight, and under payload and tilt where these were logged."""
        rows = context.rows
        loads = _pulls(context)
        has_axis = (rows.axis >= 0).sum() >= 3 and (rows.marker >= 0).any()
        out = [pattern(name, values, _FREE) for name, values in loads]
        if context.moves:
            whole = [(n, np.repeat(v[:, None], len(rows.chambers), axis=1)) for n, v in loads]
            out += [pressure(f"{n} held", v, 0.3) for n, v in whole]
            out += [pressure(f"{n} held load", v * rows.fraction, 0.3) for n, v in whole]
        if has_axis and context.moves and context.jacobian.any():
            scale = motion_scale(context)
            give = np.abs(context.jacobian * context.span).sum(axis=2)
            for m in np.unique(rows.marker[rows.marker >= 0]):
                own = rows.marker == m
                give[:, own] = give[:, own].mean(axis=1, keepdims=True)
            give = give / context.yardstick("give", partial(_size, give)) * scale
            ways = [("own", np.ones(len(give)), 1.0)] + [(n, v, 1.0) for n, v in loads]
            modes = frame_modes(context)
            size = context.yardstick("motions of the body", partial(_size, modes, (0, 1)))
            modes = modes / (size + 1e-12) * scale[:, None]
            for way, factor, weight in ways[1:]:  # a motion as one body by the own weight is the frame's
                out += [
                    field(f"{way} body {j}", modes[:, :, j] * factor[:, None], 0.25 * weight)
                    for j in range(6)
                ]
            for way, factor, weight in ways:
                for a, letter in enumerate("xyz"):
                    own = rows.axis == a
                    out.append(
                        field(f"{way} {letter} give", np.where(own, give, 0.0) * factor[:, None], weight)
                    )
        for name, kinds in _SPACES.items():
            some = [f for f in out if f.kind in kinds or "body" in f.name]
            if some:
                yield Space(name, f"gravity {name}", acting(some))
        if context.moves and loads:
            yield from _lifted(context, loads)
            more = [f for name, values in loads for f in by_covariate(context, name, values)]
            yield Space("anywhere, by the load", "gravity by the load", acting(more))
        if has_axis and (pose := poses_of([v for _, v in loads])) is not None:
            yield another_in_each(context, pose)
            yield another_bend_in_each(context, pose)
        body = [f for f in out if "body" in f.name]
        if body:
            yield Space("as one body", "gravity as one body", acting(body))

    def follows(self, context: Context) -> Collection[str]:
        return [n for n, c in context.rows.covariates.items() if is_tilt(n, c) or is_payload(n, c)]

    def sign(self, context: Context, part: Part) -> Sign:
        """Against payload or tilt, where it follows them; else against how far the pressures move each marker."""
        for name, cov in context.rows.covariates.items():
            if is_payload(name, cov) or is_tilt(name, cov):
                return along_own(context, part, cov.values, name, cov.unit)
        return self._by_compliance(context, part)

    def _by_compliance(self, context: Context, part: Part) -> Sign:
        one = by_capture(context, part)
        size = [np.nansum(one.change[:, context.rows.axis == a] ** 2) for a in range(3)]
        axis = int(np.argmax(size))
        along = held(context, list(self._yielding(context))[axis][1])
        known = np.isfinite(one.left) & (context.rows.axis == axis)
        unit = context.rows.unit[int(np.flatnonzero(context.rows.axis == axis)[0])]
        return Sign(
            "how far full pressures move the marker",
            unit,
            f"error along {'xyz'[axis]}",
            unit,
            along[known],
            one.seen[known],
            one.change[known],
            one.weight[known],
            np.full(int(known.sum()), ""),
        )

    @staticmethod
    def _yielding(context: Context) -> Iterator[tuple[str, Floats]]:
        """How far each observable gives way to a weight along x, y and z, as the surface is inflated, (F, K)."""
        compliance = np.abs(context.jacobian).sum(axis=2)
        for m in np.unique(context.rows.marker[context.rows.marker >= 0]):
            own = context.rows.marker == m
            compliance[:, own] = compliance[:, own].mean(axis=1, keepdims=True)
        for a, letter in enumerate("xyz"):
            along = np.where(context.rows.axis == a, compliance, 0.0) * np.abs(context.span).mean()
            yield letter, along


def _against_pressures(context: Context, features: dict[str, list[Floats]]) -> Iterator[Variant]:
    """What is carried bends the body as a change of its pressures would, each chamber's by an own amount: in a body
    that its pressures bend everywhere, both are moments (D. C. Rucker, R. J. Webster, IEEE Trans. Robotics 27, 2011).

    No form where several payloads or tilts were logged.
    """
    loads, tilts = (features.get(name, []) for name in ("payload", "tilt"))
    if len(loads) > 1 or len(tilts) > 2 or not loads + tilts:
        return
    pulls = {"held_per_kg": loads[0]} if loads else {}
    if tilts:
        sine, cosine = tilts
        pulls |= {"held_by_sine": sine, "held_by_cosine": cosine - 1}
    names = context.rows.chambers
    terms = [
        Term.per_chamber(name, np.repeat(pull[:, None], len(names), axis=1), names)
        for name, pull in pulls.items()
    ]
    yield Variant("payload or tilt, against the pressures", tuple(terms))


def _pulls(context: Context) -> list[tuple[str, Floats]]:
    """What weights pull by, as far as it was logged: payload, tilt by sine and cosine, and the payload turned with it.

    The cosine is there twice: all of it where the base knows no weight, its change where it was fitted upright.
    """
    loads, tilts = [], []
    for _, kg in payloads_kg(context):
        loads.append(("load", kg / context.yardstick("heaviest load, kg", np.abs(kg).max)))
    for _, angle in tilts_rad(context):
        tilts += [("sine", np.sin(angle)), ("cosine", np.cos(angle))]
    turned = [(f"{one} {way}", load * along) for one, load in loads for way, along in tilts]
    since = [("cosine since upright", along - 1) for way, along in tilts if way == "cosine"]
    return [*loads, *tilts, *since, *turned]


def _lifted(context: Context, loads: list[tuple[str, Floats]]) -> Iterator[Space]:
    """A weight takes a share of all motions; or each wall lifts it by an arm that grows, once it is off its seat."""
    x = context.rows.fraction
    yield Space(
        "the whole way",
        "gravity the whole way",
        acting([field(name, pull[:, None] * context.displacement) for name, pull in loads]),
    )
    walls = [("", np.tanh(x / _OPEN), 1.0), (" load", x, 1.0), (" square", x * np.abs(x), 0.3)]
    lifts = [
        pressure(f"{name}{how}", pull[:, None] * wall, w) for name, pull in loads for how, wall, w in walls
    ]
    yield Space("what each wall lifts", "gravity lifted", acting(lifts), 0.5)


def _size(values: Floats, axes: tuple[int, ...] | None = None) -> Floats:
    return np.sqrt((values**2).mean(axis=axes))


def _products(along: Floats, features: Floats) -> Floats:
    """Each way to yield (F, K, 3) by each feature (F, q), (F, K, 3 q)."""
    return (along[..., None] * features[:, None, None]).reshape(*along.shape[:2], -1)


def _patterns(features: dict[str, list[Floats]]) -> tuple[Term, ...]:
    """A free pattern for each parameter that has features at all."""
    return tuple(Term.pattern(name, np.stack(x, axis=1)) for name, x in features.items() if x)
