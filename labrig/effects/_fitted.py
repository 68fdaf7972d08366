"""What was fitted of an effect, as it says it in words: its form, its parameters, and what they refer to."""

import re
from collections.abc import Mapping
from dataclasses import dataclass, field
from typing import Any

from labrig.arrays import flat

MINUTE_S = 60.0
_WEIGHTS = "weights"
_NUMBER = re.compile(r"(?<![\w.])-?\d+\.\d+(?![\w.])")
_PERCENT = 100.0


@dataclass(frozen=True)
class Fitted:
    """An effect as a model has it: its form, and its parameters (value, sd, unit, per) by name.

    `longest_s` is how long the longest hold was that it was fitted to: nothing is said of longer ones. `ranges` of the
    chambers are those that fractions are of, in `unit`. `units` are those of the observables, `unit_in_names` that of
    the numbers in the names of its family's functions.
    """

    effect: str
    form: str
    parameters: Mapping[str, Any]
    longest_s: float = MINUTE_S
    ranges: Mapping[str, tuple[float, float]] = field(default_factory=dict)
    unit: str = ""
    units: Mapping[str, str] = field(default_factory=dict)
    unit_in_names: str = ""

    @property
    def shown(self) -> dict[str, Any]:
        """The parameters as a person reads them: of a family the functions with units in their names."""
        return with_named_units(self.parameters, self.unit_in_names)

    def numbers(self, parameter: str, what: str = "value") -> list[float]:
        """The values of a parameter in one list, or their `sd`; empty where there are none."""
        return flat(self.parameters.get(parameter, {}).get(what))

    def names(self, parameter: str) -> list[str]:
        """What each value of a parameter belongs to: chambers, markers, functions of a family; empty for one of all."""
        return [str(name) for name in self.parameters.get(parameter, {}).get("per") or []]


def with_named_units(parameters: Mapping[str, Any], unit: str) -> dict[str, Any]:
    """Parameters with `lost 60.0 of c1` as `lost 60 s of c1` among the names of a family's functions, or `play 0.06` as
    `play 6 %`; as they are where `unit` is empty.
    """
    shown = dict(parameters)
    if unit and (weights := shown.get(_WEIGHTS)):
        size = _PERCENT if unit == "%" else 1.0
        said = [
            _NUMBER.sub(lambda n: f"{float(n[0]) * size:g} {unit}", str(name))
            for name in weights.get("per") or []
        ]
        shown[_WEIGHTS] = {**weights, "per": said}
    return shown
