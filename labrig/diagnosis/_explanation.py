"""What an explanation is: a set of owners that act, each in some of its blocks, each at some size."""

from dataclasses import dataclass
from typing import NamedTuple

from labrig.arrays import Floats
from labrig.diagnosis._curves import MAP
from labrig.diagnosis._design import DECLARED, SLOW
from labrig.diagnosis._motions import MOTION
from labrig.diagnosis._unnamed import FORM, LEVER

STATIC = "?static"
"""What several pressures do together, by the set-point alone."""
CURVE = "?curve"
"""What goes by the set-point alone of a part whose name is that of what remembers, or goes on."""
OF_BASE = frozenset({"?" + FORM, "?" + LEVER, "?" + MOTION, "?" + MAP, CURVE})
"""The owners of the base's own error of form: it has no name, and is no mystery."""
REST = "?rest"
"""What is more than noise and that no space follows."""

Raised = tuple[tuple[str, int, float], ...]
"""What is raised in an explanation: owner, number of its block (-1: a free pattern), prior sd in floors; sorted.

An owner may have two blocks in it: a law that lies in two of its spaces.
"""


class Form(NamedTuple):
    """One form of a set of owners: its log evidence and prior, what is raised, and the sd of slow noise in floors."""

    score: float
    raised: Raised
    slow: float


@dataclass(frozen=True)
class Explanation:
    """One set of owners that act, in its likeliest form: `raised`; `score` its log evidence, over all its forms."""

    owners: frozenset[str]
    raised: Raised
    score: float
    slow: float


@dataclass(frozen=True)
class Posterior:
    """The explanations that were looked at, likeliest first, with their probabilities."""

    explanations: list[Explanation]
    probability: Floats


def split(raised: Raised) -> tuple[Raised, Raised]:
    """The free patterns of a form, and its other parts."""
    return tuple(part for part in raised if part[1] < 0), tuple(part for part in raised if part[1] >= 0)


def is_name(owner: str) -> bool:
    """Whether an owner is an effect."""
    return not owner.startswith("?") and owner not in (SLOW, DECLARED)
