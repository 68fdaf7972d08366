"""Numbers with units in files: `525 kPa`, `0.525 MPa`, or a bare number in the unit that labrig keeps."""

from functools import cache
from typing import Any

from pydantic import GetCoreSchemaHandler
from pydantic_core import CoreSchema, core_schema


@cache
def _factor(unit: str, to: str) -> float:
    """What a number in `unit` is multiplied by to be in `to`; raises `ValueError`."""
    if unit == to:
        return 1.0
    import pint

    try:
        return float(pint.UnitRegistry().Quantity(1.0, unit).to(to).magnitude)
    except Exception:
        raise ValueError(f"unit '{unit}' can't be converted to {to}") from None


def convert(value: Any, unit: str) -> float:
    """A number, or a text such as `525 kPa`, as a number in `unit`; raises `ValueError` for anything else."""
    if isinstance(value, bool) or not isinstance(value, (int, float, str)):
        raise ValueError(f"a number in {unit} is needed, such as '1 {unit}'")
    if not isinstance(value, str):
        return float(value)
    number, _, given = value.strip().partition(" ")
    try:
        magnitude = float(number)
    except ValueError:
        raise ValueError(f"'{value}' is not a number with a unit, such as '1 {unit}'") from None
    return magnitude * _factor(given.strip(), unit) if given.strip() else magnitude


class Unit:
    """Annotation of a field that is kept as a number in `name` and written as a text with it."""

    def __init__(self, name: str) -> None:
        self.name = name

    def __get_pydantic_core_schema__(self, source: Any, handler: GetCoreSchemaHandler) -> CoreSchema:
        return core_schema.no_info_before_validator_function(
            lambda value: convert(value, self.name),
            handler(source),
            serialization=core_schema.plain_serializer_function_ser_schema(
                lambda value: f"{value!r} {self.name}", when_used="json"
            ),
        )
