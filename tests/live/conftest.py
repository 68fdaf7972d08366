"""A rig that is simulated here, and a looker of the test's own in place of the process."""

from collections.abc import Callable
from pathlib import Path
from typing import Any

import pytest

from labrig.live import Look
from labrig.rig import RigConfig, parse_rig

RIG = {
    "name": "bench",
    "chambers": [{"name": f"c{n}", "max_kpa": 60} for n in range(1, 5)],
    "markers": ["m01", "m03", "m06", "m09", "m11", "m16"],
    "pressure": {"kind": "simulated"},
    "mocap": {"kind": "simulated", "rate_hz": 20},
    "simulated": {"surface": "membrane", "seed": 0},
}


@pytest.fixture
def config(tmp_path: Path) -> RigConfig:
    """A small simulated rig."""
    return parse_rig(RIG, "rig.yaml", tmp_path)


def said(captures: int, creep: float) -> dict[str, Any]:
    """An answer in which creep has this probability."""
    verdict = "identified" if creep >= 0.9 else "confounded" if creep >= 0.1 else "nothing_missing"
    sure = ("creep",) if creep >= 0.9 else ()
    look = Look(captures, captures / 10, verdict, sure, {"creep": creep}, 0.8, 0.3, 0.1, 0.1, "mm")
    return {"look": look.to_dict()}


class Told:
    """Answers as it is told; `answer` maps captures to an answer, or None for one that never comes."""

    def __init__(self, answer: Callable[[int], dict[str, Any] | None]) -> None:
        self._answer, self._now = answer, None
        self.asked: list[int] = []
        self.questions: list[dict[str, Any]] = []
        self.busy = False

    @property
    def idle(self) -> bool:
        """Whether it can be asked."""
        return not self.busy

    def ask(self, question: dict[str, Any]) -> None:
        """Ask for a look."""
        self.asked.append(question["captures"])
        self.questions.append(question)
        self._now = self._answer(question["captures"])
        self.busy = True

    def found(self) -> dict[str, Any] | None:
        """The answer."""
        now, self._now = self._now, None
        self.busy = self.busy and now is None
        return now

    wait = found
