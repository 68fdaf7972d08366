"""The captures and actuations of a run that goes on, in memory: enough to hold a model against them meanwhile."""

from dataclasses import dataclass, field
from typing import Any

import numpy as np
from numpy.typing import NDArray

from labrig.campaign._steps import Actuate, Completed, Record, Recording, Vent
from labrig.run_contents import CaptureFacts, NewCaptures

MOST = 20_000
"""Captures that are kept; a run of 34 markers needs some 15 MB for so many."""

_AT_ONCE = 200


@dataclass
class Kept:
    """What each capture was commanded to, and the means of what it measured; and every actuation before it.

    `captures` rows: C set-points and C measured pressures, kPa, then M x 3 positions, mm; NaN where not seen.
    """

    chambers: int
    actuations: list[tuple[float, tuple[float, ...]]] = field(default_factory=list)
    facts: list[CaptureFacts] = field(default_factory=list)
    values: list[NDArray[np.float32]] = field(default_factory=list)

    def vented(self, time_s: float) -> None:
        """The chambers were vented, by a step or in a pause."""
        self.actuations.append((time_s, (0.0,) * self.chambers))

    def done(self, completed: Completed) -> None:
        """A step is done: an actuation, a vent, or a capture that counts."""
        step, result = completed.step, completed.result
        if isinstance(step, Actuate):
            self.actuations.append((completed.started_s, tuple(step.pressure_kpa)))
        elif isinstance(step, Vent):
            self.vented(completed.started_s)
        elif isinstance(step, Record) and isinstance(result, Recording) and not result.missed:
            self._capture(completed, step, result)

    def _capture(self, completed: Completed, step: Record, result: Recording) -> None:
        if not self.actuations or len(self.facts) >= MOST:
            return
        time_s, commanded = self.actuations[-1]
        moment_s = float(np.mean(result.time_s)) if len(result.time_s) else completed.ended_s
        pressure = result.mean_kpa if len(result.pressure_kpa) else np.full(self.chambers, np.nan)
        position = (
            result.mean_mm if len(result.position_mm) else np.full(result.position_mm.shape[1:], np.nan)
        )
        self.facts.append(
            {
                "step": completed.index,
                "time_s": moment_s,
                "hold_s": moment_s - time_s,
                "event": len(self.actuations) - 1,
                "label": step.label,
                "repeat": step.repeat,
            }
        )
        self.values.append(np.concatenate([commanded, pressure, position.ravel()]).astype(np.float32))

    def since(self, capture: int, actuation: int) -> NewCaptures:
        """What came after so many captures and actuations, as plain values; of many captures a part."""
        plain = listed(self.values[capture : capture + _AT_ONCE], 3)
        facts = self.facts[capture : capture + len(plain)]
        return {
            "captures": [{**about, "values": row} for about, row in zip(facts, plain, strict=True)],
            "actuations": [[time_s, list(pressure)] for time_s, pressure in self.actuations[actuation:]],
        }


def listed(values: Any, digits: int) -> list[Any]:
    """Numbers with so many decimals, None where there is none, in lists as the array has axes."""
    rounded = np.round(np.asarray(values, float), digits)
    plain = rounded.astype(object)
    plain[~np.isfinite(rounded)] = None
    return plain.tolist()
