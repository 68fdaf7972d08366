"""The next set-points of a campaign that adapts: the probes that tell apart what the last look left open."""

from collections.abc import Sequence
from dataclasses import dataclass
from typing import TYPE_CHECKING

import numpy as np

from labrig._errors import LabrigError
from labrig.contents import ProgrammePoint, Summary

if TYPE_CHECKING:
    from xarray import Dataset

    from labrig.campaign import Plan, RigInfo, Steps
    from labrig.model import Model

MINUTES = 5.0
"""The longest programme that is proposed at a time: the next look proposes another."""
_NARROW = 0.05


@dataclass(frozen=True)
class Range:
    """The pressures that a plan uses, (C,) kPa, and how fast the rig changes them, (C,) kPa/s.

    What is proposed in the plan's place keeps to them.
    """

    low_kpa: tuple[float, ...]
    high_kpa: tuple[float, ...]
    slew_kpa_s: tuple[float, ...]

    @classmethod
    def of(cls, plan: "Plan", info: "RigInfo") -> "Range":
        """From vented to the plan's highest; a chamber that it hardly uses may have a twentieth of its range."""
        from labrig.campaign import Actuate

        used = np.array([step.pressure_kpa for step in plan.steps if isinstance(step, Actuate)], float)
        span = _NARROW * (info.max_kpa - info.min_kpa)
        rest = np.clip(0.0, info.min_kpa, info.max_kpa)
        low = np.maximum(np.minimum(used.min(axis=0, initial=np.inf), rest), info.min_kpa)
        high = np.minimum(np.maximum(used.max(axis=0, initial=-np.inf), low + span), info.max_kpa)
        slew = tuple(channel.slew_kpa_s for channel in info.channels)
        return cls(tuple(low.tolist()), tuple(high.tolist()), slew)


def propose(
    run: "Dataset",
    model: "Model",
    summary: Summary,
    low_kpa: Sequence[float],
    high_kpa: Sequence[float],
    slew_kpa_s: Sequence[float],
) -> list[ProgrammePoint]:
    """The points, as the `programme` procedure takes them, that settle best what a diagnosis leaves open.

    Empty where nothing is open, no programme would tell, or somebody has to rule an effect out first.
    """
    from labrig.experiment import Limits, propose_experiment

    limits = Limits(np.asarray(low_kpa, float), np.asarray(high_kpa, float), np.asarray(slew_kpa_s, float))
    try:
        found = propose_experiment(run, model, summary=summary, limits=limits, minutes=MINUTES)
    except LabrigError:
        return []
    if found.attended:
        return []
    return [point for point in found.programme() if not point.get("by_hand")]


def first_probe(points: Sequence[ProgrammePoint], most: int) -> int:
    """How many points belong to the first probe, `most` at most: a probe is not cut by the next proposal."""
    label = points[0].get("label")
    alike = next((k for k, point in enumerate(points) if point.get("label") != label), len(points))
    return min(alike, most)


def steps_of(points: Sequence[ProgrammePoint], rig: "RigInfo") -> "Steps":
    """Actuate, settle, record, for each point."""
    from labrig_procedures import Programme

    yield from Programme.model_validate({"points": list(points)}).steps(rig)
