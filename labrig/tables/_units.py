"""Units of foreign tables: checked, and converted where labrig fixes its own (seconds, millimetres)."""

import re
from functools import cache

from labrig._errors import LabrigError


@cache
def _registry():
    import pint

    return pint.UnitRegistry()


def factor(unit: str, to: str, where: str) -> float:
    """What a number in `unit` is multiplied by to be in `to`; raises `LabrigError` naming `where`."""
    scale, offset = conversion(unit, to, where)
    if offset:
        raise LabrigError(f"{where}: {unit!r} and {to!r} do not begin at the same zero; write it in {to}")
    return scale


@cache
def conversion(unit: str, to: str, where: str) -> tuple[float, float]:
    """What a number in `unit` is multiplied by to be in `to`, and what is then added, as between temperatures.

    Raises `LabrigError` naming `where`.
    """
    check(unit, where)
    registry = _registry()
    if to in ("mm", "s") and unit in _SCREEN:
        raise LabrigError(f"{where}: unit {unit!r} is no length; calibrate pixels to mm first")
    try:
        zero, one = (float(registry.Quantity(number, unit).to(to).magnitude) for number in (0.0, 1.0))
    except Exception as error:
        raise LabrigError(f"{where}: unit {unit!r} can't be converted to {to}") from error
    return (one, 0.0) if zero == 0 else (one - zero, zero)


@cache
def atmosphere(unit: str) -> float:
    """One standard atmosphere in a checked unit of pressure, to six digits."""
    return float(f"{factor('atm', unit, 'unit'):.6g}")


_SCREEN = {"px", "pixel", "pixels", "dot", "dots", "pel", "css_pixel", "picture_element"}
"""What pint takes for a length of print (1/96 inch); a camera's pixels are none."""


@cache
def check(unit: str, where: str) -> None:
    """Raise `LabrigError` if there is no such unit."""
    if unit == "1":
        return
    try:
        _registry().Unit(unit)
    except Exception as error:
        raise LabrigError(
            f"{where}: there is no unit {unit!r}; use one such as kPa, bar, N, mm, s, degC or 1"
        ) from error


def is_length(unit: str) -> bool:
    """Whether a checked unit is a length; pixels of a camera are not."""
    return like(unit, "mm")


def is_screen(unit: str) -> bool:
    """Whether a unit is a pixel, which is no length."""
    return unit in _SCREEN


def like(unit: str, other: str) -> bool:
    """Whether a checked unit is of the same kind as another; a camera's pixels are of no kind."""
    return unit not in {"1", *_SCREEN} and _registry().Unit(unit).is_compatible_with(other)


def same(unit: str, other: str) -> bool:
    """Whether a number in one checked unit is the same in another, however both are written."""
    return unit == other or (like(unit, other) and conversion(unit, other, "unit") == (1.0, 0.0))


def names_of(unit: str) -> list[str]:
    """What pint calls the parts of a checked unit, such as kilopascal."""
    return re.findall(r"[A-Za-z]\w*", str(_registry().Unit(unit)))
