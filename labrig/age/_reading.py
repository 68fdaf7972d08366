"""What one run says of its rig: readings, each a value with its standard deviation."""

from collections.abc import Sequence
from dataclasses import dataclass
from typing import TypedDict

import numpy as np

GROUPS = {
    "effect": "effects",
    "gain": "softness",
    "error": "error of the model",
    "floor": "noise floor",
    "leak": "leak rates",
    "zero": "pressure zeros",
    "lost": "markers lost",
    "frame": "cameras",
    "marker": "markers",
    "ambient": "ambient",
}
"""The groups of readings, in the order in which they are shown."""
LOGARITHMIC = {"error", "floor"}
"""Groups of positive values that scatter in proportion to themselves: they are compared as logarithms."""

SHOWN = {"ambient"}
"""Groups that are shown and never tested: a warm day is no change of the rig, and is like the day before it."""


class ReadingContent(TypedDict):
    """A reading as plain values."""

    group: str
    name: str
    value: list[float]
    sd: float | None
    unit: str


@dataclass(frozen=True)
class Reading:
    """A value of a run, with the standard deviation `sd` of each of its components; None where nothing says it.

    `value` has one component, or three where it is a place or a turn. `group` is a key of `GROUPS`.
    """

    group: str
    name: str
    value: tuple[float, ...]
    sd: float | None
    unit: str

    @property
    def key(self) -> tuple[str, str]:
        """What the same reading of another run has too."""
        return self.group, self.name

    def content(self) -> ReadingContent:
        """The reading as plain values."""
        return {
            "group": self.group,
            "name": self.name,
            "value": list(self.value),
            "sd": self.sd,
            "unit": self.unit,
        }

    @classmethod
    def of(cls, content: ReadingContent) -> "Reading":
        """A reading from what `content` gave."""
        value = tuple(content["value"])
        return cls(content["group"], content["name"], value, content["sd"], content["unit"])


def reading(group: str, name: str, value: float | Sequence[float], sd: float, unit: str) -> Reading | None:
    """A reading, rounded as a file keeps it; None where the value is not a number."""
    values = np.atleast_1d(np.asarray(value, dtype=float))
    if not np.isfinite(values).all():
        return None
    known = float(f"{sd:.4g}") if np.isfinite(sd) and sd > 0 else None
    return Reading(group, name, tuple(float(f"{v:.6g}") for v in values), known, unit)
