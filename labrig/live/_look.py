"""One look of the diagnosis at a campaign that goes on: what it said after so many captures."""

import math
from collections.abc import Mapping
from dataclasses import dataclass, field
from typing import Any

from labrig.contents import Errors, Summary
from labrig.run_contents import LookContent


@dataclass(frozen=True)
class Look:
    """What the diagnosis said of the first `captures` captures, `minutes` after the campaign began.

    `probability` is that of each effect which was considered, `by_evidence` what the evidence alone says of it; `error`
    the held-out root mean square error with what was found, `base` that without, `floor` the noise, `ceiling` what a
    smooth function of everything that was logged could reach, all four in `units`.
    """

    captures: int
    minutes: float
    verdict: str
    effects: tuple[str, ...] = ()
    probability: dict[str, float] = field(default_factory=dict)
    base: float = math.nan
    error: float = math.nan
    floor: float = math.nan
    ceiling: float = math.nan
    units: str = ""
    by_evidence: dict[str, float] = field(default_factory=dict)

    @property
    def left(self) -> float:
        """What is left to gain: by how much the error could still fall, to the floor or the ceiling."""
        return max(self.error - max(self.floor, self.ceiling), 0.0)

    def to_dict(self) -> LookContent:
        """Plain values, as JSON has them: what is not known is None."""
        return {
            "captures": self.captures,
            "minutes": self.minutes,
            "verdict": self.verdict,
            "effects": list(self.effects),
            "probability": dict(self.probability),
            "by_evidence": dict(self.by_evidence),
            "base": _known(self.base),
            "error": _known(self.error),
            "floor": _known(self.floor),
            "ceiling": _known(self.ceiling),
            "units": self.units,
        }

    @classmethod
    def from_dict(cls, plain: Mapping[str, Any]) -> "Look":
        """The inverse of `to_dict`; other keys are left out."""
        numbers = {
            name: math.nan if plain.get(name) is None else float(plain[name])
            for name in ("base", "error", "floor", "ceiling")
        }
        return cls(
            captures=int(plain["captures"]),
            minutes=float(plain["minutes"]),
            verdict=str(plain["verdict"]),
            effects=tuple(plain.get("effects") or ()),
            probability=_of_each(plain.get("probability")),
            by_evidence=_of_each(plain.get("by_evidence")),
            units=str(plain.get("units") or ""),
            **numbers,
        )

    @classmethod
    def of(cls, summary: Summary, captures: int, minutes: float) -> "Look":
        """The look of a diagnosis' summary (the content of diagnosis.json)."""
        error = summary.get("error") or Errors()
        return cls.from_dict(
            {
                "captures": captures,
                "minutes": minutes,
                "verdict": summary["verdict"],
                "effects": summary["effects"],
                **{
                    key: {
                        entry["effect"]: round(float(entry.get(key, 0.0)), 4)
                        for entry in summary.get("effects_considered") or ()
                    }
                    for key in ("probability", "by_evidence")
                },
                "base": error.get("base"),
                "error": error.get("model"),
                "floor": error.get("floor"),
                "ceiling": error.get("ceiling"),
                "units": summary.get("units"),
            }
        )


def _of_each(plain: Mapping[str, Any] | None) -> dict[str, float]:
    return {str(name): float(p) for name, p in (plain or {}).items()}


def _known(value: float) -> float | None:
    return value if math.isfinite(value) else None
