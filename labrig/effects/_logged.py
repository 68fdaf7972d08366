"""What something that was logged beside the observables is, by its name and its unit: a payload, a tilt, a temperature.

Names count by their words: a mass flow is no mass, and an attempt has no temperature.
"""

import re
from collections.abc import Callable, Iterator
from functools import cache

import numpy as np

from labrig._errors import LabrigError
from labrig.arrays import Floats
from labrig.effects._context import Context
from labrig.effects._rows import Covariate

_NEWTON = 1 / 9.80665
_TILTED = {"tilt", "orientation", "inclination", "pitch", "roll"}
_LOADED = {
    "load", "loads", "payload", "mass", "weight", "last", "zusatzlast", "gewicht", "zusatzgewicht", "charge", "poids",
    "carga", "peso", "carico",
}  # fmt: skip
_WARM = ("temp", "temps", "temperature", "temperatures")
_TURN = 2 * np.pi


def payloads_kg(context: Context) -> Iterator[tuple[str, Floats]]:
    """Of each payload that changes its name and how heavy it is, kg (F,); of one in newton the mass that weighs it."""
    return _of(context, _kg_of)


def tilts_rad(context: Context) -> Iterator[tuple[str, Floats]]:
    """Of each tilt that changes its name and its angle, rad (F,)."""
    return _of(context, _rad_of)


def is_payload(name: str, logged: Covariate) -> bool:
    """Whether it says what the rig carried: a mass by its unit, a force by its name too."""
    return _kg_of(name, logged) is not None


def is_tilt(name: str, logged: Covariate) -> bool:
    """Whether it says how the rig was turned: tilt, mount tilt, tilt_x, pitch, or just angle, but no valve's angle."""
    return _rad_of(name, logged) is not None


def is_volume(unit: str) -> bool:
    """Whether a unit is one of volumes."""
    return _factor(unit, "ml") is not None


def is_temperature(name: str, logged: Covariate) -> bool:
    """Whether it is a temperature, by its unit or its name."""
    return logged.unit in {"degC", "K", "degF", "kelvin"} or any(w.endswith(_WARM) for w in _words(name))


def _of(context: Context, size_of: Callable[[str, Covariate], float | None]) -> Iterator[tuple[str, Floats]]:
    for name, logged in context.rows.covariates.items():
        size = size_of(name, logged)
        if size is None or not np.isfinite(logged.values).all():
            continue
        if context.shows(np.ptp(logged.values) > 0):
            yield name, logged.values * size


def _kg_of(name: str, logged: Covariate) -> float | None:
    """How many kg one of its units is; None where it is no payload."""
    words = _words(name)
    mass, force = _factor(logged.unit, "kg"), _factor(logged.unit, "N")
    if "flow" in words or (mass is None and not words & _LOADED):
        return None
    return mass if mass is not None else None if force is None else force * _NEWTON


def _rad_of(name: str, logged: Covariate) -> float | None:
    """How many radians one of its units is; None where it is no tilt. A number without a unit is one in radians."""
    if name.lower() != "angle" and not _words(name) & _TILTED:
        return None
    if logged.unit == "1":
        return 1.0 if np.nanmax(np.abs(logged.values), initial=0.0) <= _TURN else None
    return _factor(logged.unit, "rad")


def _words(name: str) -> set[str]:
    return {word.lower() for word in re.findall("[A-Z]?[a-z]+|[A-Z]+", name)}


@cache
def _factor(unit: str, to: str) -> float | None:
    """What a number in a unit is multiplied by; None where it is of another kind."""
    from labrig.tables import factor

    if unit == "1":
        return None
    try:
        return factor(unit, to, "")
    except LabrigError:
        return None
