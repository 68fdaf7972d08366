"""Runs that are stopped in the middle, at a moment that a test chooses."""

from collections.abc import Callable
from typing import Any

import pytest

from labrig.campaign import Interrupted
from labrig.log import LogWriter


def stop_after(steps: int, start: Callable[[], Any]) -> None:
    """Run or resume, and stop with Ctrl-C once so many more steps are done."""
    done = -1  # a log makes its own beginning durable first
    original = LogWriter.step_done

    def count(writer: LogWriter) -> None:
        nonlocal done
        original(writer)
        done += 1
        if done == steps:
            raise KeyboardInterrupt

    with pytest.MonkeyPatch.context() as patch:
        patch.setattr(LogWriter, "step_done", count)
        with pytest.raises(Interrupted):
            start()
