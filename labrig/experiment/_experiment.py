"""An experiment: a programme, what it tells, and what a person can do besides."""

from collections.abc import Sequence
from dataclasses import dataclass, field

from labrig.contents import ProgrammePoint, Proposed
from labrig.experiment._again import Again
from labrig.experiment._plan import Limits, Point, repeat_labels


@dataclass(frozen=True)
class Experiment:
    """What to measure next.

    `summary` is the content of next.json; `points` the programme, as shares of each chamber's range, with a
    repeat label and a probe's name for each.
    """

    summary: Proposed
    points: tuple[Point, ...]
    repeats: tuple[str, ...]
    labels: tuple[str, ...]
    limits: Limits = field(repr=False)
    chambers: tuple[str, ...] = ()
    again: tuple[Again, ...] = ()
    """Programmes to be measured besides, each while somebody has ruled an effect out."""

    @property
    def attended(self) -> bool:
        """Whether somebody has to do something before the programme is measured."""
        return "ruled_out" in self.summary or "put_back" in self.summary

    def programme(self) -> list[ProgrammePoint]:
        """The points as the `programme` procedure takes them: chambers that are vented are left out."""
        return [*self._said(self.points, self.repeats, self.labels), *self._with_a_person()]

    def without(self, again: Again) -> list[ProgrammePoint]:
        """Those to be measured while an effect is ruled out, likewise."""
        repeats = repeat_labels(again.points, self.limits.rest)
        return self._said(again.points, repeats, [again.label] * len(again.points))

    def _said(
        self, points: Sequence[Point], repeats: Sequence[str], labels: Sequence[str]
    ) -> list[ProgrammePoint]:
        out: list[ProgrammePoint] = []
        for point, repeat, label in zip(points, repeats, labels, strict=True):
            actuation = self.limits.actuation(point.share)
            named = {c: float(u) for c, u in zip(self.chambers, actuation, strict=True) if u != 0.0}
            hold_s = round(point.hold_s, 2)
            if repeat:
                out.append({"pressure_kpa": named, "hold_s": hold_s, "repeat": repeat, "label": label})
            else:
                out.append({"pressure_kpa": named, "hold_s": hold_s, "label": label})
        return out

    def _with_a_person(self) -> list[ProgrammePoint]:
        """Points that need somebody at the rig first: offered, left out of an unattended run."""
        asked = [hand for hand in self.summary["by_hand"] if hand["points"]]
        out: list[ProgrammePoint] = []
        for hand in asked:
            middle = self.limits.actuation([0.5 * (r + 1.0) for r in self.limits.rest])
            named = {c: float(u) for c, u in zip(self.chambers, middle, strict=True)}
            label = f"{hand['effect']}, by hand"
            out.append({"hold_s": 4.0, "note": hand["what"], "by_hand": True, "label": label})
            out.append({"pressure_kpa": named, "hold_s": 4.0, "by_hand": True, "label": label})
        return out
