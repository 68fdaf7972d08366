"""Friction: a force or a lag against the direction of motion, at once and in full."""

from collections.abc import Collection, Iterator

import numpy as np

from labrig.arrays import Floats
from labrig.effects._context import Context
from labrig.effects._effect import Effect, Parameter, Term, Variant
from labrig.effects._end_stops import by_joint, joints
from labrig.effects._family import Space, acting, field, motion_scale, pattern, pressure
from labrig.effects._memory import memory
from labrig.effects._sign import Part, Sign, along_own, by_chamber
from labrig.effects._skin import (
    at_events,
    body_behind,
    by_itself,
    by_place,
    felt,
    marker_behind,
    path_behind,
    path_direction,
    per_sensor,
    play_behind,
)

_OF = "of "
_PRESLIDING = (0.02, 0.05, 0.12)
"""Ways after a turn until something slides, shares of the whole motion."""


class Friction(Effect):
    name = "friction"
    meaning = (
        "Sliding parts hold back whatever moves: a jump of constant size when the direction turns,\n"
        "which may grow with the load. A narrow play, of a gear or of a valve, does the same: look for both."
    )
    acts_on = "mechanics"
    unit_in_names = "%"
    remembers = True
    parameters = (
        Parameter("coulomb", "actuation", 0.0, per="chamber", meaning="held back, as a pressure"),
        Parameter("loaded", "1", -1.0, 1.0, "chamber", "held back for each unit of pressure"),
        Parameter("force", "observable", meaning="held back, for each observable"),
        Parameter("force_loaded", "observable", meaning="held back at full pressure, for each observable"),
        Parameter("presliding", "sensor", 0.0, meaning="way of a joint after a turn until it slides"),
        Parameter("full_speed", "motion/s", 0.0, meaning="speed at which three quarters of it are reached"),
    )
    reference = (
        "H. Olsson et al., Friction models and friction compensation, Eur. J. Control 4 (1998) 176-195"
    )
    signature = "a step of the error when the direction turns, flat between turns, perhaps growing with load"
    experiment = "small strokes back and forth around one set-point, at two loads"
    blurred_by = frozenset({"one side", "one speed", "one stroke"})

    def variants(self, context: Context) -> Iterator[Variant]:
        load = context.rows.fraction.mean(axis=1)
        for name, (speed, _) in context.motion.items():
            typical = float(np.median(np.abs(speed[speed != 0]))) if (speed != 0).any() else 1.0
            for full in context.grid("full_speed", [share * typical for share in (0.05, 0.2, 0.5)]):
                s = np.tanh(speed / full)
                shape = {"full_speed": full}
                yield Variant(f"Coulomb along {name}", (Term.pattern("force", -s),), shape)
                yield Variant(
                    f"Coulomb along {name}, growing with load",
                    (Term.pattern("force", -s), Term.pattern("force_loaded", -s * load)),
                    shape,
                )
        if not context.shows(context.moves and not context.motion):
            return
        against = -context.direction[context.rows.event]
        u, chambers = np.abs(context.rows.actuation), context.rows.chambers
        yield Variant("Coulomb", (Term.common("coulomb", against),))
        yield Variant("growing with load", (Term.common("loaded", against * u),))
        yield Variant(
            "Coulomb, growing with load",
            (Term.common("coulomb", against), Term.common("loaded", against * u)),
        )
        for even in per_sensor(context, "coulomb", against):
            yield Variant("per sensor", (even,))
            growing = per_sensor(context, "loaded", against * u)
            yield Variant("per sensor, growing with load", (even, *growing))
        if len(chambers) > 1:
            along = -path_direction(context)
            yield Variant("along the path", (Term.common("coulomb", along),))
            yield Variant(
                "along the path, growing with load",
                (Term.common("coulomb", along), Term.common("loaded", along * u)),
            )
            yield Variant("per chamber", (Term.per_chamber("coulomb", against, chambers),))
            yield Variant(
                "per chamber, growing with load",
                (
                    Term.per_chamber("coulomb", against, chambers),
                    Term.per_chamber("loaded", against * u, chambers),
                ),
            )
        if len(chambers) <= 2:
            yield Variant("pattern", (Term.pattern("force", against),))
        for k in joints(context):
            way = at_events(context)[:, k]
            for width in context.grid(
                "presliding", [w * float(motion_scale(context)[k]) for w in _PRESLIDING]
            ):
                behind = (context.played(width, way) - way[context.rows.event]) / width
                term = Term.pattern("force", behind)
                shape, unit = {"presliding": width}, {"presliding": context.rows.unit[k]}
                yield Variant(f"{_OF}{context.rows.observables[k]}", (term,), shape, units=unit)

    def family(self, context: Context) -> Iterator[Space]:
        """The sign of the last motion, constant or growing with the load; and very narrow play."""
        if not context.moves:
            return
        x, u, span = context.rows.fraction, context.rows.actuation, context.span
        turn = -context.direction[context.rows.event] * np.sign(span)
        out = [
            pressure("direction", turn),
            pressure("direction load", turn * x),
            pressure("direction load2", turn * x**2, 0.25),
        ]
        for r in (0.01, 0.025):
            z = (context.play(r) - u) / span / r
            out += [pressure(f"presliding {r}", z, 0.5), pressure(f"presliding {r} load", z * x, 0.5)]
        out += [pressure("settled", x, 0.1), pressure("settled2", x * x, 0.1)]
        out.append(pressure("more one way", -np.abs(turn), 0.1))
        out += memory(context)
        yield (sliding := Space("sliding", "friction", acting(out)))
        yield from by_itself(context, sliding)
        if forces := felt(context, {"turn": turn}):
            yield Space("as sensors feel it", "friction felt", acting(forces))
        behind = [(f"skin {w}", play_behind(context, w) / w) for w in _PRESLIDING]
        skin = [field(name, values, 0.5) for name, values in behind]
        yield Space("under the skin", "friction skin", acting(skin))
        places = [f for name, values in behind for f in by_place(context, name, values)]
        if places:
            yield Space("under the skin, by place", "friction skin by place", acting(skin + places))
        for k in joints(context):
            own = [pattern(name, values[:, k] / motion_scale(context)[k], 0.5) for name, values in behind]
            yield Space(f"of {context.rows.observables[k]}", "friction joint", acting(own))
        if len(context.rows.chambers) < 2:
            return  # what a single chamber moves is held back as that chamber is
        path = [(f"path {w}", path_behind(context, w) / w) for w in (0.01, 0.05)]
        along = [pressure(name, z, 1.0) for name, z in path] + [
            pressure(f"{name} load", z * x, 0.5) for name, z in path
        ]
        yield Space("dragged along the path", "friction path", acting(along))
        if (context.rows.marker >= 0).any():
            dragged = [field(f"marker {w}", marker_behind(context, w) / w) for w in (0.02, 0.05, 0.12)]
            yield Space("under the markers", "friction markers", acting(dragged))
        body = [field(f"body {w}", body_behind(context, w) / w) for w in (0.01, 0.03)]
        yield Space("of the whole body", "friction body", acting(body))

    def covariate(self, context: Context) -> tuple[str, str, Floats]:
        for name, cov in context.rows.covariates.items():
            if name in context.motion:
                return (name, cov.unit, cov.values)
        return ("mean pressure", context.rows.actuation_unit, context.rows.actuation.mean(axis=1))

    def sign(self, context: Context, part: Part) -> Sign:
        for name, (speed, _) in context.motion.items():
            if part.form.startswith(f"Coulomb along {name}"):
                return along_own(
                    context, part, speed, f"speed of {name}", f"{context.rows.covariates[name].unit}/s"
                )
        if part.form.startswith(_OF):
            return by_joint(context, part, part.form.removeprefix(_OF), strokes=True)
        return by_chamber(context, part, strokes=True)

    def lacks(self, context: Context, form: str, parameters: Collection[str]) -> str:
        moving = form.removeprefix("Coulomb along ").removesuffix(", growing with load")
        return moving if form.startswith("Coulomb along ") and moving not in context.motion else ""
