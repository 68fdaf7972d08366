"""An investigation on a rig: measure, diagnose, measure what settles the doubt, add it, and confirm, in a loop."""

from labrig.investigation._loop import investigate
from labrig.investigation._reporter import Lines, Reporter
from labrig.investigation._state import STATE, Settings, State, read_state

__all__ = ["STATE", "Lines", "Reporter", "Settings", "State", "investigate", "read_state"]
