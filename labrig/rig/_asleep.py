"""How long the computer slept: its clocks stand still meanwhile, and the chambers keep their pressure."""

import time

_CLOCKS = (("CLOCK_BOOTTIME", "CLOCK_MONOTONIC"), ("CLOCK_MONOTONIC_RAW", "CLOCK_UPTIME_RAW"))
"""Of Linux and of macOS: one that goes on in a sleep, and one that does not. All of Windows' go on."""


def asleep_s() -> float:
    """For how long the computer has slept since it was started, s; 0 where no clock leaves that out."""
    for awake, not_asleep in _CLOCKS:
        if hasattr(time, awake) and hasattr(time, not_asleep):
            return time.clock_gettime(getattr(time, awake)) - time.clock_gettime(getattr(time, not_asleep))
    return 0.0
