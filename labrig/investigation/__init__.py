"""An investigation on a rig: measure, diagnose, measure what settles the doubt, add it, and confirm, in a loop."""

from labrig.investigation._loop import investigate
from labrig.investigation._reporter import Lines, Reporter
from labrig.investigation._state import HIGHEST, OPEN, STATE, Settings, State, highest_of, read_state

__all__ = [
    "HIGHEST",
    "OPEN",
    "STATE",
    "Lines",
    "Reporter",
    "Settings",
    "State",
    "highest_of",
    "investigate",
    "read_state",
]
