"""Waiting for what another thread, process or page does."""

import time
from collections.abc import Callable
from typing import Any


def wait_for(condition: Callable[[], Any], what: str = "it never happened", seconds: float = 180.0) -> Any:
    """Wait until a condition holds, and give back what it gave; fails with `what` after so many seconds.

    It looks often at first, so that what is quick is not waited for, then every 50 ms.
    """
    end, pause = time.monotonic() + seconds, 0.001
    while not (result := condition()):
        assert time.monotonic() < end, f"{what}, after {seconds:g} s"
        time.sleep(pause)
        pause = min(1.5 * pause, 0.05)
    return result
