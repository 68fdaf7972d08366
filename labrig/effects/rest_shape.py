"""Rest shape: the unloaded geometry is not the model's."""

from collections.abc import Iterator
from functools import partial

import numpy as np

from labrig.arrays import Floats
from labrig.effects._context import Context
from labrig.effects._effect import Effect, Parameter, Term, Variant
from labrig.effects._family import Feature, Space, acting, field, motion_scale, pattern
from labrig.effects._fields import smooth_places
from labrig.effects._in_parts import bends
from labrig.effects._inside import inside
from labrig.effects._obstacles import to_rows
from labrig.effects._sessions import IN_EACH, in_sessions, labels
from labrig.effects._sign import Part, Sign, along_own

_HELD = 0.1
"""A marker that moves by less than so much of what the farthest does is held."""
_LEFT = 0.02
"""A smooth field of which rigid motions leave less is one; numerical."""
_HUMP = 0.4
"""How far places belong together, share of the body's size (root mean square): a grid of one."""
_FOOT = 5
"""One marker of so many, those that move least, are where a body is held: a grid."""


class RestShape(Effect):
    name = "rest_shape"
    meaning = (
        "The surface was made or mounted otherwise than modelled: each point is off by its own\n"
        "constant amount that no rigid motion removes."
    )
    acts_on = "mechanics"
    blurred_by = frozenset({"one side"})
    parameters = (
        Parameter("offset", "observable", meaning="constant error, for each observable"),
        Parameter(
            "offset_in_session",
            "observable",
            per="session",
            meaning="constant error, another in each session",
        ),
        Parameter("core", "mm", -10.0, 10.0, meaning="surplus of the simulator's core, along its normals"),
    )
    reference = "Y. Tian et al., RSS 2024, arXiv 2405.08935 (rest shape as source of the sim-to-real gap)"
    signature = "the same error in every capture, at every pressure and time, different from point to point"
    experiment = "one scan of the vented surface"
    by_hand = "scan the vented surface once"

    def variants(self, context: Context) -> Iterator[Variant]:
        yield from inside(context, core="core_offset")
        yield Variant("offset", (Term.pattern("offset", np.ones(len(context.base))),))
        if (each := in_sessions(context)) is not None:
            own = Term.pattern("offset_in_session", each, labels(context))
            yield Variant(f"offset{IN_EACH}", (own,))

    def family(self, context: Context) -> Iterator[Space]:
        """A constant offset of each observable; offsets that are smooth over the body are more probable.

        Also a body that is smaller, longer or sheared as a whole, about its middle or the end that moves least; bent as
        a whole, to a dome or a saddle, wherever it lies; with humps; and off the more the farther it moves: where it is
        held it can't be, and there may be markers, too.
        """
        smooth = dict(_smooth(context))
        always = np.ones(len(context.base))

        def bent(name: str, there: Floats) -> list[Feature]:
            return [field(f"smooth {i}{name}", there[:, None] * shape, 0.1) for i, shape in smooth.items()]

        def shapes(name: str, there: Floats) -> list[Feature]:
            return [pattern(f"rest{name}", there, 0.2), *bent(name, there)]

        yield Space("shape", "rest_shape", tuple(shapes("", always)))
        yield from _strained(context)
        if here := _humps(context):
            yield Space("humps", "rest_shape humps", acting(here))
        yield Space("bent", "rest_shape bent", tuple(bent("", always)))
        if placed := list(bends(context)):
            yield Space("bent, and placed otherwise", "rest_shape placed", acting(placed))
        if (free := _where_free(context)) is not None:
            yield free
        if (each := in_sessions(context)) is not None:
            own = [f for s, there in enumerate(each.T) for f in shapes(f" session {s}", there)]
            yield Space("by session", "rest_shape by session", acting(own))

    def covariate(self, context: Context) -> tuple[str, str, Floats]:
        return ("capture", "1", context.rows.capture.astype(float))

    def sign(self, context: Context, part: Part) -> Sign:
        load = context.rows.actuation.mean(axis=1)
        return along_own(context, part, load, "mean pressure", context.rows.actuation_unit)


def _smooth(context: Context) -> Iterator[tuple[int, Floats]]:
    """Smooth fields over the body (K,), by number, without what rigid motions of all markers make: the frame."""
    fields, rest = smooth_places(context), context.rows.rest_mm
    if rest is not None and fields.shape[1]:
        place = (rest - rest.mean(axis=0)) / np.maximum(
            np.sqrt(((rest - rest.mean(axis=0)) ** 2).mean()), 1e-12
        )
        axes = np.eye(3)
        shifts, turns = np.broadcast_to(axes[:, None], (3, *place.shape)), np.cross(axes[:, None], place)
        rigid = to_rows(context, np.concatenate([shifts, turns]).astype(np.float64)).T
        fields = fields - rigid @ np.linalg.lstsq(rigid, fields, rcond=1e-6)[0]
    for i, shape in enumerate(fields.T):
        if np.sqrt((shape**2).mean()) > _LEFT:
            yield i, motion_scale(context) * shape


def _humps(context: Context) -> list[Feature]:
    """Smooth shapes over the body at rest, as likely as a Gaussian process has them whose places belong together up to
    `_HUMP`, along each axis (C. E. Rasmussen, C. K. I. Williams, Gaussian Processes for Machine Learning, 2006, ch. 4).
    """
    rows = context.rows
    own = (rows.marker >= 0) & (rows.axis >= 0)
    if rows.rest_mm is None or not np.isfinite(rows.rest_mm).all() or own.sum() < 9:
        return []
    place = rows.rest_mm - rows.rest_mm.mean(axis=0)
    size = np.sqrt((place**2).sum(axis=1).mean())
    if size <= 0:
        return []
    apart = np.linalg.norm(place[:, None] - place, axis=2) / size
    power, shapes = np.linalg.eigh(np.exp(-0.5 * (apart / _HUMP) ** 2))
    scale, out = motion_scale(context), []
    for i in np.flatnonzero(power > _LEFT * power.max())[::-1]:
        for a in range(3):
            there = np.zeros(len(rows.marker))
            mine = own & (rows.axis == a)
            there[mine] = shapes[rows.marker[mine], i] * np.sqrt(len(place))
            out.append(
                field(
                    f"hump {i} {'xyz'[a]}",
                    np.tile(scale * there, (len(context.base), 1)),
                    power[i] / power.max(),
                )
            )
    return out


def _where_free(context: Context) -> Space | None:
    """Offsets along each axis, as large at each marker as full pressures move it; None unless some markers move and
    others are held: where all move alike, that is the frame.
    """
    rows = context.rows
    own = (rows.marker >= 0) & (rows.axis >= 0)
    if own.sum() < 3 or not context.moves:
        return None
    each = partial(np.mean, np.abs(context.jacobian * context.span).sum(axis=2), axis=0)
    reach = context.yardstick("reach", each).copy()
    for m in np.unique(rows.marker[own]):
        reach[rows.marker == m] = reach[rows.marker == m].mean()
    size = float(np.sqrt((reach[own] ** 2).mean()))
    if not context.shows(reach[own].min() < _HELD * reach[own].max()):
        return None
    scale, out = motion_scale(context), []
    for a in range(3):
        along = np.where(own & (rows.axis == a), scale * reach / size, 0.0)
        out.append(field(f"free {'xyz'[a]}", np.tile(along, (len(context.base), 1))))
    return Space("where it is free", "rest_shape free", acting(out))


def _strained(context: Context) -> Iterator[Space]:
    """A body of another size, or skew, about its middle or about the places that move least: six strains."""
    rows = context.rows
    rest, own = rows.rest_mm, np.flatnonzero((rows.marker >= 0) & (rows.axis >= 0))
    if rest is None or not np.isfinite(rest).all() or len(own) < 9:
        return
    travel = np.zeros(len(rest))
    np.maximum.at(travel, rows.marker[own], np.abs(context.displacement[:, own]).max(axis=0))
    still = np.argsort(travel, kind="stable")[: max(3, len(rest) // _FOOT)]
    foot = context.yardstick("foot", lambda: rest[still].mean(axis=0))
    scale = motion_scale(context)
    for name, centre in (("middle", rest.mean(axis=0)), ("foot", foot)):
        place = rest - centre

        def strained(of: str, strain: Floats, place: Floats = place) -> Feature:
            less = np.zeros(len(rows.marker))
            less[own] = (place @ strain)[rows.marker[own], rows.axis[own]]
            size = float(np.sqrt((less[own] ** 2).mean()))
            flat = size <= 1e-6 * (1e-9 + np.abs(place).max())
            there = scale * (0.0 if flat else less / size)
            return field(f"strain {of}", np.tile(there, (len(context.base), 1)))

        E = np.eye(3)
        each = [
            strained("xyz"[b] + "xyz"[a], np.maximum(np.outer(E[a], E[b]), np.outer(E[b], E[a])))
            for a in range(3)
            for b in range(a + 1)
        ]
        yield Space(f"strained about its {name}", "rest_shape strained", acting(each))
        yield Space(f"of another size about its {name}", "rest_shape sized", acting([strained("all", E)]))
