"""The processes that compute for the pages: what never ends there is ended, and the next is answered."""

import os
import time

import psutil
import pytest

from labrig import LabrigError
from labrig.workbench._worker import Worker
from tests.benches import unshare


def test_what_never_ends_is_given_up(monkeypatch: pytest.MonkeyPatch) -> None:
    """After its time the process is ended, in words, and another one answers the next; with the worker it ends."""
    unshare(monkeypatch)
    worker = Worker()
    try:
        with pytest.raises(LabrigError, match=r"^not done after 2 s, and given up$"):
            worker.ask_within(2.0, time.sleep, 3600.0)
        process = psutil.Process(worker.ask_within(60.0, os.getpid))
    finally:
        worker.close()
    assert not process.is_running()
