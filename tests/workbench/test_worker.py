"""The processes that compute for the pages: what never ends there is ended, and the next is answered."""

import threading
import time

import pytest

from labrig import LabrigError
from labrig.workbench._answers import told
from labrig.workbench._worker import Worker
from tests.waiting import wait_for


def test_what_never_ends_is_given_up() -> None:
    """After its time the process is ended, in words, and another one answers the next."""
    worker = Worker()
    try:
        with pytest.raises(LabrigError, match=r"^not done after 2 s, and given up$"):
            worker.ask_newest(2.0, time.sleep, 3600.0)
        assert worker.ask_newest(60.0, max, 1, 2) == 2
    finally:
        worker.close()


def test_the_newest_takes_the_place_of_what_takes_long() -> None:
    """Who asks next waits a moment and is answered; who was waiting is told so, and nothing of memory."""
    worker = Worker()
    said: list[str] = []

    def ask() -> None:
        try:
            worker.ask_newest(60.0, time.sleep, 3600.0)
        except LabrigError as error:
            said.append(str(error))

    waiting = threading.Thread(target=ask)
    try:
        assert worker.ask_newest(60.0, max, 1, 2) == 2
        waiting.start()
        wait_for(lambda: worker._newest is not None and not worker._newest.future.done(), "it was not asked")
        assert worker.ask_newest(60.0, max, 3, 4) == 4
        waiting.join(10.0)
        assert said == ["it took long, and another one was asked for meanwhile; ask again"]
    finally:
        worker.close()


def test_who_waits_while_it_closes_is_told_so() -> None:
    """A process that was ended on purpose was not lost for want of memory."""
    worker = Worker()
    assert worker.ask(max, 1, 2) == 2
    threading.Timer(0.5, worker.close).start()
    with pytest.raises(LabrigError, match=r"^the workbench is closing$"):
        worker.ask(time.sleep, 3600.0)


def test_a_moment_keeps_its_digits_beside_what_is_no_number() -> None:
    """One NaN in an answer becomes null, and leaves all else as exact as it is."""
    assert told({"t": 1767225601.5, "x": float("nan")}) == '{"t":1767225601.5,"x":null}'
