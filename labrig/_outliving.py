"""Processes that may go on after whoever began them: a guard that still vents, a run, the vent button."""

import signal
import subprocess
from typing import Any

_GOING: "list[subprocess.Popen[Any]]" = []


def outlives(process: "subprocess.Popen[Any]") -> None:
    """Keep hold of such a process until it has ended: Python calls one that is let go of a leak."""
    _GOING[:] = [each for each in (*_GOING, process) if each.poll() is None]


def outlives_terminal(name: str) -> bool:
    """Whether a signal is that of a terminal that is closed, and this process was started not to hear it (`nohup`)."""
    return name == "SIGHUP" and signal.getsignal(signal.SIGHUP) == signal.SIG_IGN
