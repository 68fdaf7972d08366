"""The process beside a campaign: whatever it does, nobody waits for it and nothing of it is left."""

import sys
import time

import pytest

from labrig.live import Looker

ECHO = "import sys\nfor line in sys.stdin: print(line.strip(), flush=True)"
HANGS = "import time\ntime.sleep(600)"
DIES = "raise SystemExit(3)"


def looker(code: str, longest_s: float = 30.0) -> Looker:
    """A looker whose process runs this."""
    return Looker([sys.executable, "-c", code], longest_s)


def test_one_question_one_answer() -> None:
    """An answer comes back, once, and only then it can be asked again."""
    asked = looker(ECHO)
    try:
        assert asked.idle
        assert asked.found() is None
        asked.ask({"captures": 8})
        assert not asked.idle
        assert asked.wait() == {"captures": 8}
        assert asked.idle
        assert asked.found() is None
    finally:
        asked.close(None)


def test_one_that_hangs_is_ended_and_tried_again() -> None:
    """After its longest time a look is given up with a word of it, and another process stands ready."""
    asked = looker(HANGS, 0.2)
    try:
        asked.ask({})
        first = asked._process
        assert asked.wait() == {"trouble": "a diagnosis took longer than 0.2 s; it is tried again"}
        assert first is not None
        assert first.poll() is not None
        assert asked.idle
        assert asked._process is not first
    finally:
        asked._kill()
        asked.close(None)


def test_one_that_dies_is_started_three_times() -> None:
    """A process that dies is started anew, three times in all; then the campaign goes on without."""
    asked = looker(DIES)
    troubles = []
    while asked.idle:
        asked.ask({})
        troubles.append((asked.wait() or {})["trouble"])
    ended = "the process of the diagnosis has ended (out of memory?)"
    assert troubles == [f"{ended}; it is tried again"] * 2 + [
        f"{ended}, 3 times; the campaign goes on without"
    ]
    asked.ask({})
    assert asked.found() is None
    asked.close(None)


def test_a_program_that_does_not_exist_is_no_looker() -> None:
    """Without its program nothing can be asked, and nothing is raised."""
    asked = Looker(["/no/such/program"])
    assert not asked.idle
    assert asked.found() is None
    asked.close(None)


def test_the_end_is_told_and_the_process_is_gone() -> None:
    """`close` says why the campaign ended and waits until the process has drawn that."""
    told = looker("import sys\nassert 'settled' in sys.stdin.read(); sys.exit(7)")
    process = told._process
    told.close("settled")
    assert process is not None
    assert process.returncode == 7
    assert not told.idle


def test_asking_and_finding_do_not_wait(monkeypatch: pytest.MonkeyPatch) -> None:
    """Neither a question nor looking for an answer sleeps, whatever the process does."""
    asked = looker(HANGS)
    monkeypatch.setattr(time, "sleep", lambda s: pytest.fail("it slept"))
    asked.ask({})
    assert asked.found() is None
    asked._kill()
    asked.close(None)
