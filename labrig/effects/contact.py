"""Contact: a limit is reached and the motion stops there."""

from collections.abc import Collection, Iterator
from functools import partial

import numpy as np

from labrig._text import listed, number, with_unit
from labrig.arrays import Floats
from labrig.effects._context import Context
from labrig.effects._effect import Effect, Parameter, Term, Variant
from labrig.effects._end_stops import STOP_OF, by_joint, sensor_of, stopped_joints
from labrig.effects._family import Space, acting, one_way, pressure
from labrig.effects._fitted import Fitted
from labrig.effects._inside import FORM, inside
from labrig.effects._obstacles import obstacles
from labrig.effects._planes import NORMAL, felt_beside, planes
from labrig.effects._plates import plates
from labrig.effects._presses import presses, pressing
from labrig.effects._pushes import pushes
from labrig.effects._rows import ends
from labrig.effects._sign import Part, Sign, by_chamber, by_marker
from labrig.effects._skin import touched, touched_term

_BY_PRESSURE = {"pressure", "per chamber", "one chamber"}
"""Forms whose limit is a share of a chamber's range."""


class Contact(Effect):
    name = "contact"
    meaning = (
        "Beyond some point the surface (or a piston, or the core) meets something and is stopped:\n"
        "nothing below the limit, and a growing error above it."
    )
    acts_on = "mechanics"
    unit_in_names = "%"
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
        Parameter(
            "distance",
            "place",
            meaning="how far from the vented place the limit lies; of a plane, from the middle of the markers at rest",
        ),
        Parameter(
            "felt",
            "sensor/mm",
            meaning="what a sensor has of it, for each mm that the markers together would go behind the plane",
        ),
        Parameter(
            "push",
            "actuation**2/place**2",
            0.0,
            meaning="how much pressure it takes off a chamber, for each unit that a marker would go behind the plane "
            "and each by which a unit of pressure moves it",
        ),
        Parameter(
            "shared",
            "sensor/sensor",
            meaning="what another sensor has of it, for each unit that the stopped one would go beyond the stop",
        ),
        Parameter(
            "pressed",
            "sensor",
            meaning="what a sensor that the model says nothing of reads of an input that is its whole range beyond the "
            "limit",
        ),
        *(
            Parameter(name, "1", -1.0, 1.0, meaning=f"{name[-1]} of the plane's direction", given=True)
            for name in NORMAL
        ),
        Parameter(
            "chamber",
            "1",
            0.0,
            per="chamber",
            meaning="the only one that is stopped, counted from 0",
        ),
    )
    reference = (
        "P. Wriggers, Computational Contact Mechanics, 2nd ed. Springer 2006, ch. 2 (unilateral contact)"
    )
    signature = "a kink: no error below a pressure or a position, error in proportion to the excess above it"
    ruled_out_by = "take away whatever the body could touch"
    experiment = "small steps of one chamber around the limit"

    def variants(self, context: Context) -> Iterator[Variant]:
        if not context.shows(context.moves):
            return
        yield from inside(context, stiffness="contact_")
        x, chambers = context.rows.fraction, context.rows.chambers
        for limit in context.grid("limit", (0.4, 0.5, 0.6, 0.7, 0.8, 0.9)):
            beyond = -np.maximum(x - limit, 0.0) * context.span
            if not context.shows((beyond != 0).mean() >= 0.02):
                continue
            stopped = Term.common("stopped", beyond)
            yield Variant("pressure", (stopped,), {"limit": limit})
            for form, power in (("felt", 1.0), ("felt, Hertz", 1.5)):
                if pressed := touched_term(context, "pressed", np.maximum(x - limit, 0.0) ** power):
                    yield Variant(f"pressure, {form}", (stopped, pressed), {"limit": limit})
                    yield Variant(f"only {form}", (pressed,), {"limit": limit})
            if len(chambers) > 1:
                yield Variant(
                    "per chamber", (Term.per_chamber("stopped", beyond, chambers),), {"limit": limit}
                )
                for c in context.grid("chamber", range(len(chambers))):
                    alone = np.where(np.arange(len(chambers)) == c, beyond, 0.0)
                    if context.shows((alone != 0).any()):
                        shape = {"limit": limit, "chamber": float(c)}
                        yield Variant("one chamber", (Term.common("stopped", alone),), shape)
        for limit in context.grid("limit", (0.3, 0.45, 0.6, 0.75)):
            beyond = -np.maximum(context.deflection - limit, 0.0) * context.span
            if context.shows((beyond != 0).mean() >= 0.02) and len(chambers) > 1:
                yield Variant("deflection", (Term.common("stopped", beyond),), {"limit": limit})
                yield Variant(
                    "deflection per chamber",
                    (Term.per_chamber("stopped", beyond, chambers),),
                    {"limit": limit},
                )
        yield from self._positions(context)
        yield from stopped_joints(context)
        for plane, back in planes(context):
            if context.shows((back != 0).any(axis=1).mean() >= 0.02):
                stopped = Term.field("stopped", back)
                yield Variant("plane", (stopped,), plane.shape, centred=True)
                if felt := felt_beside(context, plane, back):
                    yield Variant("plane, felt", (stopped, felt), plane.shape, centred=True)
        for plane, back in planes(context, pressing):
            pushed = np.einsum("fkc,fk->fc", context.jacobian, back)
            if context.shows((pushed != 0).any(axis=1).mean() >= 0.02):
                yield Variant("plane, chambers", (Term.common("push", pushed),), plane.shape)

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
        """A limit on pressure or wall deflection, on all walls together, or in space: one of them."""
        if not context.moves:
            return
        x, d, slope = context.rows.fraction, context.deflection, context.deflection_slope
        for limit in (0.1, 0.2, 0.35, 0.5, 0.6, 0.7, 0.8, 0.9):
            h, g = np.maximum(x - limit, 0), np.maximum(d - limit, 0)
            out = [
                pressure("pressure", -h, 0.6),
                pressure("wall", -g / slope, 0.6),
                pressure("soft", -(g**1.5) / slope, 0.6),
                pressure("later", -np.maximum(d - limit - 0.1, 0) / slope, 0.3),
                pressure("earlier", -np.maximum(d - limit + 0.1, 0) / slope, 0.3),
            ]
            pressed = touched(context, {"touched": h, "pressed": h**1.5})
            if context.shows((h > 0).mean() >= 0.005 or (g > 0).mean() >= 0.005):
                stop = Space(f"limit {limit}", "contact limit", acting([*out, *pressed]), 0.2)
                yield stop if pressed else one_way(stop)
        for limit in (0.08, 0.18, 0.35):  # a wall that cannot come back below it
            h, g = np.maximum(limit - x, 0), np.maximum(limit - d, 0)
            out = [pressure("pressure", h), pressure("wall", g / slope)]
            yield one_way(Space(f"from below {limit}", "contact from below", acting(out), 0.2))
        if x.shape[1] > 1:
            yield from _together(context)
        yield from obstacles(context)
        yield from plates(context)
        yield from presses(context)
        yield from pushes(context)

    def lacks(self, context: Context, form: str, parameters: Collection[str]) -> str:
        rest = context.rows.rest_mm
        unknown = rest is None or not np.isfinite(rest).all()
        return "the places of the markers at rest" if form.startswith("plane") and unknown else ""

    def in_words(self, found: Fitted) -> str:
        """From which pressure on something is met, of each chamber that is stopped; or where a sensor's motion ends."""
        if found.form.startswith(STOP_OF) and (distance := found.numbers("distance")):
            name = sensor_of(found.form)
            way = distance[0] if f"{STOP_OF}{name}, +" in found.form else -distance[0]
            way = with_unit(number(way), found.units.get(name, ""))
            return f"{name} is stopped {way} from where it is vented."
        if found.form not in _BY_PRESSURE or not found.ranges or not (limit := found.numbers("limit")):
            return ""
        origin, span = ends(*np.array(list(found.ranges.values()), float).T)
        at = dict(zip(found.ranges, (origin + limit[0] * span).tolist(), strict=True))
        said = {name: with_unit(number(value), found.unit) for name, value in at.items()}
        if only := found.numbers("chamber"):
            name = list(at)[int(only[0])]
            return f"{name} is stopped from {said[name]} on."
        if len(set(said.values())) == 1:
            return f"Something is met from {next(iter(said.values()))} on."
        return f"Something is met from {listed([f'{value} ({name})' for name, value in said.items()])} on."

    def covariate(self, context: Context) -> tuple[str, str, Floats]:
        return ("largest pressure, of the range", "1", context.rows.fraction.max(axis=1))

    def sign(self, context: Context, part: Part) -> Sign:
        if part.form.startswith("wall at "):
            letter = part.form[-1]
            return by_marker(context, part, "xyz".index(letter), 1.0 if part.form[-2] == "+" else -1.0)
        if part.form in ("travel", "plane", "plane, felt", "plane, chambers", FORM):
            return by_marker(context, part)
        if part.form.startswith(STOP_OF):
            return by_joint(context, part, sensor_of(part.form))
        return by_chamber(context, part, named=True)


def _together(context: Context) -> Iterator[Space]:
    """A cord around the body, or a cage, that gives all walls together no more than a length."""
    x, d, slope = context.rows.fraction, context.deflection, context.deflection_slope
    for name, load in (("pressures", x), ("walls", d)):
        length = np.abs(load).mean(axis=1)
        for share in (0.4, 0.6, 0.8):
            key = f"{name} together {share}"
            top = context.yardstick(key, partial(np.quantile, length, share))
            lost = np.maximum(1 - top / np.maximum(length, 1e-9), 0.0)[:, None]
            out = [pressure("shared", -load * lost / (slope if load is d else 1.0))]
            out.append(
                pressure("alike", -np.repeat(np.maximum(length - top, 0)[:, None], x.shape[1], axis=1), 0.3)
            )
            yield Space(key, "contact together", acting(out), 0.6, along=out[0])
