"""What a hidden effect is: a few hooks along the way from a set-point to a marker, all optional.

A plant calls, for a stretch of time inside one hold, `line` (pressure that arrives in the chamber), `load`
(pressure that the membrane feels) and `deflect` (how far it moves); `set_point` once per command; and `see`
on whatever positions are asked for. Effects that remember keep arrays in `memory`, and replace them rather
than write into them, so that a plant can look ahead and take the step back.
"""

from dataclasses import dataclass, field
from typing import Any, ClassVar, Protocol

import numpy as np

from labrig.arrays import Floats


class Body(Protocol):
    """What is inflated: `labrig.physics.Surface`, or anything with the same few members."""

    chamber_names: tuple[str, ...]

    @property
    def rest_mm(self) -> Floats: ...
    @property
    def normal(self) -> Floats: ...
    @property
    def weight(self) -> Floats: ...
    @property
    def compliance_mm_per_kpa(self) -> Floats: ...
    @property
    def limit_mm(self) -> Floats: ...

    def deflection_mm(self, pressure_kpa: Floats) -> Floats: ...
    def shape_mm(self, deflection_mm: Floats) -> Floats: ...


@dataclass
class Setting:
    """Where an effect lives: the body, the chambers' highest pressures (C,), how long a campaign lasts,
    chance.
    """

    body: Body
    max_kpa: Floats
    duration_s: float
    random: np.random.Generator = field(repr=False)

    @property
    def chambers(self) -> int:
        return len(self.max_kpa)

    @property
    def largest_mm(self) -> Floats:
        """Deflection of each chamber at its highest pressure, (C,)."""
        return self.body.deflection_mm(self.max_kpa)

    def varied(self, spread: float) -> Floats:
        """One factor per chamber around one, (C,): no two chambers are made alike."""
        return np.exp(spread * self.random.normal(size=self.chambers))


class Hidden:
    """Base of all hidden effects; a subclass overrides the hooks that it needs. `strength` scales it."""

    name: ClassVar[str] = ""
    natural: ClassVar[float] = 1.0  # a strength of plausible size, where the search for an amplitude starts

    def __init__(self, setting: Setting) -> None:
        self.setting = setting
        self.strength = self.natural
        self.memory: dict[str, Any] = {}
        self.prepare()

    def prepare(self) -> None:
        """Draw what chance decides."""

    def set_point(self, target_kpa: Floats) -> Floats:
        """The pressure (C,) that the regulator goes to when `target_kpa` is commanded."""
        return target_kpa

    def line(self, since_s: Floats, step_s: Floats, pressure_kpa: Floats) -> Floats:
        """Chamber pressures (T, C) for regulated ones; `since_s`, `step_s` (T,): since the command, since
        the row before.
        """
        del since_s, step_s
        return pressure_kpa

    def load(self, step_s: Floats, pressure_kpa: Floats) -> Floats:
        """The pressures (T, C) that the membranes feel."""
        del step_s
        return pressure_kpa

    def deflect(self, time_s: Floats, step_s: Floats, deflection_mm: Floats) -> Floats:
        """Deflections (T, C), for those without this effect."""
        del time_s, step_s
        return deflection_mm

    def see(self, time_s: Floats, tilt_deg: Floats, deflection_mm: Floats, position_mm: Floats) -> Floats:
        """Positions (F, M, 3) as they are seen, for those without this effect."""
        del time_s, tilt_deg, deflection_mm
        return position_mm


def resisted(body: Body, deflection_mm: Floats, resistance) -> Floats:
    """Deflections at the same pressures when the membrane also pushes back with `resistance`.

    `resistance(d)` gives (pressure kPa, slope kPa/mm) for d >= 0, convex and rising, so that Newton's method
    from the unresisted deflection descends to the root without a safeguard.
    """
    gain, limit = body.compliance_mm_per_kpa, body.limit_mm
    free = np.abs(deflection_mm)
    load = (free + free**3 / limit**2) / gain
    d = free
    for _ in range(12):
        push, slope = resistance(d)
        gap = (d + d**3 / limit**2) / gain + push - load
        step = gap / ((1.0 + 3.0 * d**2 / limit**2) / gain + slope)
        d = np.maximum(d - step, 0.0)
        if np.abs(step).max(initial=0.0) < 1e-7:
            break
    return np.sign(deflection_mm) * d
