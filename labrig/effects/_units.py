"""The unit of a parameter on a run: "actuation", "observable" and their like stand for what the run has."""

import re
from collections.abc import Iterable

from labrig.effects._context import Context


def unit_on(context: Context, unit: str) -> str:
    """The unit of a parameter (see `Parameter`) with those of the run in it; of several kinds: ``(mm or N)``."""
    rows = context.rows
    place = [u for u, marker in zip(rows.unit, rows.marker, strict=True) if marker >= 0]
    sensed = [u for u, marker in zip(rows.unit, rows.marker, strict=True) if marker < 0]
    moving = [rows.covariates[name].unit for name in context.motion] if "motion" in unit else []
    own = {
        "actuation": _either(rows.actuation_unit.split(" or ")) or "1",
        "observable": _either(rows.unit),
        "place": _either(place or rows.unit),
        "sensor": _either(sensed or rows.unit),
        "motion": _either(moving) or "1",
    }
    return re.sub("|".join(own), lambda found: own[found[0]], unit)


def _either(units: Iterable[str]) -> str:
    different = list(dict.fromkeys(units))
    return f"({' or '.join(different)})" if len(different) > 1 else "".join(different)
