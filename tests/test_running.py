"""Processes that others can ask: what one leaves that was killed."""

import os
import subprocess
import sys
from pathlib import Path

import pytest

from labrig._running import GoneError, notes

WAITS = """
import sys
from labrig._running import Reception
reception = Reception("run", {}, lambda asked: 1)
print("up", flush=True)
sys.stdin.readline()
"""


def test_a_killed_process_leaves_nothing_once_it_was_asked(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    """Its note and its lock are removed by who finds that nobody answers."""
    monkeypatch.setenv("LABRIG_CACHE", str(tmp_path))
    command = [sys.executable, "-c", WAITS]
    with subprocess.Popen(
        command, stdin=subprocess.PIPE, stdout=subprocess.PIPE, text=True, env=dict(os.environ)
    ) as process:
        assert process.stdout is not None
        assert process.stdout.readline() == "up\n"
        (note,) = notes("run")
        assert note.ask("anything") == 1
        process.kill()
    with pytest.raises(GoneError, match="the run has ended"):
        note.ask("anything")
    assert list((tmp_path / "running").iterdir()) == []
