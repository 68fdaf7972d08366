"""What was fitted of an effect, as it says it in words: its form, its parameters, and what they refer to."""

from collections.abc import Mapping
from dataclasses import dataclass, field
from typing import Any

from labrig.arrays import flat

MINUTE_S = 60.0


@dataclass(frozen=True)
class Fitted:
    """An effect as a model has it: its form, and its parameters (value, sd, unit, per) by name.

    `longest_s` is how long the longest hold was that it was fitted to: nothing is said of longer ones. `ranges` of the
    chambers are those that fractions are of, in `unit`. `units` are those of the observables.
    """

    effect: str
    form: str
    parameters: Mapping[str, Any]
    longest_s: float = MINUTE_S
    ranges: Mapping[str, tuple[float, float]] = field(default_factory=dict)
    unit: str = ""
    units: Mapping[str, str] = field(default_factory=dict)

    def numbers(self, parameter: str, what: str = "value") -> list[float]:
        """The values of a parameter in one list, or their `sd`; empty where there are none."""
        return flat(self.parameters.get(parameter, {}).get(what))

    def names(self, parameter: str) -> list[str]:
        """What each value of a parameter belongs to: chambers, markers, functions of a family; empty for one of all."""
        return [str(name) for name in self.parameters.get(parameter, {}).get("per") or []]
