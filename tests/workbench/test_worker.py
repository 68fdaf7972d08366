"""The processes that compute for the pages: what never ends there is ended, and the next is answered."""

import time

import pytest

from labrig import LabrigError
from labrig.workbench._worker import Worker


def test_what_never_ends_is_given_up() -> None:
    """After its time the process is ended, in words, and another one answers the next."""
    worker = Worker()
    try:
        with pytest.raises(LabrigError, match=r"^not done after 2 s, and given up$"):
            worker.ask_within(2.0, time.sleep, 3600.0)
        assert worker.ask_within(60.0, max, 1, 2) == 2
    finally:
        worker.close()
