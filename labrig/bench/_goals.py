"""What the benchmark is to reach, and whether it does."""

from collections.abc import Mapping
from dataclasses import dataclass
from typing import Any, Literal

from labrig.bench.records import GoalFigure, Interval

Status = Literal["met", "open", "missed"]


@dataclass(frozen=True)
class Goal:
    """A figure (a class's or one of all campaigns) and the bound that it is to keep."""

    what: str
    path: tuple[str, ...]  # where the figure is in the figures of a half
    sign: Literal[">=", "<="]
    bound: float
    percent: bool = True

    @property
    def text(self) -> str:
        """The bound for people."""
        return f"{self.sign} {100 * self.bound:.0f} %" if self.percent else f"{self.sign} {self.bound:g}"


GOALS = (
    Goal("single: right", ("classes", "single", "right"), ">=", 0.90),
    Goal("pair: right", ("classes", "pair", "right"), ">=", 0.75),
    Goal("structural: right", ("classes", "structural", "right"), ">=", 0.85),
    Goal("true effects called sure", ("totals", "true_sure"), ">=", 0.85),
    Goal("true effects called sure or possible", ("totals", "true_possible"), ">=", 0.96),
    Goal("campaigns in which a wrong effect is called sure", ("totals", "wrong_sure"), "<=", 0.04),
    Goal("outside and deleted: unknown", ("totals", "unknown_recall"), ">=", 0.80),
    Goal("null: false alarms", ("classes", "null", "false_alarms"), "<=", 0.02),
    Goal("null-slow: false alarms", ("classes", "null-slow", "false_alarms"), "<=", 0.05),
    Goal("verdicts: calibration error", ("totals", "verdict_ece"), "<=", 0.05, percent=False),
    Goal("effects: calibration error", ("totals", "effect_ece"), "<=", 0.05, percent=False),
    Goal("fresh drop, tenth percentile", ("totals", "fresh_drop_p10"), ">=", 0.85, percent=False),
)
MOST_DIFFERENCE = 0.05
"""Right verdicts of the two halves may differ by this share."""


def status(sign: str, bound: float, figure: Interval) -> Status:
    """`met` if even the unfavourable end of the interval keeps the bound, `open` if only the figure itself does.

    A figure of too few campaigns to resample stays open.
    """
    worst, turn = (figure["low"], 1.0) if sign == ">=" else (figure["high"], -1.0)
    if turn * figure["value"] < turn * bound:
        return "missed"
    return "met" if turn * worst >= turn * bound and not figure.get("few") else "open"


def judged(figures: Mapping[str, Any]) -> list[GoalFigure]:
    """Every goal of which the figures of a half say something: what, goal, figure, status."""
    out: list[GoalFigure] = []
    for goal in GOALS:
        figure: Any = figures
        for key in goal.path:
            figure = (figure or {}).get(key)
        if figure is not None:
            out.append(
                {
                    "what": goal.what,
                    "goal": goal.text,
                    "percent": goal.percent,
                    "figure": figure,
                    "status": status(goal.sign, goal.bound, figure),
                }
            )
    return out


def alike(difference: Interval) -> Status:
    """Whether two halves are as near to each other as they should be."""
    if max(-difference["low"], difference["high"]) <= MOST_DIFFERENCE:
        return "met"
    return "open" if abs(difference["value"]) <= MOST_DIFFERENCE else "missed"
