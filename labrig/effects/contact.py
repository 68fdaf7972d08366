"""Contact: a limit is reached and the motion stops there."""

from collections.abc import Iterator

import numpy as np

from labrig.effects._context import Context
from labrig.effects._effect import Effect, Parameter, Term, Variant
from labrig.effects._family import Space, acting, field, pressure
from labrig.effects._inside import FORM, inside
from labrig.effects._rows import Floats
from labrig.effects._sign import Part, Sign, by_chamber, by_marker


class Contact(Effect):
    name = "contact"
    meaning = (
        "Beyond some point the surface (or a piston, or the core) meets something and is stopped:\n"
        "nothing below the limit, and a growing error above it."
    )
    acts_on = "mechanics"
    parameters = (
        Parameter(
            "stopped",
            "1",
            0.0,
            1.5,
            "chamber",
            "share of the motion beyond the limit that is lost",
            least=0.25,
        ),
        Parameter(
            "stiffness", "kPa/mm", -100.0, 1000.0, meaning="surplus of the simulator's contact stiffness"
        ),
        Parameter(
            "limit",
            "1",
            0.0,
            1.0,
            meaning="where the limit lies, fraction of the range (or of the deflection at full range)",
        ),
        Parameter("distance", "observable", 0.0, meaning="how far from the vented place the limit lies"),
        Parameter("chamber", "1", 0.0, meaning="the only chamber that is stopped, counted from 0"),
    )
    reference = (
        "P. Wriggers, Computational Contact Mechanics, 2nd ed. Springer 2006, ch. 2 (unilateral contact)"
    )
    signature = "a kink: no error below a pressure or a position, error in proportion to the excess above it"
    experiment = "small steps of one chamber around the limit"

    def variants(self, context: Context) -> Iterator[Variant]:
        if not context.shows(context.moves):
            return
        yield from inside(context, stiffness="contact_")
        x, chambers = context.rows.fraction, context.rows.chambers
        for limit in context.grid("limit", (0.4, 0.5, 0.6, 0.7, 0.8, 0.9)):
            beyond = -np.maximum(x - limit, 0.0) * context.span
            if not context.shows((beyond < 0).mean() >= 0.02):
                continue
            yield Variant("pressure", (Term.common("stopped", beyond),), {"limit": limit})
            if len(chambers) > 1:
                yield Variant(
                    "per chamber", (Term.per_chamber("stopped", beyond, chambers),), {"limit": limit}
                )
                for c in context.grid("chamber", range(len(chambers))):
                    alone = np.where(np.arange(len(chambers)) == c, beyond, 0.0)
                    if context.shows((alone < 0).any()):
                        shape = {"limit": limit, "chamber": float(c)}
                        yield Variant("one chamber", (Term.common("stopped", alone),), shape)
        for limit in context.grid("limit", (0.3, 0.45, 0.6, 0.75)):
            beyond = -np.maximum(context.deflection - limit, 0.0) * context.span
            if context.shows((beyond < 0).mean() >= 0.02) and len(chambers) > 1:
                yield Variant("deflection", (Term.common("stopped", beyond),), {"limit": limit})
                yield Variant(
                    "deflection per chamber",
                    (Term.per_chamber("stopped", beyond, chambers),),
                    {"limit": limit},
                )
        yield from self._positions(context)

    def _positions(self, context: Context) -> Iterator[Variant]:
        """The limit as a distance travelled, and as a wall across each axis."""
        far = float(context.travel.max())
        if not context.shows(far > 0):
            return
        for distance in context.grid("distance", [share * far for share in (0.3, 0.45, 0.6, 0.75, 0.9)]):
            scale = np.maximum(0.0, 1 - distance / np.maximum(context.travel, 1e-12))
            term = Term.field("stopped", -context.displacement * scale)
            yield Variant("travel", (term,), {"distance": distance})
        for a, letter in enumerate("xyz"):
            own = context.rows.axis == a
            moved = context.displacement[:, own]
            if moved.size == 0:
                continue
            for side in (1.0, -1.0):
                reach = float((side * moved).max())
                if not context.shows(reach >= 0.1 * far):
                    continue
                for distance in context.grid("distance", [share * reach for share in (0.4, 0.6, 0.8)]):
                    change = np.zeros_like(context.displacement)
                    change[:, own] = -side * np.maximum(side * moved - distance, 0.0)
                    sign = "+" if side > 0 else "-"
                    term = Term.field("stopped", change)
                    yield Variant(f"wall at {sign}{letter}", (term,), {"distance": distance})

    def family(self, context: Context) -> Iterator[Space]:
        """A limit on pressure, wall deflection or travel; a post in front of some markers; or a plane."""
        if not context.moves:
            return
        x, d, slope = context.rows.fraction, context.deflection, context.deflection_slope
        for limit in (0.35, 0.5, 0.6, 0.7, 0.8, 0.9):
            h, g = np.maximum(x - limit, 0), np.maximum(d - limit, 0)
            out = [
                pressure("pressure", -h, 0.6),
                pressure("wall", -g / slope, 0.6),
                pressure("soft", -(g**1.5) / slope, 0.6),
                pressure("later", -np.maximum(d - limit - 0.1, 0) / slope, 0.3),
                pressure("earlier", -np.maximum(d - limit + 0.1, 0) / slope, 0.3),
            ]
            if (h > 0).mean() >= 0.005 or (g > 0).mean() >= 0.005:
                yield Space(f"limit {limit}", "contact limit", acting(out), 0.2)
        yield from _places(context)

    def covariate(self, context: Context) -> tuple[str, str, Floats]:
        return ("largest pressure, of the range", "1", context.rows.fraction.max(axis=1))

    def sign(self, context: Context, part: Part) -> Sign:
        if part.form.startswith("wall at "):
            letter = part.form[-1]
            return by_marker(context, part, "xyz".index(letter), 1.0 if part.form[-2] == "+" else -1.0)
        if part.form in ("travel", FORM):
            return by_marker(context, part)
        return by_chamber(context, part, named=True)


def _places(context: Context) -> Iterator[Space]:
    """Limits in space: travel, planes that markers meet, and posts in the way of some of them."""
    far, rows = float(context.travel.max()), context.rows
    has_axis = (rows.axis >= 0).sum() >= 3 and (rows.marker >= 0).any()
    if far <= 0 or not has_axis:
        return
    move = _by_marker(context, context.displacement)
    length = np.linalg.norm(move, axis=2)
    way = move / np.maximum(length, 1e-9)[..., None]
    for share in (0.3, 0.5, 0.7, 0.85):
        past = np.maximum(length - share * far, 0)
        yield Space(
            f"travel {share}",
            "contact travel",
            acting([field("stop", _to_rows(context, -past[..., None] * way))]),
        )
    for share in (0.4, 0.6, 0.8):  # each marker by itself, at a share of its own farthest way
        past = np.maximum(length - share * length.max(axis=0), 0)
        out = []
        for m in range(len(rows.markers)):
            alone = np.zeros_like(move)
            alone[:, m] = -past[:, m, None] * way[:, m]
            out.append(field(f"marker {m}", _to_rows(context, alone)))
        yield Space(f"post {share}", "contact post", acting(out))
    rest = rows.rest_mm
    here = move + (rest[None] if rest is not None and np.isfinite(rest).all() else 0.0)
    main = (move * length[..., None]).sum(axis=(0, 1))
    normals = {"main": main / max(np.linalg.norm(main), 1e-9)}
    for a, letter in enumerate("xyz"):
        for side in (1.0, -1.0):
            if (side * move[:, :, a]).max() > 0.3 * far:
                normals[("+" if side > 0 else "-") + letter] = side * np.eye(3)[a]
    for name, n in normals.items():
        height = here @ n
        out_ = (move @ n) > 0.1 * far
        if out_.mean() < 0.01:
            continue
        across = np.linalg.svd(n[None])[2][1:]
        beside = np.stack([(here - here.mean(axis=(0, 1))) @ t for t in across], axis=2)
        beside /= np.abs(beside).max() + 1e-12
        for share in (40, 65, 85, 95):
            past = np.where(out_, np.maximum(height - np.percentile(height[out_], share), 0), 0.0)
            met = (past > 0).astype(float) * past.max(initial=0.0)
            out = [
                ("back", -past[..., None] * n, 1.0),
                ("own way", -past[..., None] * way, 0.5),
                ("nearer", -met[..., None] * n, 0.1),
            ]
            out += [(f"tilted {j}", -(met * beside[:, :, j])[..., None] * n, 0.3) for j in (0, 1)]
            yield Space(
                f"plane {name} {share}",
                "contact plane",
                acting([field(k, _to_rows(context, v), w) for k, v, w in out]),
            )


def _by_marker(context: Context, values: Floats) -> Floats:
    """Values (F, K) as (F, M, 3), zero along axes that are not seen."""
    rows = context.rows
    own = np.flatnonzero((rows.marker >= 0) & (rows.axis >= 0))
    out = np.zeros((len(values), len(rows.markers), 3))
    out[:, rows.marker[own], rows.axis[own]] = values[:, own]
    return out


def _to_rows(context: Context, values: Floats) -> Floats:
    """The reverse of `_by_marker`."""
    rows = context.rows
    own = np.flatnonzero((rows.marker >= 0) & (rows.axis >= 0))
    out = np.zeros((len(values), len(rows.marker)))
    out[:, own] = values[:, rows.marker[own], rows.axis[own]]
    return out
