"""How a run ended, in words: of a signal nobody in a lab needs to know the name."""

import os
import signal
import sys
from pathlib import Path
from types import SimpleNamespace

import pytest
import yaml

import labrig
from labrig.campaign import Interrupted, Progress
from labrig.catalogue import Row
from labrig.log import summarise
from labrig.workbench import open_desk
from labrig.workbench._ended import conclusion_said, events_said
from labrig.workbench._live import now
from labrig.workbench._run import as_now, row_of
from tests.rigs import RIG

ENDED = "ended by another program or a shutdown (SIGTERM)"


@pytest.mark.skipif(sys.platform == "win32", reason="signals are sent as POSIX does")
def test_a_run_that_a_signal_ended_says_who_ended_it(tmp_path: Path) -> None:
    """In the list, beside the run, in Watch and in its last event: who ended it, and that it was vented."""
    (tmp_path / "rig.yaml").write_text(
        yaml.safe_dump(RIG | {"simulated": {"surface": "membrane"}}), encoding="utf-8"
    )

    def ended(progress: Progress) -> None:
        if progress.captures_done:
            os.kill(os.getpid(), signal.SIGTERM)

    with pytest.raises(Interrupted):
        labrig.run("capture", tmp_path / "rig.yaml", out=tmp_path / "one", captures=6, progress=ended)
    assert summarise(tmp_path / "one").state == "SIGTERM"
    desk = open_desk(tmp_path)
    assert row_of(desk, tmp_path / "one").state == f"{ENDED}; vented"
    told = now(desk, "one", 0.0, 0)
    assert (told["state"], told["vented"], told["events"][-1][3]) == (ENDED, True, ENDED)


def test_a_run_that_was_gone_on_with_keeps_who_ended_it_before() -> None:
    """What ended the first part is told in the same words as before, though the run has another state by now."""
    events = [(78.0, "the workbench"), (80.0, "resumed after 3 completed steps"), (120.0, "completed")]
    told = events_said(SimpleNamespace(events=events, state="completed"), 30)  # type: ignore[arg-type]
    assert told == [(78.0, "ended by End in the workbench"), *events[1:]]


@pytest.mark.parametrize("state", ["completed", "imported", "NOT VENTED: c1: no answer; Ctrl-C", "c1: lost"])
def test_what_says_more_stays_as_it_is(state: str) -> None:
    """Nothing is said to be vented that is not, and an error keeps its words."""
    assert as_now(Row(run="one", state=state), Path("one"), set()).state == state


def test_an_investigation_says_who_ended_its_run() -> None:
    """In its conclusion as in the list of runs; what is no end by somebody stays as it is."""
    told = "Interrupted: stopped by SIGTERM after 3 steps and 1 captures; the chambers are vented."
    assert conclusion_said(told) == told.replace("stopped by SIGTERM", ENDED)
    settled = "Leak: with it the error falls from 1.4 to 0.2 mm on captures recorded after the verdict."
    assert conclusion_said(settled) == settled
